"""One MCAP file of a bag while it is being written: channels, messages, durable marks, an honest ending."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Literal, Protocol, cast

from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from seat_gear_dynamics.logs.disk import DurableFile
from seat_gear_dynamics.logs.metadata import FileRecord, TopicRecord, offered_qos
from seat_gear_dynamics.logs.schemas import schema

Compression = Literal["zstd", "lz4", "none"]
COMPRESSIONS: Mapping[str, CompressionType] = {
    "zstd": CompressionType.ZSTD,
    "lz4": CompressionType.LZ4,
    "none": CompressionType.NONE,
}


class _Library(Protocol):
    """The mcap library's writer as it is used here (the library leaves its return types open)."""

    def start(self, profile: str, library: str) -> None: ...
    def register_schema(self, name: str, encoding: str, data: bytes) -> int: ...
    def register_channel(
        self, topic: str, message_encoding: str, schema_id: int, metadata: Mapping[str, str]
    ) -> int: ...
    def add_message(self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int) -> None: ...
    def add_metadata(self, name: str, data: Mapping[str, str]) -> None: ...
    def finish(self) -> None: ...


_PRIVATE_FLUSH = "_Writer__finalize_chunk"


def _flush(library: _Library) -> None:
    """Close the chunk in progress and hand it to the file.

    Before mcap 1.6 the library has no public way to do so short of finishing the file, and a chunk of quiet
    topics can stay in memory for minutes; hence the one private method, under its mangled name.
    """
    flush = getattr(library, "flush", None) or getattr(library, _PRIVATE_FLUSH)
    flush()


def _ending() -> bytes:
    """Return the shortest valid end of an MCAP file: no summary, so readers scan the file from its start."""
    data_end = struct.pack("<BQI", Opcode.DATA_END, 4, 0)
    footer = struct.pack("<BQQQI", Opcode.FOOTER, 20, 0, 0, 0)
    return data_end + footer + MCAP0_MAGIC


class Segment:
    """One `NAME_i.mcap`; every method but `abandon` raises `OSError` when the disk refuses.

    `durable` describes what a power cut at this moment would leave: it moves only in `sync` and `finish`.
    """

    _ENDING = _ending()

    def __init__(self, path: Path, *, chunk_size: int, compression: Compression, library: str) -> None:
        self._file = DurableFile(path)
        self._counts: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._start: int | None = None
        self._end: int | None = None
        self.durable = FileRecord(path.name, None, None, {})
        self._durable_size = 0
        writer = Writer(cast(IO[bytes], self._file), chunk_size=chunk_size, compression=COMPRESSIONS[compression])
        self._library = cast(_Library, writer)
        try:
            self._library.start(profile="ros2", library=library)
        except OSError:
            self.abandon()
            raise

    @property
    def path(self) -> Path:
        """Where the file lies."""
        return self._file.path

    @property
    def size(self) -> int:
        """Bytes handed to the file so far (the chunk in progress not counted)."""
        return self._file.end

    @property
    def start_ns(self) -> int | None:
        """The smallest log time written (ns), None before the first message."""
        return self._start

    @property
    def usable(self) -> bool:
        """Whether at least the file's beginning is durable, so that it can be opened."""
        return self._durable_size > 0

    @property
    def removed(self) -> bool:
        """Whether somebody has deleted the file."""
        return self._file.removed

    def record(self) -> FileRecord:
        """Describe everything handed over so far, durable or not."""
        return FileRecord(self.path.name, self._start, self._end, dict(self._counts))

    def add_channel(self, topic: TopicRecord) -> None:
        """Declare a topic, with rosbag2's keys; its schema is written once per file."""
        if topic.type not in self._schemas:
            text = schema(topic.type).text.encode()
            self._schemas[topic.type] = self._library.register_schema(topic.type, "ros2msg", text)
        self._channels[topic.name] = self._library.register_channel(
            topic.name,
            "cdr",
            self._schemas[topic.type],
            {"offered_qos_profiles": offered_qos(topic.qos), "topic_type_hash": topic.type_hash},
        )

    def add_metadata(self, name: str, data: Mapping[str, str]) -> None:
        """Append a metadata record behind the chunks written so far."""
        self._library.add_metadata(name, data)

    def write(self, topic: str, data: bytes, log_ns: int, publish_ns: int, sequence: int) -> None:
        """Append one message of a declared topic."""
        self._library.add_message(self._channels[topic], log_ns, data, publish_ns, sequence)
        self._counts[topic] = self._counts.get(topic, 0) + 1
        self._start = log_ns if self._start is None else min(self._start, log_ns)
        self._end = log_ns if self._end is None else max(self._end, log_ns)
        if not self._file.sealed:  # the library has just closed a full chunk
            self._file.seal(self._ENDING)

    def sync(self) -> None:
        """Close the chunk in progress and return when all of it is on the disk under a valid ending."""
        _flush(self._library)
        self._file.seal(self._ENDING)
        self._settle()

    def finish(self) -> None:
        """Write summary and footer, sync and close: the file is complete and indexed."""
        self._library.finish()
        self._settle()
        self._file.close()

    def abandon(self) -> None:
        """Cut the file back to what was durable, end it without a summary if there is room, and close it.

        A file without a durable beginning is no MCAP file and is deleted.
        """
        if not self.usable:
            self._file.close()
            with suppress(OSError):
                self.path.unlink()
            return
        with suppress(OSError):
            self._file.rewind(self._durable_size)
            try:
                self._file.seal(self._ENDING)
            except OSError:
                self._file.rewind(self._durable_size)  # half an ending is worse than none
            self._file.sync()
        self._file.close()

    def _settle(self) -> None:
        self._file.sync()
        self._durable_size = self._file.end
        self.durable = self.record()
