"""Chunks: where their data may lie, unpacked without trusting a length, and what proves them."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from typing import NamedTuple

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from mcap.opcode import Opcode

from seat_gear_dynamics.logs.recovery.records import FRAME, DamageError, Source

LARGEST_CHUNK = 2**27  # bytes, packed and unpacked; the recorder's own largest is 10^8
_HEAD = struct.Struct("<QQQII")  # first and last log time, size unpacked, CRC, length of the codec's name
_U64 = struct.Struct("<Q")
_SLICE = 512  # bytes of a stream of unknown size that are unpacked at a time: at most 16 MiB come out of them
_SMALLEST_WINDOW = 2**23  # bytes a zstd stream may always look back, as its levels up to 19 do


class Layout(NamedTuple):
    """One reading of the bytes at `begin` as a chunk. `sure`: every field of its head agrees with the others."""

    begin: int
    codec: str
    data: int
    end: int
    size: int
    crc: int
    start_ns: int
    end_ns: int
    sure: bool


class Unpacked(NamedTuple):
    """A chunk's content. `proven`: a checksum over it is right. `packed`: the bytes it was made from."""

    records: bytes
    packed: bytes
    proven: bool


def layouts(source: Source, position: int) -> Iterator[Layout]:
    """Yield the ways in which the bytes at `position` can be a chunk, the surest first.

    The head says twice where the chunk ends (frame and inner length) and what it is (opcode and codec), so that one
    damaged field does not lose it: readings that leave out one of them follow, for the checksum to judge.
    """
    head = source.read(position, position + FRAME.size + _HEAD.size + 12)
    if len(head) < FRAME.size + _HEAD.size + 8:
        return
    opcode, length = FRAME.unpack_from(head)
    start, end, size, crc, _ = _HEAD.unpack_from(head, FRAME.size)
    frame_end = position + FRAME.size + length
    found: list[Layout] = []
    for codec in ("zstd", "lz4", ""):
        at = FRAME.size + 28 + 4 + len(codec)
        named = head[FRAME.size + 28 : at] == struct.pack("<I", len(codec)) + codec.encode()
        data = position + at + 8
        inner_end = data + int(_U64.unpack_from(head.ljust(at + 8, b"\0"), at)[0])
        agrees = inner_end == frame_end
        sure = agrees and named and opcode == Opcode.CHUNK
        if not (named or (agrees and opcode == Opcode.CHUNK)):
            continue
        # Four zeros name no codec: without a further witness they are too common to begin a chunk.
        if named and (codec or agrees or inner_end - data == size):
            found.append(Layout(position, codec, data, inner_end, size, crc, start, end, sure))
        if opcode == Opcode.CHUNK and not (agrees and named):
            found.append(Layout(position, codec, data, frame_end, size, crc, start, end, False))
    fitting = [layout for layout in dict.fromkeys(found) if layout.data <= layout.end <= source.size]
    yield from sorted(fitting, key=lambda layout: not layout.sure)


def unpack(source: Source, layout: Layout) -> Unpacked:
    """Read and unpack a chunk; raises `DamageError` for one that cannot be, or whose checksum is wrong.

    Memory is bounded by what the codec's own header announces, and that by `LARGEST_CHUNK`. A wrong CRC is overruled
    only by a checksum of the codec's own over the whole content.
    """
    if layout.end - layout.data > LARGEST_CHUNK:
        raise DamageError(f"a chunk of {layout.end - layout.data} bytes is too large to be believed")
    packed = source.read(layout.data, layout.end)
    try:
        records, checked = _CODECS[layout.codec](packed, layout.size)
    except DamageError:
        raise
    except Exception as cause:  # each codec has errors of its own; all mean the same here
        raise DamageError("the chunk cannot be unpacked") from cause
    if layout.crc and zlib.crc32(records) == layout.crc:
        checked = True
    elif layout.crc and not checked:
        raise DamageError("the chunk's checksum is wrong")
    return Unpacked(records, packed, checked)


def pack(records: bytes, codec: str) -> bytes:
    """Compress as the codec's name asks."""
    if codec == "zstd":
        return bytes(zstandard.compress(records))
    return bytes(lz4.frame.compress(records)) if codec == "lz4" else records


def _plain(packed: bytes, declared: int) -> tuple[bytes, bool]:
    return packed, False


def _zstd(packed: bytes, declared: int) -> tuple[bytes, bool]:
    frame = zstandard.get_frame_parameters(packed)
    known = frame.content_size != zstandard.CONTENTSIZE_UNKNOWN
    size = _believable(frame.content_size if known else declared)
    window = max(_SMALLEST_WINDOW, 1 << size.bit_length())
    codec = zstandard.ZstdDecompressor(max_window_size=window)
    if known and size:
        # Without a frame behind it, so that the codec's checksum, where there is one, speaks for all of the bytes.
        return codec.decompress(packed, max_output_size=size, allow_extra_data=False), bool(frame.has_checksum)
    stream, records = codec.decompressobj(), bytearray()
    for begin in range(0, len(packed), _SLICE):
        records += stream.decompress(packed[begin : begin + _SLICE])
        if len(records) > size:
            raise DamageError("the chunk unpacks to more than it announces")
        if stream.eof:
            break
    if not stream.eof or stream.unused_data or begin + _SLICE < len(packed):
        raise DamageError("the chunk's compressed data is incomplete")
    return bytes(records), bool(frame.has_checksum)


def _lz4(packed: bytes, declared: int) -> tuple[bytes, bool]:
    frame = lz4.frame.get_frame_info(packed)
    size = _believable(frame["content_size"] or declared)
    stream = lz4.frame.LZ4FrameDecompressor()
    records = bytes(stream.decompress(packed, max_length=size + 1))
    if len(records) > size:
        raise DamageError("the chunk unpacks to more than it announces")
    if not stream.eof or stream.unused_data:
        raise DamageError("the chunk's compressed data is incomplete")
    return records, bool(frame["content_checksum"])


def _believable(size: int) -> int:
    if size > LARGEST_CHUNK:
        raise DamageError(f"a chunk that announces {size} bytes is too large to be believed")
    return size


_CODECS: dict[str, Callable[[bytes, int], tuple[bytes, bool]]] = {"": _plain, "zstd": _zstd, "lz4": _lz4}
