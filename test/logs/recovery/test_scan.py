"""The walk through a damaged file: every single byte, lost and shifted stretches, files within files, bombs."""

from __future__ import annotations

import random
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame  # type: ignore[import-untyped]
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer

from seat_gear_dynamics.logs.container import scan
from seat_gear_dynamics.logs.recovery import chunks
from seat_gear_dynamics.logs.recovery.chunks import layouts, unpack
from seat_gear_dynamics.logs.recovery.records import DamageError, Source, record_at, split
from seat_gear_dynamics.logs.recovery.scan import Survey, survey

SmallLog = Callable[..., Path]


def look(path: Path, data: bytes, *, unchecked: bool = False) -> tuple[Survey, list[bytes]]:
    """Survey these bytes; return it and the content of its chunks."""
    path.write_bytes(data)
    with Source(path) as source:
        found = survey(source, unchecked=unchecked)
        return found, [unpack(source, piece.layout).records for piece in found.pieces if piece.layout]


def bounds(path: Path) -> list[tuple[int, int]]:
    """Return begin and end of the chunks of a sound file, as the reader of whole logs finds them."""
    return [(block.offset - 9, block.offset + block.length) for block in scan(path).blocks]


@pytest.fixture(scope="module")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file that the examples of a property write one after the other."""
    return tmp_path_factory.mktemp("scratch") / "damaged.mcap"


def without_summary(data: bytes) -> bytes:
    """Return the file as a power cut in front of its summary would leave it."""
    start = int.from_bytes(data[-28:-20], "little")
    return data[: start - 13]


@pytest.mark.parametrize("compression", ["none", "zstd", "lz4"])
@pytest.mark.parametrize("closed", [True, False])
def test_each_single_wrong_byte_costs_at_most_its_own_chunk(
    small_log: SmallLog, tmp_path: Path, compression: str, closed: bool
) -> None:
    whole = (small_log(count=12, compression=compression) / "log_0.mcap").read_bytes()
    places = bounds(tmp_path / "log" / "log_0.mcap")
    data = whole if closed else without_summary(whole)
    path = tmp_path / "damaged.mcap"
    _, contents = look(path, data)
    assert len(contents) == len(places) >= 3
    chance = random.Random(1)
    heads = [begin + i for begin, end in places for i in range(60)]
    # Every byte that frames something, and a share of those that are content only.
    for place in sorted({*heads, *range(60), *chance.sample(range(len(data)), 300)}):
        harmed = bytearray(data)
        harmed[place] ^= chance.randrange(1, 256)
        found, kept = look(path, bytes(harmed))
        intact = [c for c, (begin, end) in zip(contents, places, strict=True) if not begin <= place < end]
        assert [c for c in kept if c in intact] == intact, place
        assert all(c in contents for c in kept), place
        touched = [end for begin, end in places if begin <= place < end]
        if len(kept) < len(contents):
            assert touched, place
            assert any(lost.begin <= place < lost.end for lost in found.lost), place


@pytest.mark.parametrize("field", ["opcode", "length", "size", "codec", "inner length", "times"])
def test_a_chunk_survives_one_damaged_field_of_its_head(small_log: SmallLog, tmp_path: Path, field: str) -> None:
    whole = (small_log(compression="zstd") / "log_0.mcap").read_bytes()
    begin, _ = bounds(tmp_path / "log" / "log_0.mcap")[2]
    offset = {"opcode": 0, "length": 3, "times": 12, "size": 27, "codec": 43, "inner length": 47}[field]
    for value in (0x05, 0x40, 0xFF):
        data = bytearray(without_summary(whole))
        data[begin + offset] ^= value
        found, kept = look(tmp_path / "damaged.mcap", bytes(data))
        _, all_of_it = look(tmp_path / "sound.mcap", without_summary(whole))
        assert kept == all_of_it
        assert found.lost == []


def test_a_lost_stretch_and_an_inserted_one_cost_the_chunks_they_touch(small_log: SmallLog, tmp_path: Path) -> None:
    data = without_summary((small_log(compression="zstd") / "log_0.mcap").read_bytes())
    places = bounds(tmp_path / "log" / "log_0.mcap")
    _, contents = look(tmp_path / "sound.mcap", data)
    middle = (places[3][0] + places[3][1]) // 2
    gap = data[:middle] + data[middle + 60 :]  # the rest moves up, over the end that the chunk announces
    _, kept = look(tmp_path / "gap.mcap", gap)
    assert kept == contents[:3] + contents[4:]
    noise = data[:middle] + random.Random(4).randbytes(5000) + data[middle:]
    _, kept = look(tmp_path / "noise.mcap", noise)
    assert kept == contents[:3] + contents[4:]
    hole = data[:middle] + bytes(places[4][0] + 30 - middle) + data[places[4][0] + 30 :]
    _, kept = look(tmp_path / "hole.mcap", hole)
    assert kept == contents[:3] + contents[5:]


Edit = tuple[float, int, bytes]  # place as a share of the file, bytes taken away, bytes put in


@given(st.lists(st.tuples(st.floats(0, 1), st.integers(0, 400), st.binary(max_size=100)), max_size=6), st.booleans())
def test_no_damage_whatever_yields_what_was_not_written(
    sound: bytes, scratch: Path, edits: list[Edit], closed: bool
) -> None:
    _, contents = look(scratch, sound)
    data = sound if closed else without_summary(sound)
    for share, taken, put in edits:
        place = int(share * len(data))
        data = data[:place] + put + data[place + taken :]
    for unchecked in (False, True):
        found, kept = look(scratch, data, unchecked=unchecked)
        assert [content for content in contents if content in kept] == kept  # a part of them, in order, none twice
        assert all(0 <= lost.begin < lost.end <= len(data) for lost in found.lost)


@given(st.binary(max_size=3000))
def test_bytes_that_are_no_log_hold_nothing(scratch: Path, data: bytes) -> None:
    # Random bytes hold a chunk whose checksum is right in one case of 2^32.
    found, kept = look(scratch, data)
    assert (kept, found.counts) == ([], {})


def chunk(packed: bytes, size: int, codec: str, crc: int) -> bytes:
    head = struct.pack("<QQQI", 1, 1, size, crc) + struct.pack("<I", len(codec)) + codec.encode()
    body = head + struct.pack("<Q", len(packed)) + packed
    return struct.pack("<BQ", Opcode.CHUNK, len(body)) + body


def message(data: bytes) -> bytes:
    return struct.pack("<BQHIQQ", Opcode.MESSAGE, 22 + len(data), 1, 0, 1, 1) + data


MAGIC = b"\x89MCAP0\r\n"
HEADER = struct.pack("<BQ", Opcode.HEADER, 12) + struct.pack("<I4sI", 4, b"ros2", 0)


@pytest.mark.parametrize("codec", ["zstd", "lz4"])
@pytest.mark.parametrize("announced", ["its own size", "little", "2^60"])
def test_a_bomb_is_not_unpacked(tmp_path: Path, codec: str, announced: str) -> None:
    size = chunks.LARGEST_CHUNK + 1
    pack: Any = zstandard.ZstdCompressor().compressobj() if codec == "zstd" else lz4.frame.LZ4FrameCompressor()
    # Streamed, so that the codec's own header does not tell the size either.
    packed = bytes(pack.begin()) if codec == "lz4" else b""
    packed += b"".join(bytes(pack.compress(bytes(2**20))) for _ in range(size // 2**20 + 1)) + bytes(pack.flush())
    stated = {"its own size": size, "little": 1000, "2^60": 2**60}[announced]
    data = MAGIC + HEADER + chunk(packed, stated, codec, 1234)
    tracemalloc.start()
    try:
        found, kept = look(tmp_path / "bomb.mcap", data)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert kept == []
    assert found.lost
    assert peak < 64 * 2**20  # a slice of zstd's gives 16 MiB at most; the bomb would take 128


@pytest.mark.parametrize("codec", ["zstd", "lz4"])
def test_a_codecs_own_checksum_proves_a_chunk_without_a_crc_or_with_a_wrong_one(tmp_path: Path, codec: str) -> None:
    records = message(b"x" * 300)
    if codec == "zstd":
        packed = zstandard.ZstdCompressor(write_checksum=True).compress(records)
    else:
        packed = bytes(lz4.frame.compress(records, content_checksum=True))
    for crc in (0, 1234, zlib.crc32(records)):
        data = MAGIC + HEADER + chunk(packed, len(records), codec, crc)
        assert look(tmp_path / "a.mcap", data)[1] == [records]
        harmed = bytearray(data)
        harmed[-1] ^= 1
        if crc != zlib.crc32(records):
            assert look(tmp_path / "a.mcap", bytes(harmed))[1] == []


def test_a_chunk_without_a_checksum_is_kept_only_when_asked_and_consistent(tmp_path: Path) -> None:
    records = message(b"x" * 30)
    data = MAGIC + HEADER + chunk(records, len(records), "", 0)
    found, kept = look(tmp_path / "a.mcap", data)
    assert (kept, found.unproven) == ([], 1)
    assert [lost.reason for lost in found.lost] == ["no checksum vouches for it"]
    found, kept = look(tmp_path / "a.mcap", data, unchecked=True)
    assert (kept, found.unproven, found.lost) == ([records], 1, [])
    wrong_size = MAGIC + HEADER + chunk(records, len(records) + 1, "", 0)
    assert look(tmp_path / "a.mcap", wrong_size, unchecked=True)[1] == []


def test_chunks_of_a_file_within_the_file_are_not_taken_for_its_own(small_log: SmallLog, tmp_path: Path) -> None:
    inner = (small_log() / "log_0.mcap").read_bytes()
    records = message(inner)
    own = message(b"mine")
    data = (
        MAGIC
        + HEADER
        + chunk(records, len(records), "", zlib.crc32(records))
        + chunk(own, len(own), "", zlib.crc32(own))
    )
    assert look(tmp_path / "a.mcap", data)[1] == [records, own]
    harmed = bytearray(data)
    begin = len(MAGIC + HEADER)
    harmed[begin : begin + 60] = bytes(60)  # neither the chunk's end nor its kind is known any more
    assert look(tmp_path / "a.mcap", bytes(harmed))[1] == [own]
    cut = harmed[: begin + 200 + len(inner) // 2]  # nor is there an end of the file within
    assert look(tmp_path / "a.mcap", bytes(cut))[1] == []


@pytest.mark.parametrize("data_crc", [True, False])
def test_unchunked_messages_need_the_checksum_of_the_data_section(tmp_path: Path, data_crc: bool) -> None:
    path = tmp_path / "plain.mcap"
    with open(path, "wb") as file:
        writer = Writer(file, use_chunking=False, enable_data_crcs=data_crc, compression=CompressionType.NONE)
        writer.start("ros2")
        channel = writer.register_channel("/a", "cdr", writer.register_schema("A", "ros2msg", b"int32 a"))
        for i in range(50):
            writer.add_message(channel, i, bytes([i]) * 9, i)
        writer.finish()  # type: ignore[no-untyped-call]
    data = path.read_bytes()
    assert look(path, data)[0].counts == ({channel: 50} if data_crc else {})
    assert look(path, data, unchecked=True)[0].counts == {channel: 50}
    with Source(path) as source:
        begin = data.index(bytes([20]) * 9) - 22 - 9
        assert record_at(source, begin) is not None
    harmed = bytearray(data)
    harmed[begin + 35] ^= 1  # in the content: nothing tells, except the checksum of the whole
    assert not look(path, bytes(harmed))[0].counts
    assert look(path, bytes(harmed), unchecked=True)[0].counts == {channel: 50}
    harmed = bytearray(data)
    harmed[begin + 1] ^= 64  # in the framing: what lies behind is not trusted
    assert not look(path, bytes(harmed))[0].counts
    assert look(path, bytes(harmed), unchecked=True)[0].counts == {channel: 20}


def test_attachments_are_proven_by_their_checksum_and_metadata_by_its_hash(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with open(path, "wb") as file:
        writer = Writer(file)
        writer.start("ros2")
        writer.add_attachment(1, 2, "notes", "text/plain", b"attached text")
        writer.add_metadata("seat_gear_dynamics", {"system": "a: 1", "system_hash": "ab" * 32})
        writer.add_metadata("other", {"key": "value"})
        writer.finish()  # type: ignore[no-untyped-call]
    data = path.read_bytes()
    found, _ = look(path, data)
    assert [piece.opcode for piece in found.pieces] == [Opcode.ATTACHMENT, Opcode.METADATA]
    assert [lost.reason for lost in found.lost] == [
        "the system description does not have the hash that stands beside it"
    ]
    harmed = data.replace(b"attached text", b"attached test")
    found, _ = look(path, harmed)
    assert [piece.opcode for piece in found.pieces] == [Opcode.METADATA]
    assert "the attachment's checksum is wrong" in [lost.reason for lost in found.lost]


def test_what_does_not_frame_is_damage() -> None:
    assert list(split(message(b"ab"))) == [(Opcode.MESSAGE, 9, 33)]
    for records in (b"\x05", message(b"ab")[:-1], struct.pack("<BQ", 5, 3) + b"abc", struct.pack("<BQ", 5, 2**63)):
        with pytest.raises(DamageError, match=r"cut short|impossible length"):
            list(split(records))


def test_an_empty_file_and_a_bare_beginning_hold_nothing(tmp_path: Path) -> None:
    for data in (b"", MAGIC, MAGIC + HEADER, MAGIC + HEADER[:5], MAGIC * 3, bytes(10_000)):
        found, kept = look(tmp_path / "a.mcap", data)
        assert (found.pieces, kept) == ([], [])


def test_a_head_at_the_end_of_the_file_is_no_chunk(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(chunk(message(b"ab"), 33, "", 1)[:50])
    with Source(path) as source:
        assert list(layouts(source, 0)) == []
