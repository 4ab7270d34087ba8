"""What a damaged bag says of itself: which files belong to it, and what its metadata.yaml still tells."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from mcap.records import Channel, Schema

from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.metadata import FILE_NAME
from seat_gear_dynamics.logs.recovery.declarations import Declarations
from seat_gear_dynamics.logs.schemas import schema

_LARGEST = 2**20  # bytes of a metadata.yaml that are parsed; enough for thousands of files


class ClaimedTopic(NamedTuple):
    """A topic as metadata.yaml lists it."""

    name: str
    type: str
    type_hash: str
    messages: int


@dataclass
class Claims:
    """The files to look into, and what metadata.yaml says; `problem` is a sentence where it could not be read."""

    files: list[Path]
    missing: list[str] = field(default_factory=list)
    topics: list[ClaimedTopic] = field(default_factory=list)
    custom_data: dict[str, str] = field(default_factory=dict)
    distro: str | None = None
    problem: str | None = None

    def declarations(self) -> Declarations:
        """Return the topics as this project's recorder numbers them: in the order of metadata.yaml, from 1.

        Only types that ROS 2 Jazzy knows, and under the hash that is stated with them.
        """
        found = Declarations()
        types: dict[str, int] = {}
        for number, topic in enumerate(self.topics, 1):
            types.setdefault(topic.type, len(types) + 1)
            try:
                known = schema(topic.type)
            except LogError:
                continue
            if known.hash != topic.type_hash:
                continue
            identity = types[topic.type]
            found.schemas[identity] = Schema(id=identity, data=known.text.encode(), encoding="ros2msg", name=known.name)
            found.channels[number] = Channel(
                id=number,
                topic=topic.name,
                message_encoding="cdr",
                metadata={"topic_type_hash": known.hash},
                schema_id=identity,
            )
        return found


def read_claims(log: Path) -> Claims:
    """Find the files of a bag directory, or take a single file; raises `LogError` where there is nothing to read.

    A metadata.yaml that is missing, damaged or stale costs nothing: every .mcap file in the folder that it lists, or
    that is numbered like one that it lists, belongs to the bag, and all of them do without it.
    """
    if log.is_file():
        return Claims([log])
    if not log.is_dir():
        raise LogError(f"There is no log {log}; expected a bag directory or an .mcap file.")
    present = sorted((path for path in log.glob("*.mcap") if path.is_file()), key=_natural)
    claims = Claims(present)
    names = _read_yaml(log / FILE_NAME, claims)
    if names:
        bases = {_natural(Path(name))[0] for name in names}
        claims.files = [path for path in present if path.name in names or _natural(path)[0] in bases] or present
        claims.missing = sorted(names - {path.name for path in present})
    if not claims.files:
        raise LogError(f"The folder {log} holds no .mcap file; expected a bag that rosbag2 or seat-gear has recorded.")
    return claims


def _natural(path: Path) -> tuple[str, int]:
    """Return a file's name without the number that splitting gives it, and the number."""
    match = re.fullmatch(r"(.*)_(\d+)", path.stem)
    return (match[1], int(match[2])) if match else (path.stem, -1)


def _read_yaml(path: Path, claims: Claims) -> set[str]:
    if not path.exists():
        claims.problem = f"{FILE_NAME} is missing."
        return set()
    try:
        with open(path, "rb") as file:
            text = file.read(_LARGEST + 1)
        if len(text) > _LARGEST:
            raise ValueError("it is too large to be believed")
        # Not the loader in C: deeply nested text overflows its stack and ends the process.
        information = yaml.safe_load(text)["rosbag2_bagfile_information"]
        names = {Path(_text(name)).name for name in information["relative_file_paths"]}
        topics = [_topic(entry) for entry in information["topics_with_message_count"]]
        custom = information.get("custom_data") or {}
        claims.custom_data = {_text(key): _text(value) for key, value in custom.items()}
        claims.distro = _text(information["ros_distro"]) if information.get("ros_distro") else None
    except Exception as cause:  # damaged YAML fails in many ways, too deep a nesting among them
        claims.problem = f"{FILE_NAME} cannot be read ({type(cause).__name__}) and is ignored."
        return set()
    claims.topics = topics
    return names


def _topic(entry: Mapping[str, Any]) -> ClaimedTopic:
    topic = entry["topic_metadata"]
    hash = _text(topic.get("type_description_hash") or "")
    return ClaimedTopic(_text(topic["name"]), _text(topic["type"]), hash, int(entry["message_count"]))


def _text(value: object) -> str:
    # Not of lists: YAML's aliases can make small ones of a text that has no end.
    if not isinstance(value, str | int | float):
        raise TypeError(f"expected a text, found {type(value).__name__}")
    return str(value)
