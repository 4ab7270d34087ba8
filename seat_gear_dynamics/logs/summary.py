"""The summary of an MCAP file: what its writer says that it holds, taken only where its checksum does not deny it."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from io import BytesIO
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Footer, Schema, Statistics

FRAME = struct.Struct("<BQ")  # opcode, length of the body
_U64 = struct.Struct("<Q")
_CHECKED = FRAME.size + 16  # bytes of the footer that its checksum covers: the frame and both offsets
_PIECE = 2**20  # bytes that are held at a time


class SummaryError(Exception):
    """Why a summary is not to be believed; never leaves this room."""


@dataclass
class Summary:
    """Declarations, statistics (None: it has none) and the offsets of all chunks that a file should hold."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    statistics: Statistics | None = None
    chunks: set[int] = field(default_factory=set)


def read_summary(file: BinaryIO, footer: Footer, place: int) -> Summary:
    """Return the summary before the footer at offset `place`; raises `SummaryError`, and `OSError` as the disk does.

    A checksum of 0 means that the writer made none: then records that can be read are believed.
    """
    start = footer.summary_start
    if not 0 < start <= place:
        raise SummaryError(f"it should begin at byte {start}, which is not before its end")
    if footer.summary_crc and _crc(file, start, place + _CHECKED) != footer.summary_crc:
        raise SummaryError("its checksum is wrong")
    summary, position = Summary(), start
    while position < place:
        file.seek(position)
        head = file.read(FRAME.size)
        opcode, length = FRAME.unpack(head) if len(head) == FRAME.size else (0, 0)
        begin, position = position + FRAME.size, position + FRAME.size + length
        if not head or position > place:
            raise SummaryError(f"the record at byte {begin - FRAME.size} does not end within it")
        _take(summary, opcode, file.read(length))
    return summary


def _take(summary: Summary, opcode: int, body: bytes) -> None:
    stream = ReadDataStream(BytesIO(body))
    try:
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            summary.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(stream)
            summary.channels[channel.id] = channel
        elif opcode == Opcode.STATISTICS:
            summary.statistics = Statistics.read(stream)
        elif opcode == Opcode.CHUNK_INDEX:
            summary.chunks.add(_U64.unpack_from(body, 16)[0])
    except Exception as cause:  # fields of a damaged record fail in many ways
        raise SummaryError(f"a record of opcode {opcode:#04x} in it cannot be read ({cause})") from cause


def _crc(file: BinaryIO, begin: int, end: int) -> int:
    file.seek(begin)
    value = 0
    while begin < end:
        piece = file.read(min(_PIECE, end - begin))
        if not piece:
            break
        value, begin = zlib.crc32(piece, value), begin + len(piece)
    return value
