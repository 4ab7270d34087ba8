"""What the writer writes, read back by our reader, by mcap's and by rosbags'."""

from __future__ import annotations

import struct
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability
from rosbags.rosbag2 import Reader

from seat_gear_dynamics.logs.counters import Counters
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.topics import BOOL, FLOAT64, IN_FORBIDDEN_BAND, JOINT_STATE
from seat_gear_dynamics.logs.writer import BagWriter

NewLog = Callable[..., BagWriter]
SECOND = 1_000_000_000
START = 1_795_336_238 * SECOND
Row = tuple[str, int, int, bytes]


def number(value: float) -> bytes:
    return struct.pack("<4sd", b"\0\1\0\0", value)


def fill(log: BagWriter, count: int, step_ns: int = SECOND // 100) -> list[Row]:
    log.add_topic("/motor/speed", FLOAT64)
    log.add_topic("/load/torque", FLOAT64)
    rows = [
        (("/motor/speed", "/load/torque")[i % 2], START + i * step_ns, START + i * step_ns - 77, number(i))
        for i in range(count)
    ]
    for topic, log_ns, publish_ns, data in rows:
        assert log.write(topic, data, log_ns, publish_ns)
    return rows


def by_mcap(path: Path) -> list[Row]:
    with open(path, "rb") as file:
        found = make_reader(file, validate_crcs=True).iter_messages()
        return [(c.topic, m.log_time, m.publish_time, m.data) for _, c, m in found]


def by_rosbags(path: Path) -> list[tuple[str, int, bytes]]:
    with AnyReader([path]) as reader:
        return [(c.topic, log_ns, bytes(data)) for c, log_ns, data in reader.messages()]


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_three_readers_find_the_same_bytes(new_log: NewLog, compression: str) -> None:
    with new_log(compression=compression) as log:
        rows = fill(log, 1000)
    assert list(Bag(log.directory).messages()) == rows
    assert [row for path in log.files for row in by_mcap(path)] == rows
    assert by_rosbags(log.directory) == [(topic, log_ns, data) for topic, log_ns, _, data in rows]
    with AnyReader([log.directory]) as reader:
        values = [reader.deserialize(data, c.msgtype).data for c, _, data in reader.messages()]  # type: ignore[attr-defined]
    assert values == [float(i) for i in range(1000)]


def test_rosbags_understands_the_metadata(new_log: NewLog) -> None:
    with new_log() as log:
        rows = fill(log, 250)
        log.add_topic("/bench/in_forbidden_band", BOOL, IN_FORBIDDEN_BAND.qos)
        log.write("/bench/in_forbidden_band", b"\0\1\0\0\1", START + 3 * SECOND, START)
        log.custom_data["dropped_in_queue"] = "0: none, so far"
    with Reader(log.directory) as reader:
        assert reader.message_count == 251
        assert reader.start_time == START
        assert reader.end_time == START + 3 * SECOND + 1
        assert reader.ros_distro == "jazzy"
        counts = {topic: (info.msgtype, info.msgcount) for topic, info in reader.topics.items()}
        latched = reader.topics["/bench/in_forbidden_band"].connections[0]
        assert latched.ext.offered_qos_profiles[0].durability == QosDurability.TRANSIENT_LOCAL  # type: ignore[union-attr]
    assert counts == {
        "/motor/speed": (FLOAT64, 125),
        "/load/torque": (FLOAT64, 125),
        "/bench/in_forbidden_band": (BOOL, 1),
    }
    assert len(rows) == 250
    assert Bag(log.directory).custom_data == {
        "dropped_in_queue": "0: none, so far",
        "messages of /motor/speed": "received 125, written 125, dropped 0",
        "messages of /load/torque": "received 125, written 125, dropped 0",
        "messages of /bench/in_forbidden_band": "received 1, written 1, dropped 0",
    }


def test_the_file_carries_profile_provenance_and_rosbag2s_record(new_log: NewLog) -> None:
    with new_log(system_text="name: ä\nmass: 1\n") as log:
        fill(log, 10)
    with open(log.files[0], "rb") as file:
        reader = make_reader(file)
        header, records = reader.get_header(), list(reader.iter_metadata())
        summary = reader.get_summary()
    assert (header.profile, header.library) == ("ros2", "seat_gear_dynamics 0.1.0")
    assert [record.name for record in records] == ["seat_gear_dynamics", "rosbag2", "rosbag2"]
    assert records[0].metadata == {
        "system": "name: ä\nmass: 1\n",
        "system_hash": "ab" * 32,
        "software_version": "0.1.0",
    }
    inside = yaml.safe_load(records[-1].metadata["serialized_metadata"])
    outside = yaml.safe_load((log.directory / "metadata.yaml").read_text())
    assert inside == outside["rosbag2_bagfile_information"]
    assert summary is not None
    assert {(c.message_encoding, summary.schemas[c.schema_id].encoding) for c in summary.channels.values()} == {
        ("cdr", "ros2msg")
    }
    assert Bag(log.directory).metadata == records[0].metadata


writes = st.tuples(
    st.sampled_from(["/a", "/b", "/latched"]),
    st.integers(-SECOND // 4, 2 * SECOND),
    st.integers(0, SECOND),
    st.binary(min_size=4, max_size=60),
)
actions = st.lists(st.one_of(writes, st.sampled_from(["sync", "split"])), max_size=40)


@given(
    actions,
    st.sampled_from(["zstd", "lz4", "none"]),
    st.integers(1, 400),
    st.sampled_from([0.01, 0.5, 100.0]),
)
@settings(max_examples=40, deadline=None)
def test_any_sequence_reads_back_exactly(
    actions: list[Any], compression: Any, chunk_size: int, interval: float
) -> None:
    expected: list[Row] = []
    latched: list[Row] = []
    files, news, now = 1, False, START
    with tempfile.TemporaryDirectory() as folder:
        log = BagWriter(
            Path(folder) / "log",
            system_text="",
            system_hash="",
            software_version="0",
            chunk_size=chunk_size,
            compression=compression,
            sync_interval_s=interval,
        )
        for topic in ("/a", "/b", "/latched"):
            log.add_topic(topic, FLOAT64, IN_FORBIDDEN_BAND.qos if topic == "/latched" else None)
        for action in actions:
            if action == "sync":
                log.sync(now)
            elif action == "split":
                assert (log.split(now) is not None) == news
                expected += [(t, now, publish_ns, data) for t, _, publish_ns, data in latched if news]
                files, news = files + news, False
            else:
                topic, step, publish_ns, data = action
                now, news = max(0, now + step), True
                log.write(topic, data, now, publish_ns)
                expected.append((topic, now, publish_ns, data))
                latched = expected[-1:] if topic == "/latched" else latched
        log.close()
        bag = Bag(log.directory)
        assert list(bag.messages()) == sorted(expected, key=lambda row: row[1])
        assert bag.damage is None
        assert bag.closed
        assert len(bag.files) == len(log.files) == files
        assert bag.message_count == len(expected)
        assert sorted(row for path in bag.files for row in by_mcap(path)) == sorted(expected)
        assert sorted(by_rosbags(log.directory)) == sorted((t, at, data) for t, at, _, data in expected)
        received = sum(action not in ("sync", "split") for action in actions)
        assert sum(c.written for c in log.counters.values()) == received


def test_files_are_split_by_size(new_log: NewLog) -> None:
    with new_log(chunk_size=1000, compression="none", max_size_bytes=10_000) as log:
        rows = fill(log, 2000)
    assert len(log.files) > 5
    assert [path.name for path in log.files[:2]] == ["log_0.mcap", "log_1.mcap"]
    # Beyond the limit: the chunk that reached it with its index and declarations, the record of all files, the summary.
    record = (log.directory / "metadata.yaml").stat().st_size
    assert max(path.stat().st_size for path in log.files) < 10_000 + 2500 + record + 2500
    assert list(Bag(log.directory).messages()) == rows
    assert by_rosbags(log.directory) == [(topic, at, data) for topic, at, _, data in rows]


def test_files_are_split_by_duration(new_log: NewLog) -> None:
    with new_log(max_duration_s=2.5) as log:
        rows = fill(log, 1000)
    assert [len(by_mcap(path)) for path in log.files] == [250, 250, 250, 250]
    assert list(Bag(log.directory).messages()) == rows


def test_each_file_begins_with_what_a_late_subscriber_is_sent(new_log: NewLog) -> None:
    with new_log() as log:
        fill(log, 10)
        log.add_topic("/band", BOOL, IN_FORBIDDEN_BAND.qos)
        for flag in (b"\0", b"\1"):
            log.write("/band", b"\0\1\0\0" + flag, START + SECOND, START + SECOND - 5)
        assert log.split(START + 2 * SECOND) == log.directory / "log_1.mcap"
        assert log.split(START + 3 * SECOND) is None  # nothing new since
        log.write("/motor/speed", number(1.0), START + 3 * SECOND, START)
        log.split(START + 4 * SECOND)
    repeated = [by_mcap(path)[0] for path in log.files[1:]]
    assert repeated == [("/band", START + after * SECOND, START + SECOND - 5, b"\0\1\0\0\1") for after in (2, 4)]
    assert log.counters["/band"] == Counters(received=2, written=2, dropped=0)
    assert Bag(log.directory).topics["/band"].count == 4
    with open(log.files[1], "rb") as file:
        sequences = [m.sequence for _, c, m in make_reader(file).iter_messages() if c.topic == "/band"]
    assert sequences == [1]


def test_nothing_waits_longer_than_the_interval(new_log: NewLog) -> None:
    log = new_log(sync_interval_s=1.0)
    log.add_topic("/a", FLOAT64)
    for i in range(1, 400):
        log.write("/a", number(i), START + i * SECOND // 100, 0)
        waiting = log.counters["/a"].received - log.counters["/a"].written
        assert waiting <= 100
        assert len(list(Bag(log.directory).messages())) == i - waiting
    log.sync(START + 4 * SECOND)
    assert log.counters["/a"] == Counters(399, 399, 0)
    information = yaml.safe_load((log.directory / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["message_count"] == 399
    assert not Bag(log.directory).closed
    log.close()
    assert Bag(log.directory).closed


def test_every_program_opens_a_log_that_is_still_being_written(new_log: NewLog) -> None:
    log = new_log(chunk_size=500, sync_interval_s=100.0)
    rows = fill(log, 40)
    in_full_chunks = by_mcap(log.files[0])
    assert 20 < len(in_full_chunks) < 40
    log.sync(START)
    assert by_mcap(log.files[0]) == rows
    assert by_rosbags(log.directory) == [(topic, at, data) for topic, at, _, data in rows]
    log.write("/motor/speed", number(40.0), START + SECOND, 0)
    log.close()
    assert len(by_mcap(log.files[0])) == 41


def test_a_clock_that_jumps_back_does_not_stop_the_syncs(new_log: NewLog) -> None:
    with new_log() as log:
        log.add_topic("/a", FLOAT64)
        log.write("/a", number(0), START, 0)
        log.write("/a", number(1), 5, 0)
        assert log.counters["/a"].written == 2


def test_an_empty_log_is_a_bag(new_log: NewLog) -> None:
    log = new_log()
    log.add_topic("/a", FLOAT64)
    log.close()
    log.close()
    bag = Bag(log.directory)
    assert (bag.message_count, bag.damage, list(bag.messages())) == (0, None, [])
    with Reader(log.directory) as reader:
        assert reader.message_count == 0


def test_an_existing_directory_is_refused_and_left_alone(new_log: NewLog, tmp_path: Path) -> None:
    (tmp_path / "log").mkdir()
    (tmp_path / "log" / "precious").write_text("x")
    with pytest.raises(LogError, match=r"log exists already; choose another name"):
        new_log()
    assert [path.name for path in (tmp_path / "log").iterdir()] == ["precious"]


def test_wrong_declarations_are_refused(new_log: NewLog) -> None:
    with new_log() as log:
        log.add_topic("/a", FLOAT64)
        log.add_topic("/a", FLOAT64)
        with pytest.raises(LogError, match=r"already logged as std_msgs/msg/Float64, not sensor_msgs"):
            log.add_topic("/a", JOINT_STATE)
        with pytest.raises(LogError, match="'b' is relative; a log needs the resolved name"):
            log.add_topic("b", FLOAT64)
        with pytest.raises(LogError, match="'acme_msgs/msg/Gear' is not among"):
            log.add_topic("/c", "acme_msgs/msg/Gear")
        with pytest.raises(LogError, match="'/c' is not declared"):
            log.write("/c", b"", 0, 0)
        with pytest.raises(LogError, match=r"log time -1 ns .* Check the clock"):
            log.write("/a", b"", -1, 0)
        with pytest.raises(LogError, match="from 0 to"):
            log.write("/a", b"", 0, 2**63)
        assert log.counters == {"/a": Counters(0, 0, 0)}


@pytest.mark.parametrize(
    ("argument", "value", "sentence"),
    [
        ("compression", "gzip", "'gzip' is unknown; use one of zstd, lz4, none"),
        ("chunk_size", 0, "chunk_size is 0; expected a number above 0"),
        ("sync_interval_s", float("nan"), "sync_interval_s is nan"),
        ("max_size_bytes", -1, "max_size_bytes is -1"),
        ("max_duration_s", 0.0, "max_duration_s is 0.0"),
    ],
)
def test_wrong_settings_are_refused_before_the_disk_is_touched(
    new_log: NewLog, tmp_path: Path, argument: str, value: object, sentence: str
) -> None:
    with pytest.raises(LogError, match=sentence):
        new_log(**{argument: value})
    assert list(tmp_path.iterdir()) == []
