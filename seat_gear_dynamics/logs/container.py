"""One MCAP file as found on disk, sound or not: channels, counts, metadata, blocks of messages, damage."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Footer, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream

from seat_gear_dynamics.logs.summary import FRAME, Summary, SummaryError, read_summary
from seat_gear_dynamics.logs.walk import IN_CHUNK, DamageError, Passed, belongs, frames, misfit

_TIMES = struct.Struct("<QQ")  # first and last log time, the beginning of a chunk's body
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time; the data follows
_LARGEST_CHUNK = 2**30  # bytes uncompressed; a greater number is taken for damage, not for a wish to be fulfilled
_LARGEST_RUN = 4_000_000  # bytes of unchunked messages that are read at a time


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

    def messages(self, channels: Collection[int], odd: Counter[int] | None = None) -> list[Message]:
        """Return the messages of these channels in the order they were written; raises `DamageError`.

        `odd` counts by opcode what is passed over and has no business in a block (`walk.belongs`).
        """
        return [
            Message(channel, log_ns, publish_ns, data[begin + _MESSAGE.size : end])
            for data, begin, end in self._records((Opcode.MESSAGE,), odd)
            for channel, _, log_ns, publish_ns in [_MESSAGE.unpack_from(data, begin)]
            if channel in channels
        ]

    def declare(self, contents: Contents) -> None:
        """Enter the block's schemas, channels and message counts into `contents`; raises `DamageError`."""
        for data, begin, end in self._records(IN_CHUNK):
            opcode = data[begin - FRAME.size]
            if opcode == Opcode.MESSAGE:
                contents.counts[_MESSAGE.unpack_from(data, begin)[0]] += 1
            else:
                _declare(contents, opcode, data[begin:end])

    def _records(self, opcodes: Collection[int], odd: Counter[int] | None = None) -> Iterator[tuple[bytes, int, int]]:
        data = self._content()
        position = 0
        while position < len(data):
            begin = position + FRAME.size
            if begin > len(data):
                raise DamageError(f"the block at byte {self.offset} ends inside a record")
            opcode, length = FRAME.unpack_from(data, position)
            position = begin + length
            if position > len(data) or (opcode == Opcode.MESSAGE and length < _MESSAGE.size):
                raise DamageError(f"the block at byte {self.offset} holds a record of impossible length")
            if opcode in opcodes:
                yield data, begin, position
            elif odd is not None and not belongs(opcode, IN_CHUNK):
                odd[opcode] += 1

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
    loose: int = 0
    """Messages outside chunks."""

    def type_of(self, channel: int) -> str:
        """Return the message type of a channel, empty when the file does not say."""
        schema = self.schemas.get(self.channels[channel].schema_id)
        return schema.name if schema else ""

    def numbers(self, topics: Collection[str]) -> dict[int, str]:
        """Return channel number → topic for these topics."""
        return {number: c.topic for number, c in self.channels.items() if c.topic in topics}


def scan(path: Path) -> Contents:
    """Read a file's structure, up to the first place where it stops making sense (noted in `damage`).

    A file that holds what its summary says is known without unpacking a chunk; another is unpacked chunk by chunk.
    Raises `OSError` when the file cannot be read at all.

    Limit: without a summary a chunk under a private opcode is known by its layout alone, and a message outside chunks
    under one not at all.
    """
    contents, passed, summary = Contents(path), Passed(), Summary()
    try:
        with open(path, "rb") as file:
            for opcode, offset, length in frames(file):
                if opcode == Opcode.FOOTER:
                    summary = _summary(contents, file, offset, length)
                else:
                    fault = _take(contents, file, opcode, offset, length)
                    passed.take(opcode, offset - FRAME.size, length, fault)
    except DamageError as damage:
        contents.damage.append(f"{path.name}: {damage}; what lies before is used.")
    _hold_against(contents, summary, passed)
    contents.damage += [f"{path.name}: {note}" for note in passed.notes()]
    return contents


def _take(contents: Contents, file: BinaryIO, opcode: int, offset: int, length: int) -> str | None:
    """Enter one record of the data section into `contents`; return what is wrong with it, None for nothing."""
    fault = misfit(file, opcode, offset, length)
    if fault is not None:
        return fault
    file.seek(offset)
    try:
        if opcode == Opcode.CHUNK:
            start, end = _TIMES.unpack(file.read(_TIMES.size))
            contents.blocks.append(Block(contents.path, offset, length, start, end, is_chunk=True))
        elif opcode == Opcode.MESSAGE:
            channel, _, log_ns, _ = _MESSAGE.unpack(file.read(_MESSAGE.size))
            if channel not in contents.channels:
                return "of a topic that was not declared"
            _extend_run(contents, offset, length, log_ns)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            _declare(contents, opcode, file.read(length))
        elif opcode == Opcode.METADATA:
            contents.metadata.append(Metadata.read(ReadDataStream(BytesIO(file.read(length)))))
    except Exception as cause:  # fields of a damaged record fail in many ways
        return f"that cannot be read ({cause})"
    return None


def _summary(contents: Contents, file: BinaryIO, offset: int, length: int) -> Summary:
    """Return what the end of the file says, nothing where it cannot be believed."""
    file.seek(offset)
    footer = Footer.read(ReadDataStream(BytesIO(file.read(length))))
    contents.closed = footer.summary_start > 0
    try:
        return read_summary(file, footer, offset - FRAME.size) if contents.closed else Summary()
    except SummaryError as error:
        contents.damage.append(f"{contents.path.name}: its summary is not used: {error}.")
        return Summary()


def _hold_against(contents: Contents, summary: Summary, passed: Passed) -> None:
    """Note what the summary says and the file has not, and learn how many messages there are."""
    contents.schemas |= summary.schemas
    contents.channels |= summary.channels
    found = {block.offset - FRAME.size for block in contents.blocks if block.is_chunk}
    passed.lack("chunks", sorted(summary.chunks - found), of=len(summary.chunks))
    said = summary.statistics
    if said is None:
        _count(contents)
        return
    passed.lack("metadata records", said.metadata_count - len(contents.metadata), of=said.metadata_count)
    chunks_whole = said.chunk_count <= len(found) and summary.chunks <= found
    loose_whole = said.chunk_count > 0 or said.message_count <= contents.loose
    named = (
        said.channel_count <= len(contents.channels) and contents.channels.keys() >= said.channel_message_counts.keys()
    )
    counted = said.channel_message_counts or not said.message_count
    if chunks_whole and loose_whole and named and counted:
        contents.counts.update(said.channel_message_counts)
        return
    _count(contents)
    passed.lack("messages", said.message_count - contents.counts.total(), of=said.message_count)


def _extend_run(contents: Contents, offset: int, length: int, log_ns: int) -> None:
    """Join an unchunked message to the run before it, or begin a new run."""
    contents.loose += 1
    frame = offset - FRAME.size
    last = contents.blocks[-1] if contents.blocks else None
    if last is None or last.is_chunk or last.offset + last.length != frame or last.length > _LARGEST_RUN:
        contents.blocks.append(Block(contents.path, frame, FRAME.size + length, log_ns, log_ns, is_chunk=False))
        return
    start, end = min(last.start_ns, log_ns), max(last.end_ns, log_ns)
    contents.blocks[-1] = Block(last.path, last.offset, last.length + FRAME.size + length, start, end, is_chunk=False)


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
    unnamed = sum(contents.counts.pop(number) for number in contents.counts.keys() - contents.channels.keys())
    if unnamed:
        contents.damage.append(f"{contents.path.name}: {unnamed} messages of topics that nothing declares, left out.")
