"""Writes the records of one MCAP file: declarations, chunks of messages with their index, and the summary.

Written to the MCAP specification (https://mcap.dev/spec, version 0). The mcap library's own writer leaves zstd's level
and the places of declarations open to nobody, and takes longer for a message; its record classes are used for all else.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Mapping
from typing import Protocol

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

from seat_gear_dynamics.logs.batch import Batch, Integers
from seat_gear_dynamics.logs.chunk_body import ChunkBody

_CHUNK = struct.Struct("<QQQI")  # first and last log time, bytes unpacked, checksum
_FRAME = struct.Struct("<BQ")
_REPEAT = 32
"""Every so many chunks one begins with all declarations, so that a log whose beginning is lost can still be read."""


class Sink(Protocol):
    """What takes the bytes: an append-only file."""

    def write(self, data: bytes) -> int:
        """Append `data` whole and return its length in bytes."""
        ...

    def tell(self) -> int:
        """Bytes appended so far."""
        ...


class ChunkWriter:
    """One MCAP file: `start`, then declarations, messages and metadata in any order, then `finish`.

    Schemas and channels stand in the chunk during which they are declared, under its checksum, and again in the second
    chunk and now and then later. A chunk is closed when its messages are more than `chunk_size` bytes. `pack` and
    `compression` are a codec and MCAP's name of it. Errors of the file pass through; a chunk that failed to be written
    is gone.
    """

    def __init__(self, file: Sink, *, chunk_size: int, compression: str, pack: Callable[[bytes], bytes]) -> None:
        self._file = file
        self._chunk_size = chunk_size
        self._compression, self._pack = compression, pack
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}
        self._body = ChunkBody()
        self._full = chunk_size  # bytes of the chunk in progress at which it is closed

    def start(self, profile: str, library: str) -> None:
        """Write the magic bytes and the header."""
        self._file.write(MCAP0_MAGIC + _record(Header(profile, library)))

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Declare a message type and return its number."""
        schema = Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name)
        self._schemas.append(schema)
        self._body.append(_record(schema))
        return int(schema.id)

    def add_channel(self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]) -> int:
        """Declare a topic and return its number."""
        number = len(self._channels) + 1
        channel = Channel(id=number, topic=topic, message_encoding=encoding, schema_id=schema, metadata=dict(metadata))
        self._channels.append(channel)
        self._body.append(_record(channel))
        return number

    def add_metadata(self, name: str, data: Mapping[str, str]) -> None:
        """Write a metadata record behind the chunks written so far (the one in progress not counted)."""
        record = _record(Metadata(name=name, metadata=dict(data)))
        offset = self._file.tell()
        self._file.write(record)
        self._metadata.append(MetadataIndex(offset=offset, length=len(record), name=name))

    def add_message(self, channel: int, log_ns: int, data: bytes, publish_ns: int, sequence: int) -> bool:
        """Append a message to the chunk in progress; return whether that closed the chunk."""
        if not self._body.count:
            self._begin_chunk()
        self._body.add(channel, log_ns, data, publish_ns, sequence)
        return self._close_if_full()

    def add_batch(
        self, batch: Batch, begin: int, end: int, channels: Integers, sequences: Integers
    ) -> tuple[int, bool]:
        """Append messages from `begin` to `end`, or until the chunk closes; return the next place, and whether it did.

        `channels` and `sequences` as in `ChunkBody.add_batch`.
        """
        if not self._body.count:
            self._begin_chunk()
        place = self._body.add_batch(batch, begin, end, self._full, channels, sequences)
        return place, self._close_if_full()

    def _close_if_full(self) -> bool:
        if self._body.size <= self._full:
            return False
        self.flush()
        return True

    def flush(self) -> None:
        """Close the chunk in progress and hand it to the file, with its message index, in one write."""
        body = self._body
        if not body.count:
            return
        content, (start, end) = body.content(), body.span()
        packed, name = self._pack(content), self._compression.encode()
        fields = _CHUNK.pack(start, end, len(content), zlib.crc32(content)) + struct.pack("<I", len(name)) + name
        chunk = _FRAME.pack(Opcode.CHUNK, len(fields) + 8 + len(packed)) + fields + struct.pack("<Q", len(packed))
        offset, length = self._file.tell(), len(chunk) + len(packed)
        counts, offsets, indexes = body.indexes(offset + length)
        body.clear()  # before the file can refuse: a chunk that failed is gone
        self._file.write(b"".join((chunk, packed, indexes)))
        for channel, count in counts.items():
            self._counts[channel] = self._counts.get(channel, 0) + count
        self._chunks.append(
            ChunkIndex(
                chunk_length=length,
                chunk_start_offset=offset,
                compression=self._compression,
                compressed_size=len(packed),
                message_end_time=end,
                message_index_length=len(indexes),
                message_index_offsets=offsets,
                message_start_time=start,
                uncompressed_size=len(content),
            )
        )

    def finish(self) -> None:
        """Close the chunk in progress and write the summary and the footer."""
        self.flush()
        self._file.write(_record(DataEnd(0)))
        begin = self._file.tell()
        groups = (self._schemas, self._channels, [self._statistics()], self._chunks, self._metadata)
        summary, places = bytearray(), bytearray()
        for group in groups:
            records = b"".join(map(_record, group))
            if records:
                places += _record(SummaryOffset(records[0], begin + len(summary), len(records)))
            summary += records
        offsets = begin + len(summary)
        summary += places
        head = struct.pack("<BQQQ", Opcode.FOOTER, 20, begin, offsets)
        footer = Footer(summary_start=begin, summary_offset_start=offsets, summary_crc=zlib.crc32(summary + head))
        self._file.write(bytes(summary) + _record(footer) + MCAP0_MAGIC)

    def _begin_chunk(self) -> None:
        if len(self._chunks) % _REPEAT == 1:
            self._body.clear()
            self._body.append(b"".join(map(_record, (*self._schemas, *self._channels))))
        self._full = self._body.size + self._chunk_size

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            metadata_count=len(self._metadata),
            message_start_time=min((chunk.message_start_time for chunk in self._chunks), default=0),
            message_end_time=max((chunk.message_end_time for chunk in self._chunks), default=0),
            schema_count=len(self._schemas),
        )


class _Record(Protocol):
    def write(self, stream: RecordBuilder) -> None: ...


def _record(record: _Record) -> bytes:
    """Return a record's bytes with its frame."""
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data
