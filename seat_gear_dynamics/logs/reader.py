"""Reads bags: ours and other programs', whole or damaged, with metadata.yaml or without."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray

from seat_gear_dynamics.logs import series
from seat_gear_dynamics.logs.container import Block, scan
from seat_gear_dynamics.logs.errors import LogError, reason
from seat_gear_dynamics.logs.metadata import FILE_NAME, RECORD_NAME
from seat_gear_dynamics.logs.schemas import Decoder
from seat_gear_dynamics.logs.series import JointSeries, Status
from seat_gear_dynamics.logs.topics import DIAGNOSTIC_STATUS, FLOAT64, JOINT_STATE
from seat_gear_dynamics.logs.walk import DamageError


@dataclass(frozen=True)
class TopicInfo:
    """Type and number of messages of a topic."""

    type: str
    count: int


class BagMessage(NamedTuple):
    """A message as bytes: absolute topic, log and publish time (ns), CDR data."""

    topic: str
    log_time_ns: int
    publish_time_ns: int
    data: bytes


class DecodedMessage(NamedTuple):
    """A message as an object with the attributes of its ROS type."""

    topic: str
    log_time_ns: int
    publish_time_ns: int
    message: Any


_LOG_TIME = attrgetter("log_time_ns")


class Bag:
    """A bag directory, or a single `.mcap` file, opened for reading.

    `topics`: absolute name → type and count. `metadata`: the `system`, `system_hash` and `software_version`
    that our writer leaves, None in other programs' logs. `custom_data`: rosbag2's. `start_ns`, `end_ns`:
    first and last log time (0 when empty). `closed`: every file was finished by its writer. `damage`: None,
    or sentences about what could not be read; reading messages may add to it. Everything sound is read.

    Where a method takes a topic, a relative name such as `motor/speed` stands for the one topic of the log
    that ends so, whatever its namespace.
    """

    def __init__(self, path: Path | str) -> None:
        """Open; raises `LogError` when there is no log or nothing in it can be read."""
        self.path = Path(path)
        self._damage: list[str] = []
        self.custom_data: dict[str, str] = {}
        try:
            self._contents = [scan(file) for file in self._find_files()]
        except OSError as cause:
            raise LogError(f"The log {self.path} cannot be read: {reason(cause)}.") from cause
        self._damage += [note for contents in self._contents for note in contents.damage]
        self.files = tuple(contents.path for contents in self._contents)
        self.closed = all(contents.closed for contents in self._contents)
        self.topics = self._collect_topics()
        self.metadata = self._find_record()
        blocks = [block for contents in self._contents for block in contents.blocks]
        self.start_ns = min((block.start_ns for block in blocks), default=0)
        self.end_ns = max((block.end_ns for block in blocks), default=0)
        if not self.topics and self._damage:
            raise LogError(f"Nothing in the log {self.path} can be read: {self.damage}")

    @property
    def damage(self) -> str | None:
        """What could not be read, in sentences; None when nothing was found amiss."""
        return " ".join(dict.fromkeys(self._damage)) or None

    @property
    def message_count(self) -> int:
        """Messages of all topics."""
        return sum(info.count for info in self.topics.values())

    def resolve(self, topic: str) -> str:
        """Return the absolute name of `topic` in this log; raises `LogError` for none and for several."""
        if topic in self.topics:
            return topic
        tail = topic if topic.startswith("/") else "/" + topic
        found = [name for name in self.topics if name.endswith(tail)] if tail != topic else []
        if tail in found:
            return tail
        if len(found) == 1:
            return found[0]
        wrong = f"several topics called {topic!r} ({', '.join(found)})" if found else f"no topic {topic!r}"
        raise LogError(f"The log {self.path} has {wrong}; it holds {', '.join(sorted(self.topics)) or 'none'}.")

    def messages(self, topics: str | Iterable[str] | None = None) -> Iterator[BagMessage]:
        """Yield the messages of `topics` (all by default) in order of log time, ties as they were written.

        Streams: a message is held only while a block that is still to be read may come before it, so memory
        follows how far blocks overlap in time and not how long the log is. Raises `LogError` for an unknown topic
        (at the call) and when the disk fails. Limit: a block whose head gives a later first time than it holds
        (which no checksum covers) comes out of order.
        """
        wanted = self._wanted(topics)
        channels = {c.path: c.numbers(wanted) for c in self._contents}
        return self._messages(channels)

    def decoded(self, topics: str | Iterable[str] | None = None) -> Iterator[DecodedMessage]:
        """Yield like `messages`, with the message as an object; raises `LogError` for senseless bytes."""
        decoder = self._decoder()
        for topic, log_ns, publish_ns, data in self.messages(topics):
            message = decoder.decode(data, self.topics[topic].type)
            yield DecodedMessage(topic, log_ns, publish_ns, message)

    def scalars(self, topic: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return log time (s since `start_ns`) and value of a Float64 topic, each of shape (n,)."""
        return series.scalars(self.messages(self._typed(topic, FLOAT64)), self.start_ns)

    def joint(self, topic: str) -> JointSeries:
        """Return a JointState topic as arrays per joint name."""
        return series.joint(self.decoded(self._typed(topic, JOINT_STATE)), self.start_ns)

    def statuses(self, topic: str) -> list[Status]:
        """Return (time s since `start_ns`, level, message, values) of a DiagnosticStatus topic."""
        return series.statuses(self.decoded(self._typed(topic, DIAGNOSTIC_STATUS)), self.start_ns)

    def _typed(self, topic: str, type: str) -> str:
        name = self.resolve(topic)
        if self.topics[name].type != type:
            raise LogError(f"The topic {name} of {self.path} is {self.topics[name].type}; expected {type}.")
        return name

    def _wanted(self, topics: str | Iterable[str] | None) -> set[str]:
        if topics is None:
            return set(self.topics)
        return {self.resolve(topic) for topic in ([topics] if isinstance(topics, str) else topics)}

    def _messages(self, channels: dict[Path, dict[int, str]]) -> Iterator[BagMessage]:
        blocks = [(block, channels[c.path]) for c in self._contents if channels[c.path] for block in c.blocks]
        waiting: dict[int, list[BagMessage]] = {}  # by the rank of their block as written, each in order of time
        for rank, (block, names) in sorted(enumerate(blocks), key=lambda each: each[1][0].start_ns):
            # No block that is still to come holds anything earlier than this one's first message.
            yield from _leaving(waiting, block.start_ns)
            waiting[rank] = sorted(self._load(block, names), key=_LOG_TIME)
        yield from _leaving(waiting, None)

    def _load(self, block: Block, names: dict[int, str]) -> list[BagMessage]:
        odd: Counter[int] = Counter()
        try:
            found = block.messages(names, odd)
            for opcode, count in odd.items():
                self._damage.append(
                    f"{block.path.name}: {count} of the records in the block at byte {block.offset} have the opcode "
                    f"{opcode:#04x}, which this version of MCAP does not know there, passed over."
                )
            return [BagMessage(names[channel], log_ns, sent_ns, data) for channel, log_ns, sent_ns, data in found]
        except DamageError as damage:
            self._damage.append(f"{block.path.name}: {damage}; it is left out.")
            return []
        except OSError as cause:
            raise LogError(f"The log {self.path} cannot be read further: {reason(cause)}.") from cause

    def _decoder(self) -> Decoder:
        schemas = [s for contents in self._contents for s in contents.schemas.values()]
        texts = {s.name: s.data.decode(errors="replace") for s in schemas if s.encoding == "ros2msg"}
        return Decoder(texts)

    def _collect_topics(self) -> dict[str, TopicInfo]:
        types: dict[str, str] = {}
        counts: Counter[str] = Counter()
        for contents in self._contents:
            for number, channel in contents.channels.items():
                types.setdefault(channel.topic, contents.type_of(number))
                counts[channel.topic] += contents.counts[number]
        return {topic: TopicInfo(type, counts[topic]) for topic, type in types.items()}

    def _find_record(self) -> dict[str, str] | None:
        records = (record for contents in self._contents for record in contents.metadata)
        return next((dict(record.metadata) for record in records if record.name == RECORD_NAME), None)

    def _find_files(self) -> list[Path]:
        if self.path.is_file():
            return [self.path]
        if not self.path.is_dir():
            raise LogError(f"There is no log {self.path}; expected a bag directory or an .mcap file.")
        present = sorted((path for path in self.path.glob("*.mcap") if path.is_file()), key=_natural)
        listed = [self.path / Path(name).name for name in self._read_yaml()]
        for path in listed:
            if path not in present:
                self._damage.append(f"{path.name}, which metadata.yaml lists, is missing.")
        if listed:  # a crash right after a split leaves a file that is not listed yet; it belongs to the bag
            bases = {_base(path) for path in listed}
            present = [path for path in present if path in listed or _base(path) in bases]
        if not present:
            raise LogError(f"The folder {self.path} holds no .mcap file; expected a bag that rosbag2 can play.")
        return present

    def _read_yaml(self) -> list[str]:
        """Take what is of use from metadata.yaml and return the files it lists; a broken one is noted."""
        path = self.path / FILE_NAME
        if not path.exists():
            return []
        try:
            information = yaml.safe_load(path.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
            storage = str(information["storage_identifier"])
            compression = str(information.get("compression_mode") or "none").lower()
            names = [str(name) for name in information["relative_file_paths"]]
            self.custom_data = {str(k): str(v) for k, v in (information.get("custom_data") or {}).items()}
        except (OSError, yaml.YAMLError, UnicodeDecodeError, LookupError, TypeError, AttributeError) as cause:
            self._damage.append(f"metadata.yaml cannot be read ({type(cause).__name__}) and is ignored.")
            return []
        if storage != "mcap" or compression != "none":
            raise LogError(
                f"The log {self.path} has storage {storage!r} and rosbag2 compression {compression!r}; only "
                f"MCAP without outer compression can be read. Convert it with `ros2 bag convert`."
            )
        return names


def _leaving(waiting: dict[int, list[BagMessage]], until_ns: int | None) -> list[BagMessage]:
    """Take the messages before `until_ns` (None: all) out of `waiting` and return them in order."""
    found: list[BagMessage] = []
    ranks = sorted(waiting)
    for rank in ranks:
        messages = waiting.pop(rank)
        count = len(messages) if until_ns is None else bisect_left(messages, until_ns, key=_LOG_TIME)
        found += messages[:count]
        if count < len(messages):
            waiting[rank] = messages[count:]
    return sorted(found, key=_LOG_TIME) if len(ranks) > 1 else found  # stable, so that ties stay as they were written


def _base(path: Path) -> str:
    """Return a file's name without the number that splitting gives it."""
    return re.sub(r"_\d+$", "", path.stem)


def _natural(path: Path) -> tuple[str, int]:
    """Sort `_10` behind `_9`."""
    number = re.search(r"_(\d+)$", path.stem)
    return _base(path), int(number.group(1)) if number else -1
