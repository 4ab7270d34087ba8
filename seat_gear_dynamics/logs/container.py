"""One MCAP file as found on disk, sound or not: channels, counts, metadata, blocks of messages, damage."""

from __future__ import annotations

import os
import struct
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Footer, Metadata, Schema, Statistics
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

_FRAME = struct.Struct("<BQ")  # opcode, length of the body
_TIMES = struct.Struct("<QQ")  # first and last log time, the beginning of a chunk's body
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time; the data follows
_LARGEST_CHUNK = 2**30  # bytes uncompressed; a greater number is taken for damage, not for a wish to be fulfilled
_LARGEST_RUN = 4_000_000  # bytes of unchunked messages that are read at a time


class DamageError(Exception):
    """A place where a file stops making sense; never leaves this room."""


class Message(NamedTuple):
    """A message as stored: channel number within its file, times in ns, CDR bytes."""

    channel: int
    log_time_ns: int
    publish_time_ns: int
    data: bytes


class Block(NamedTuple):
    """A stretch of a file that holds messages: a chunk's body, or a run of messages outside chunks."""

    path: Path
    offset: int
    length: int
    start_ns: int
    end_ns: int
    is_chunk: bool

    def messages(self, channels: Collection[int]) -> list[Message]:
        """Return the messages of these channels in the order they were written; raises `DamageError`."""
        return [
            Message(channel, log_ns, publish_ns, data[begin + _MESSAGE.size : end])
            for data, begin, end in self._records(Opcode.MESSAGE)
            for channel, _, log_ns, publish_ns in [_MESSAGE.unpack_from(data, begin)]
            if channel in channels
        ]

    def declare(self, contents: Contents) -> None:
        """Enter the block's schemas, channels and message counts into `contents`; raises `DamageError`."""
        for data, begin, end in self._records(Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
            opcode = data[begin - _FRAME.size]
            if opcode == Opcode.MESSAGE:
                contents.counts[_MESSAGE.unpack_from(data, begin)[0]] += 1
            else:
                _declare(contents, opcode, data[begin:end])

    def _records(self, *opcodes: int) -> Iterator[tuple[bytes, int, int]]:
        data = self._content()
        position = 0
        while position < len(data):
            begin = position + _FRAME.size
            if begin > len(data):
                raise DamageError(f"the block at byte {self.offset} ends inside a record")
            opcode, length = _FRAME.unpack_from(data, position)
            position = begin + length
            if position > len(data) or (opcode == Opcode.MESSAGE and length < _MESSAGE.size):
                raise DamageError(f"the block at byte {self.offset} holds a record of impossible length")
            if opcode in opcodes:
                yield data, begin, position

    def _content(self) -> bytes:
        with open(self.path, "rb") as file:
            file.seek(self.offset)
            body = file.read(self.length)
        if not self.is_chunk:
            return body
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(body)))
            if chunk.uncompressed_size > _LARGEST_CHUNK:
                raise DamageError(f"the chunk at byte {self.offset} claims {chunk.uncompressed_size} bytes")
            stream, length = get_chunk_data_stream(chunk, validate_crc=True)
            return stream.read(length)
        except DamageError:
            raise
        except Exception as cause:  # each codec and each field has errors of its own; all mean the same here
            raise DamageError(f"the chunk at byte {self.offset} cannot be unpacked ({cause})") from cause


@dataclass
class Contents:
    """What one file holds. `closed`: it ends with a summary, so its writer finished it."""

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)
    blocks: list[Block] = field(default_factory=list)
    metadata: list[Metadata] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)
    closed: bool = False

    def type_of(self, channel: int) -> str:
        """Return the message type of a channel, empty when the file does not say."""
        schema = self.schemas.get(self.channels[channel].schema_id)
        return schema.name if schema else ""

    def numbers(self, topics: Collection[str]) -> dict[int, str]:
        """Return channel number → topic for these topics."""
        return {number: c.topic for number, c in self.channels.items() if c.topic in topics}


def scan(path: Path) -> Contents:
    """Read a file's structure, up to the first place where it stops making sense (noted in `damage`).

    A file with a summary is known without unpacking a chunk; one without is unpacked chunk by chunk.
    Raises `OSError` when the file cannot be read at all.
    """
    contents = Contents(path)
    statistics: Statistics | None = None
    try:
        with open(path, "rb") as file:
            for opcode, offset, length in _frames(file):
                found = _take(contents, file, opcode, offset, length)
                statistics = found or statistics
    except DamageError as damage:
        contents.damage.append(f"{path.name}: {damage}; what lies before is used.")
    if statistics is not None and statistics.channel_count <= len(contents.channels):
        contents.counts.update(statistics.channel_message_counts)
    else:
        _count(contents)
    return contents


def _frames(file: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, offset and length of the body of every record down to the footer."""
    size = os.fstat(file.fileno()).st_size
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise DamageError("it does not begin like an MCAP file")
    position = len(MCAP0_MAGIC)
    opcode = 0
    while opcode != Opcode.FOOTER:
        file.seek(position)
        head = file.read(_FRAME.size)
        if len(head) < _FRAME.size:
            raise DamageError(f"it ends at byte {size} without a footer")
        opcode, length = _FRAME.unpack(head)
        begin, position = position + _FRAME.size, position + _FRAME.size + length
        if position > size:
            raise DamageError(f"it ends at byte {size} inside a record that begins at byte {begin - 9}")
        yield opcode, begin, length
    file.seek(position)
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise DamageError("its last 8 bytes are not those of an MCAP file")


def _take(contents: Contents, file: BinaryIO, opcode: int, offset: int, length: int) -> Statistics | None:
    """Enter one record into `contents`; return it if it is the statistics."""
    try:
        if opcode == Opcode.CHUNK:
            start, end = _TIMES.unpack(file.read(_TIMES.size))
            contents.blocks.append(Block(contents.path, offset, length, start, end, is_chunk=True))
        elif opcode == Opcode.MESSAGE:
            _extend_run(contents, offset, length, _MESSAGE.unpack(file.read(_MESSAGE.size))[2])
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            _declare(contents, opcode, file.read(length))
        elif opcode == Opcode.METADATA:
            contents.metadata.append(Metadata.read(ReadDataStream(BytesIO(file.read(length)))))
        elif opcode == Opcode.STATISTICS:
            statistics: Statistics = Statistics.read(ReadDataStream(BytesIO(file.read(length))))
            return statistics
        elif opcode == Opcode.FOOTER:
            contents.closed = Footer.read(ReadDataStream(BytesIO(file.read(length)))).summary_start > 0
    except Exception as cause:  # fields of a damaged record fail in many ways
        raise DamageError(f"the record at byte {offset - _FRAME.size} cannot be read ({cause})") from cause
    return None


def _extend_run(contents: Contents, offset: int, length: int, log_ns: int) -> None:
    """Join an unchunked message to the run before it, or begin a new run."""
    frame = offset - _FRAME.size
    last = contents.blocks[-1] if contents.blocks else None
    if last is None or last.is_chunk or last.offset + last.length != frame or last.length > _LARGEST_RUN:
        contents.blocks.append(Block(contents.path, frame, _FRAME.size + length, log_ns, log_ns, is_chunk=False))
        return
    start, end = min(last.start_ns, log_ns), max(last.end_ns, log_ns)
    contents.blocks[-1] = Block(last.path, last.offset, last.length + _FRAME.size + length, start, end, is_chunk=False)


def _declare(contents: Contents, opcode: int, body: bytes) -> None:
    stream = ReadDataStream(BytesIO(body))
    try:
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            contents.schemas[schema.id] = schema
        else:
            channel = Channel.read(stream)
            contents.channels[channel.id] = channel
    except Exception as cause:  # see _take
        raise DamageError(f"a declaration of a topic or type cannot be read ({cause})") from cause


def _count(contents: Contents) -> None:
    """Unpack every block to learn channels and counts; a block that cannot be unpacked is noted, left out."""
    sound: list[Block] = []
    for block in contents.blocks:
        try:
            block.declare(contents)
            sound.append(block)
        except DamageError as damage:
            contents.damage.append(f"{contents.path.name}: {damage}; it is left out.")
    contents.blocks = sound
