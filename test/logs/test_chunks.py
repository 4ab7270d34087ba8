"""The MCAP records against the mcap library's own writer, and declarations that outlive a lost beginning."""

from __future__ import annotations

import struct
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import Chunk, MessageIndex
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from mcap.writer import CompressionType, Writer

from seat_gear_dynamics.logs.chunks import ChunkWriter
from seat_gear_dynamics.logs.container import scan
from seat_gear_dynamics.logs.presets import codec
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.topics import FLOAT64
from seat_gear_dynamics.logs.writer import BagWriter

NewLog = Callable[..., BagWriter]

messages = st.lists(
    st.tuples(st.integers(0, 2), st.integers(0, 2**62), st.binary(max_size=50), st.integers(0, 2**62)), max_size=40
)


def ours(rows: list[Any], size: int) -> bytes:
    sink = BytesIO()
    name, pack = codec("zstd")
    writer = ChunkWriter(sink, chunk_size=size, compression=name, pack=pack)
    writer.start("ros2", "test")
    kind = writer.add_schema("a", "ros2msg", b"float64 data")
    channels = [writer.add_channel(f"/{i}", "cdr", kind, {"k": "v"}) for i in range(3)]
    writer.add_metadata("m", {"x": "y"})
    for i, (channel, log_ns, data, publish_ns) in enumerate(rows):
        writer.add_message(channels[channel], log_ns, data, publish_ns, i)
    writer.finish()
    return sink.getvalue()


def library(rows: list[Any], size: int) -> bytes:
    sink = BytesIO()
    writer: Any = Writer(sink, chunk_size=size, compression=CompressionType.ZSTD)
    writer.start("ros2", "test")
    kind = writer.register_schema("a", "ros2msg", b"float64 data")
    channels = [writer.register_channel(f"/{i}", "cdr", kind, {"k": "v"}) for i in range(3)]
    writer.add_metadata("m", {"x": "y"})
    for i, (channel, log_ns, data, publish_ns) in enumerate(rows):
        writer.add_message(channels[channel], log_ns, data, publish_ns, i)
    writer.finish()
    return sink.getvalue()


@given(messages, st.integers(1, 500))
def test_it_says_the_same_as_the_librarys_writer(rows: list[Any], size: int) -> None:
    found, expected = (
        make_reader(BytesIO(file), validate_crcs=True) for file in (ours(rows, size), library(rows, size))
    )
    assert found.get_header() == expected.get_header()
    assert list(found.iter_messages()) == list(expected.iter_messages())
    one, other = found.get_summary(), expected.get_summary()
    assert one is not None
    assert other is not None
    assert one.statistics is not None
    assert other.statistics is not None
    assert (one.schemas, one.channels) == (other.schemas, other.channels)
    assert one.statistics.message_count == other.statistics.message_count == len(rows)
    assert dict(one.statistics.channel_message_counts) == dict(other.statistics.channel_message_counts)
    assert one.statistics.message_start_time == other.statistics.message_start_time
    assert one.statistics.message_end_time == other.statistics.message_end_time
    assert sum(len(index.message_index_offsets) for index in one.chunk_indexes) > 0 or not rows


@given(messages, st.integers(1, 500))
def test_every_record_is_where_the_indexes_say(rows: list[Any], size: int) -> None:
    file = ours(rows, size)
    records = list(StreamReader(BytesIO(file), emit_chunks=True, validate_crcs=True).records)
    chunks = [record for record in records if isinstance(record, Chunk)]
    reader = make_reader(BytesIO(file))
    summary = reader.get_summary()
    assert summary is not None
    assert len(chunks) == len(summary.chunk_indexes)
    for index in summary.chunk_indexes:
        assert file[index.chunk_start_offset] == 6
        for offset in index.message_index_offsets.values():
            assert file[offset] == 7
    entries = 0
    body = b""
    for record in records:
        if isinstance(record, Chunk):
            stream, length = get_chunk_data_stream(record, validate_crc=True)
            body = stream.read(length)
        elif isinstance(record, MessageIndex):
            for log_ns, offset in record.records:
                assert body[offset] == 5
                assert struct.unpack_from("<H4xQ", body, offset + 9) == (record.channel_id, log_ns)
                entries += 1
    assert entries == len(rows)
    assert [(r.name, r.metadata) for r in reader.iter_metadata()] == [("m", {"x": "y"})]


@pytest.mark.parametrize("lost", [0, 1])
def test_topics_are_known_when_a_chunk_of_a_killed_log_is_lost(new_log: NewLog, tmp_path: Path, lost: int) -> None:
    log = new_log(chunk_size=500, compression="none", sync_interval_s=1e6)
    log.add_topic("/a", FLOAT64)
    for k in range(200):
        log.write("/a", bytes(12), k, 0)
    log.sync(200)
    blocks = scan(log.files[0]).blocks
    wrong = bytearray(log.files[0].read_bytes())
    wrong[blocks[lost].offset + 60] ^= 0xFF
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(wrong)
    bag = Bag(damaged)
    assert not bag.closed
    assert bag.topics["/a"].type == FLOAT64
    assert len(list(bag.messages())) == 200 - len(blocks[lost].messages({1}))
    assert bag.damage is not None
