"""One MCAP file of a bag while it is being written: channels, messages, durable marks, an honest ending."""

from __future__ import annotations

import errno
import struct
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from seat_gear_dynamics.logs.batch import Batch, Integers
from seat_gear_dynamics.logs.chunks import ChunkWriter
from seat_gear_dynamics.logs.disk import DurableFile
from seat_gear_dynamics.logs.metadata import FileRecord, TopicRecord, offered_qos
from seat_gear_dynamics.logs.presets import DEFAULT_LEVEL, codec
from seat_gear_dynamics.logs.schemas import schema


def _ending() -> bytes:
    """Return the shortest valid end of an MCAP file: no summary, so readers scan the file from its start."""
    data_end = struct.pack("<BQI", Opcode.DATA_END, 4, 0)
    footer = struct.pack("<BQQQI", Opcode.FOOTER, 20, 0, 0, 0)
    return data_end + footer + MCAP0_MAGIC


def size_of(path: Path) -> int:
    """Return the bytes of a finished file, 0 for one that is not there."""
    return path.stat().st_size if path.exists() else 0


class Segment:
    """One `NAME_i.mcap`; every method but `abandon` raises `OSError` when the disk refuses.

    `durable` describes what a power cut at this moment would leave: it moves only in `sync` and `finish`.
    """

    _ENDING = _ending()

    def __init__(
        self, path: Path, *, chunk_size: int, compression: str, library: str, level: int = DEFAULT_LEVEL
    ) -> None:
        name, pack = codec(compression, level)
        self._file = DurableFile(path)
        self._counts: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._start: int | None = None
        self._end: int | None = None
        self.durable = FileRecord(path.name, None, None, {})
        self._durable_size = 0
        self._records = ChunkWriter(self._file, chunk_size=chunk_size, compression=name, pack=pack)
        try:
            self._records.start(profile="ros2", library=library)
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

    def check_present(self) -> None:
        """Raise `FileNotFoundError` when somebody has deleted the file."""
        if self._file.removed:
            raise FileNotFoundError(errno.ENOENT, "the file has been deleted", str(self.path))

    def record(self) -> FileRecord:
        """Describe everything handed over so far, durable or not."""
        return FileRecord(self.path.name, self._start, self._end, dict(self._counts))

    def add_channel(self, topic: TopicRecord) -> None:
        """Declare a topic, with rosbag2's keys; its schema is declared once per file."""
        if topic.type not in self._schemas:
            text = schema(topic.type).text.encode()
            self._schemas[topic.type] = self._records.add_schema(topic.type, "ros2msg", text)
        self._channels[topic.name] = self._records.add_channel(
            topic.name,
            "cdr",
            self._schemas[topic.type],
            {"offered_qos_profiles": offered_qos(topic.qos), "topic_type_hash": topic.type_hash},
        )

    def add_metadata(self, name: str, data: Mapping[str, str]) -> None:
        """Append a metadata record behind the chunks written so far."""
        self._records.add_metadata(name, data)

    def write(self, topic: str, data: bytes, log_ns: int, publish_ns: int, sequence: int) -> None:
        """Append one message of a declared topic."""
        closed = self._records.add_message(self._channels[topic], log_ns, data, publish_ns, sequence)
        self._counts[topic] = self._counts.get(topic, 0) + 1
        if self._start is None or self._end is None:
            self._start = self._end = log_ns
        elif log_ns < self._start:
            self._start = log_ns
        elif log_ns > self._end:
            self._end = log_ns
        if closed:
            self._file.seal(self._ENDING)

    def write_batch(self, batch: Batch, begin: int, end: int, sequences: Integers) -> int:
        """Append messages of declared topics from `begin` to `end`, or until a chunk closes; return the next place.

        `sequences` has the next sequence number of each of the batch's names, and goes on counting in place.
        """
        channels = np.array([self._channels[name] for name in batch.names], np.int64)
        place, closed = self._records.add_batch(batch, begin, end, channels, sequences)
        for name, count in batch.part(slice(begin, place)).counts().items():
            self._counts[name] = self._counts.get(name, 0) + count
        first, last = int(batch.log_ns[begin:place].min()), int(batch.log_ns[begin:place].max())
        self._start = first if self._start is None else min(self._start, first)
        self._end = last if self._end is None else max(self._end, last)
        if closed:
            self._file.seal(self._ENDING)
        return place

    def sync(self) -> None:
        """Close the chunk in progress and return when all of it is on the disk under a valid ending."""
        self._records.flush()
        self._file.seal(self._ENDING)
        self._settle()

    def finish(self) -> None:
        """Write summary and footer, sync and close: the file is complete and indexed."""
        self._records.finish()
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
