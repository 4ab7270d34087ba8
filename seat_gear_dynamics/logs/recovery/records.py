"""The shapes of MCAP records in a file that cannot be trusted: which bytes can be a record, and where it would end."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, Self, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema

T = TypeVar("T")
FRAME = struct.Struct("<BQ")  # opcode, length of the body
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time; the data follows
_U32, _U64 = struct.Struct("<I"), struct.Struct("<Q")
_LARGEST_TEXT = 2**24  # bytes of a declaration or metadata record; a greater one is taken for damage
_PIECE = 2**20  # bytes that are held at a time where a long stretch is only passed through


class DamageError(Exception):
    """Bytes that do not make sense; the text says why and never leaves this package but in a result."""


class Record(NamedTuple):
    """A record that is plausible where it stands: offsets of its frame and of the byte behind it."""

    opcode: int
    begin: int
    end: int

    @property
    def body(self) -> int:
        """Offset of the first byte behind the frame."""
        return self.begin + FRAME.size


class Source:
    """A file that is only read. Raises `OSError` as the system does."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = open(path, "rb", buffering=2**16)  # noqa: SIM115  # closed by __exit__
        self.size = os.fstat(self._file.fileno()).st_size

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def read(self, begin: int, end: int) -> bytes:
        """Return the bytes from `begin` to `end`, fewer where the file ends before."""
        if begin >= end:
            return b""
        self._file.seek(begin)
        return self._file.read(end - begin)

    def pieces(self, begin: int, end: int) -> Iterator[bytes]:
        """Yield the bytes from `begin` to `end`, at most 1 MiB at a time."""
        while begin < end:
            piece = self.read(begin, min(begin + _PIECE, end))
            if not piece:
                return
            yield piece
            begin += len(piece)

    def crc(self, begin: int, end: int) -> int:
        """Return the CRC-32 of the bytes from `begin` to `end`."""
        value = 0
        for piece in self.pieces(begin, end):
            value = zlib.crc32(piece, value)
        return value


def record_at(source: Source, position: int) -> Record | None:
    """Return the record that the bytes at `position` can be, None if they cannot be one.

    Only shapes are compared: a known opcode, a length within the file, inner lengths that fit it. The content may
    still be damaged.
    """
    head = source.read(position, position + FRAME.size)
    if len(head) < FRAME.size:
        return None
    opcode, length = FRAME.unpack(head)
    shape = _SHAPES.get(opcode)
    record = Record(opcode, position, position + FRAME.size + length)
    if shape is None or record.end > source.size or not shape(source, record.body, length):
        return None
    return record


def split(records: bytes | bytearray) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of the body of each record of an unpacked chunk; raises `DamageError`."""
    position = 0
    while position < len(records):
        begin = position + FRAME.size
        if begin > len(records):
            raise DamageError("the last record is cut short")
        opcode, length = FRAME.unpack_from(records, position)
        position = begin + length
        if position > len(records) or (opcode == Opcode.MESSAGE and length < MESSAGE.size):
            raise DamageError(f"a record has the impossible length {length}")
        yield opcode, begin, position


def parse_schema(body: bytes) -> Schema:
    """Return a schema; raises `DamageError`."""
    if not _fits(body, 2, 3):
        raise DamageError("a type declaration cannot be read")
    schema: Schema = _parsed(Schema.read, body)
    return schema


def parse_channel(body: bytes) -> Channel:
    """Return a channel; raises `DamageError`."""
    if not _fits(body, 4, 3):
        raise DamageError("a topic declaration cannot be read")
    channel: Channel = _parsed(Channel.read, body)
    return channel


def parse_metadata(body: bytes) -> Metadata:
    """Return a metadata record; raises `DamageError`."""
    if not _fits(body, 0, 2, exactly=True):
        raise DamageError("a metadata record cannot be read")
    metadata: Metadata = _parsed(Metadata.read, body)
    return metadata


def _parsed(read: Callable[[ReadDataStream], T], body: bytes) -> T:
    try:
        return read(ReadDataStream(BytesIO(body)))
    except Exception as cause:  # text that is no UTF-8, a map that ends early: all mean the same here
        raise DamageError(f"a record cannot be read ({cause})") from cause


def _fits(body: bytes, position: int, texts: int, *, exactly: bool = False) -> bool:
    """Whether `texts` length-prefixed stretches from `position` on lie within `body` (or fill it)."""
    for _ in range(texts):
        if position + 4 > len(body):
            return False
        position += 4 + _U32.unpack_from(body, position)[0]
    return position == len(body) if exactly else position <= len(body)


def _texts(offset: int, texts: int, *, exactly: bool = False) -> Callable[[Source, int, int], bool]:
    def shape(source: Source, begin: int, length: int) -> bool:
        if length > _LARGEST_TEXT:
            return False
        return _fits(source.read(begin, begin + length), offset, texts, exactly=exactly)

    return shape


def _at_least(size: int) -> Callable[[Source, int, int], bool]:
    return lambda source, begin, length: length >= size


def _of(size: int) -> Callable[[Source, int, int], bool]:
    return lambda source, begin, length: length == size


def _is_chunk(source: Source, begin: int, length: int) -> bool:
    head = source.read(begin, begin + 32)
    if len(head) < 32:
        return False
    inner = begin + 32 + _U32.unpack_from(head, 28)[0]
    field = source.read(inner, inner + 8)
    return len(field) == 8 and inner + 8 + _U64.unpack(field)[0] == begin + length


def _is_index(source: Source, begin: int, length: int) -> bool:
    head = source.read(begin, begin + 6)
    return len(head) == 6 and length % 16 == 6 and _U32.unpack_from(head, 2)[0] == length - 6


def _is_attachment(source: Source, begin: int, length: int) -> bool:
    position = begin + 16
    for _ in range(2):
        head = source.read(position, position + 4)
        if len(head) < 4:
            return False
        position += 4 + _U32.unpack(head)[0]
    head = source.read(position, position + 8)
    return len(head) == 8 and position + 8 + _U64.unpack(head)[0] + 4 == begin + length


_SHAPES: dict[int, Callable[[Source, int, int], bool]] = {
    Opcode.HEADER: _texts(0, 2, exactly=True),
    Opcode.FOOTER: _of(20),
    Opcode.SCHEMA: _texts(2, 3),
    Opcode.CHANNEL: _texts(4, 3),
    Opcode.MESSAGE: _at_least(MESSAGE.size),
    Opcode.CHUNK: _is_chunk,
    Opcode.MESSAGE_INDEX: _is_index,
    Opcode.CHUNK_INDEX: _at_least(64),
    Opcode.ATTACHMENT: _is_attachment,
    Opcode.ATTACHMENT_INDEX: _at_least(48),
    Opcode.STATISTICS: _at_least(46),
    Opcode.METADATA: _texts(0, 2, exactly=True),
    Opcode.METADATA_INDEX: _at_least(20),
    Opcode.SUMMARY_OFFSET: _of(17),
    Opcode.DATA_END: _of(4),
}
