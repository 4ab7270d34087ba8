"""The rosbag2 `metadata.yaml` (version 9), built from what is on disk and laid out as rosbag2 lays it out."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import yaml

from seat_gear_dynamics.logs.topics import Qos

Node: TypeAlias = "Mapping[str, Node] | Sequence[Node] | str | int | bool | None"

FILE_NAME = "metadata.yaml"
RECORD_NAME = "seat_gear_dynamics"  # our own MCAP metadata record
NO_TIME = 2**63 - 1  # rosbag2's starting time of a bag without messages
_PLAIN = re.compile(r"[A-Za-z/_][A-Za-z0-9/_.+-]*\Z")
_RESERVED = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"}
_FOREVER = {"sec": 9223372036, "nsec": 854775807}  # DDS's infinite duration as rosbag2 writes it


class TopicRecord(NamedTuple):
    """A topic of a bag: absolute name, type, type hash, offered quality of service."""

    name: str
    type: str
    type_hash: str
    qos: tuple[Qos, ...]


class FileRecord(NamedTuple):
    """A file of a bag: its name, first and last log time (ns; both None when empty), messages per topic."""

    name: str
    start_ns: int | None
    end_ns: int | None
    counts: Mapping[str, int]

    @property
    def message_count(self) -> int:
        """Messages of all topics in this file."""
        return sum(self.counts.values())


def document(topics: Iterable[TopicRecord], files: Sequence[FileRecord], custom: Mapping[str, str]) -> str:
    """Return the text of `metadata.yaml` for these topics and files; `custom` is rosbag2's custom_data."""
    return to_yaml({"rosbag2_bagfile_information": _information(topics, files, custom)}) + "\n"


def serialized(topics: Iterable[TopicRecord], files: Sequence[FileRecord], custom: Mapping[str, str]) -> str:
    """Return the text that rosbag2 keeps inside each MCAP file: the same facts without the outer key."""
    return to_yaml(_information(topics, files, custom))


def offered_qos(profiles: Iterable[Qos]) -> str:
    """Return the `offered_qos_profiles` text of an MCAP channel."""
    return to_yaml([_qos(profile) for profile in profiles])


def _information(
    topics: Iterable[TopicRecord], files: Sequence[FileRecord], custom: Mapping[str, str]
) -> Mapping[str, Node]:
    return {
        "version": 9,
        "storage_identifier": "mcap",
        **_span(files),
        "message_count": sum(file.message_count for file in files),
        "topics_with_message_count": [_topic(topic, files) for topic in topics],
        # Compression happens inside the MCAP chunks; these two speak of rosbag2's own, outside the storage.
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.name for file in files],
        "files": [_file(file) for file in files],
        "custom_data": dict(custom) or None,
        "ros_distro": "jazzy",
    }


def _span(files: Sequence[FileRecord]) -> dict[str, Node]:
    starts = [file.start_ns for file in files if file.start_ns is not None]
    ends = [file.end_ns for file in files if file.end_ns is not None]
    start = min(starts, default=NO_TIME)
    return {
        "duration": {"nanoseconds": max(ends, default=start) - start},
        "starting_time": {"nanoseconds_since_epoch": start},
    }


def _file(file: FileRecord) -> dict[str, Node]:
    span = _span([file])
    return {
        "path": file.name,
        "starting_time": span["starting_time"],
        "duration": span["duration"],
        "message_count": file.message_count,
    }


def _topic(topic: TopicRecord, files: Sequence[FileRecord]) -> dict[str, Node]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.type,
            "serialization_format": "cdr",
            "offered_qos_profiles": [_qos(profile) for profile in topic.qos],
            "type_description_hash": topic.type_hash,
        },
        "message_count": sum(file.counts.get(topic.name, 0) for file in files),
    }


def _qos(qos: Qos) -> dict[str, Node]:
    return {
        "history": qos.history,
        "depth": qos.depth,
        "reliability": qos.reliability,
        "durability": qos.durability,
        "deadline": _FOREVER,
        "lifespan": _FOREVER,
        "liveliness": "automatic",
        "liveliness_lease_duration": _FOREVER,
        "avoid_ros_namespace_conventions": False,
    }


def to_yaml(node: Node) -> str:
    """Return `node` in the block style of rosbag2's emitter: indented sequences, `~`, quoted blanks."""
    return "\n".join(_lines(node))


def _lines(node: Node) -> list[str]:
    if isinstance(node, Mapping):
        return [line for key, value in node.items() for line in _entry(_scalar(key), value)]
    if isinstance(node, Sequence) and not isinstance(node, str):
        return [line for item in node for line in _item(item)] or ["[]"]
    return [_scalar(node)]


def _entry(key: str, value: Node) -> list[str]:
    lines = _lines(value)
    if isinstance(value, str) or not isinstance(value, Mapping | Sequence):
        return [f"{key}: {lines[0]}"]
    return [f"{key}:", *("  " + line for line in lines)]


def _item(value: Node) -> list[str]:
    first, *rest = _lines(value)
    return [f"- {first}", *("  " + line for line in rest)]


def _scalar(value: Node) -> str:
    if value is None:
        return "~"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str) and (not _PLAIN.match(value) or value.lower() in _RESERVED):
        # PyYAML knows every escape that a double-quoted scalar needs; the width keeps it on one line.
        return str(yaml.safe_dump(value, default_style='"', width=2**31, allow_unicode=True)).rstrip("\n")
    return str(value)
