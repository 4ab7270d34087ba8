"""Records that are not where or what they should be: rejected, counted and reported; private ones passed over."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.opcode import Opcode
from mcap.writer import CompressionType, IndexType, Writer

from seat_gear_dynamics.logs.container import scan
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.topics import FLOAT64

NO_SUMMARY: dict[str, Any] = {
    "use_statistics": False,
    "repeat_channels": False,
    "repeat_schemas": False,
    "index_types": IndexType.NONE,
    "use_summary_offsets": False,
}
COUNT = 100
FRAME = struct.Struct("<BQ")
NANOSECOND = 1_795_336_238_000_000_000  # log times as a bench has them: their bytes are what a flipped opcode shows


def number(value: float) -> bytes:
    return struct.pack("<4sd", b"\0\1\0\0", value)


@pytest.fixture
def make(tmp_path: Path) -> Callable[..., Path]:
    """Make a file of 100 messages, some 9 to a chunk, with two metadata records; options are the mcap writer's."""

    def write(name: str = "x.mcap", **options: Any) -> Path:
        path = tmp_path / name
        with open(path, "wb") as file:
            chosen: dict[str, Any] = {"chunk_size": 400, "compression": CompressionType.NONE} | options
            writer: Any = Writer(file, **chosen)
            writer.start("ros2")
            kind = writer.register_schema(FLOAT64, "ros2msg", schema(FLOAT64).text.encode())
            channel = writer.register_channel("/a", "cdr", kind)
            for i in range(COUNT):
                writer.add_message(channel, NANOSECOND + i, number(i), i)
            for name in ("one", "two"):
                writer.add_metadata(name, {"key": "value"})
            writer.finish()
        return path

    return write


def patched(path: Path, place: int, *values: int) -> Path:
    """Return a copy of a file with other bytes from `place` on."""
    content = bytearray(path.read_bytes())
    content[place : place + len(values)] = bytes(values)
    copy = path.with_name("patched.mcap")
    copy.write_bytes(content)
    return copy


def inserted(path: Path, place: int, record: bytes) -> Path:
    """Return a copy of a file with `record` before its summary, whose place and checksum are set right."""
    content = bytearray(path.read_bytes())
    start, offsets, _ = struct.unpack("<QQI", content[-28:-8])
    content[place:place] = record
    if start:
        start, offsets = start + len(record), offsets + len(record)
        struct.pack_into("<QQ", content, len(content) - 28, start, offsets)
        struct.pack_into("<I", content, len(content) - 12, zlib.crc32(content[start:-12]))
    copy = path.with_name("inserted.mcap")
    copy.write_bytes(content)
    return copy


def values(path: Path) -> list[float]:
    return [struct.unpack("<4xd", message.data)[0] for message in Bag(path).messages()]


@pytest.mark.parametrize("ending", ["with a summary", "killed", "no index, no summary"])
def test_a_chunk_under_any_other_opcode_is_missed_and_said_to_be(make: Callable[..., Path], ending: str) -> None:
    whole = make(**(NO_SUMMARY if ending == "no index, no summary" else {}))
    blocks = scan(whole).blocks
    if ending == "killed":  # right behind the last chunk's index
        whole.write_bytes(whole.read_bytes()[: blocks[-1].offset + blocks[-1].length])
    assert values(whole) == list(range(sum(len(b.messages({1})) for b in blocks)))
    lost = [message.log_time_ns - NANOSECOND for message in blocks[3].messages({1})]
    for opcode in {*range(256)} - {Opcode.CHUNK}:
        bag = Bag(patched(whole, blocks[3].offset - FRAME.size, opcode))
        found = [message.log_time_ns - NANOSECOND for message in bag.messages()]
        assert bag.damage is not None, f"opcode {opcode:#04x}"
        # All the others are read: the record's length still leads to the next.
        assert found == [i for i in range(COUNT) if i not in lost], f"opcode {opcode:#04x}"
        assert bag.message_count == len(found), "what is counted can be read"
        if ending == "with a summary":
            assert f"{len(lost)} of {COUNT} messages that its summary counts are not there." in bag.damage
            assert f"(the first should be at byte {blocks[3].offset - FRAME.size})" in bag.damage


@pytest.mark.parametrize("options", [{}, NO_SUMMARY])
@pytest.mark.parametrize("opcode", [0x80, 0xC3, 0xFF])
def test_private_records_are_passed_over_in_silence(make: Callable[..., Path], options: Any, opcode: int) -> None:
    whole = make(**options)
    end = len(whole.read_bytes()) - tail(whole)
    # Anywhere where no index lists what stands behind it; zeros would fit a chunk's lengths.
    places = [end, *(block.offset - FRAME.size for block in scan(whole).blocks)] if options else [end]
    for body in (b"", b"anything", bytes(40), bytes(200)):
        for place in places:
            path = inserted(whole, place, FRAME.pack(opcode, len(body)) + body)
            assert (values(path), Bag(path).damage) == (list(range(COUNT)), None)


def tail(path: Path) -> int:
    """Return how many bytes the end of the data section, the summary and the footer take."""
    content = path.read_bytes()
    start = struct.unpack("<Q", content[-28:-20])[0] or len(content) - 37
    return len(content) - start + FRAME.size + 4


@pytest.mark.parametrize("options", [{}, NO_SUMMARY])
def test_records_of_a_later_version_are_passed_over_and_reported(make: Callable[..., Path], options: Any) -> None:
    whole = make(**options)
    record = FRAME.pack(0x21, 5) + b"later"
    bag = Bag(inserted(whole, len(whole.read_bytes()) - tail(whole), 3 * record))
    assert len(list(bag.messages())) == COUNT
    assert bag.damage is not None
    assert "3 records of opcode 0x21 that this version of MCAP does not know (the first at byte" in bag.damage


@pytest.mark.parametrize(("opcode", "silent"), [(0x85, True), (0x25, False), (0x00, False), (Opcode.METADATA, False)])
def test_in_a_chunk_without_a_checksum_too(make: Callable[..., Path], opcode: int, silent: bool) -> None:
    whole = make(enable_crcs=False)
    at = whole.read_bytes().index(number(50)) - 22 - FRAME.size
    bag = Bag(patched(whole, at, opcode))
    assert len(list(bag.messages())) == COUNT - 1
    # A private record in place of a message: nothing but the statistics could tell, and these are not asked by block.
    assert (bag.damage is None) == silent
    assert silent or "1 of the records in the block at byte" in str(bag.damage)


@pytest.mark.parametrize("opcode", [0x00, 0x85, 0x25, Opcode.MESSAGE_INDEX, Opcode.HEADER, Opcode.CHUNK])
def test_a_loose_message_under_another_opcode_is_counted_as_missing(make: Callable[..., Path], opcode: int) -> None:
    whole = make(use_chunking=False)
    at = whole.read_bytes().index(number(50)) - 22 - FRAME.size
    bag = Bag(patched(whole, at, opcode))
    assert [m.log_time_ns - NANOSECOND for m in bag.messages()] == [i for i in range(COUNT) if i != 50]
    assert bag.damage is not None
    assert "1 of 100 messages that its summary counts are not there." in bag.damage
    assert bag.message_count == COUNT - 1


def test_metadata_under_another_opcode_is_missed(make: Callable[..., Path]) -> None:
    whole = make()
    at = whole.read_bytes().index(b"two") - 4 - FRAME.size
    bag = Bag(patched(whole, at, 0x8C))
    assert values(whole) == list(range(COUNT))
    assert bag.damage == "patched.mcap: 1 of 2 metadata records that its summary counts are not there."


def test_a_summary_with_a_wrong_checksum_is_not_believed(make: Callable[..., Path]) -> None:
    whole = make()
    content = whole.read_bytes()
    start = struct.unpack("<Q", content[-28:-20])[0]
    for place in range(start, len(content) - 12, 7):
        bag = Bag(patched(whole, place, content[place] ^ 0x10))
        assert (bag.topics["/a"].count, len(list(bag.messages()))) == (COUNT, COUNT), f"byte {place}"
        assert list(bag.topics) == ["/a"]
        assert bag.damage is not None, f"byte {place}"


def test_a_summary_without_a_checksum_is_believed_as_far_as_it_can_be_read(make: Callable[..., Path]) -> None:
    whole = make()
    size = len(whole.read_bytes())
    unchecked = patched(whole, size - 12, 0, 0, 0, 0)
    assert (Bag(unchecked).damage, Bag(unchecked).message_count) == (None, COUNT)
    beyond = Bag(patched(unchecked, size - 28, *struct.pack("<Q", size)))
    assert beyond.message_count == COUNT
    assert beyond.damage is not None
    assert "its summary is not used: it should begin at byte" in beyond.damage


def test_after_two_records_of_nonsense_in_a_row_nothing_more_is_believed(make: Callable[..., Path]) -> None:
    whole = make(**NO_SUMMARY)
    blocks = scan(whole).blocks
    content = whole.read_bytes()
    # As after a power cut: a stretch of zeros, which read as empty records of opcode 0, with sound chunks behind.
    hole = content[: blocks[2].offset - FRAME.size] + bytes(9 * 100) + content[blocks[2].offset - FRAME.size :]
    path = whole.with_name("hole.mcap")
    path.write_bytes(hole)
    bag = Bag(path)
    assert len(list(bag.messages())) == sum(len(block.messages({1})) for block in blocks[:2])
    assert bag.damage is not None
    assert f"from byte {blocks[2].offset} on it holds no records" in bag.damage


def test_a_loose_message_of_no_topic_is_reported(make: Callable[..., Path]) -> None:
    whole = make(use_chunking=False)
    at = whole.read_bytes().index(number(50)) - 22
    bag = Bag(patched(whole, at, 9, 0))
    assert len(list(bag.messages())) == COUNT - 1
    assert bag.damage is not None
    assert "a record of opcode 0x05 of a topic that was not declared" in bag.damage


def test_messages_whose_declaration_is_lost_are_counted(make: Callable[..., Path]) -> None:
    whole = make(**NO_SUMMARY)
    first = scan(whole).blocks[0]
    left = COUNT - len(first.messages({1}))
    with pytest.raises(LogError, match=f"{left} messages of topics that nothing declares, left out"):
        Bag(patched(whole, first.offset - FRAME.size, 0x86))


def test_a_file_of_nothing_but_private_records_is_no_log(make: Callable[..., Path], tmp_path: Path) -> None:
    path = tmp_path / "private.mcap"
    path.write_bytes(make().read_bytes()[:8] + FRAME.pack(0x90, 3) + b"abc")
    with pytest.raises(LogError, match="ends at byte 20 without a footer"):
        Bag(path)
