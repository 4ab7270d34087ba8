"""The reader against our bags, other programs' bags, and bags that something has happened to."""

from __future__ import annotations

import math
import random
import shutil
import struct
from collections import Counter
from collections.abc import Callable, Collection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.writer import CompressionType, IndexType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from seat_gear_dynamics.logs.container import Block, Message, scan
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag, TopicInfo
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.topics import CHAOS_WARNING, FLOAT64, JOINT_STATE, MESH_STATE
from seat_gear_dynamics.logs.writer import BagWriter

NewLog = Callable[..., BagWriter]
Row = tuple[str, int, int, bytes]
SECOND = 1_000_000_000
STORE = get_typestore(Stores.ROS2_JAZZY)
Time, Header = STORE.types["builtin_interfaces/msg/Time"], STORE.types["std_msgs/msg/Header"]


def number(value: float) -> bytes:
    return struct.pack("<4sd", b"\0\1\0\0", value)


def fill(log: BagWriter, count: int) -> list[Row]:
    log.add_topic("/motor/speed", FLOAT64)
    rows = [("/motor/speed", SECOND + i * 1_000_000, i, number(i)) for i in range(count)]
    for topic, log_ns, publish_ns, data in rows:
        log.write(topic, data, log_ns, publish_ns)
    return rows


def joint_state(names: list[str], velocity: list[float], effort: list[float], stamp_ns: int) -> bytes:
    header = Header(stamp=Time(sec=stamp_ns // SECOND, nanosec=stamp_ns % SECOND), frame_id="")
    message = STORE.types[JOINT_STATE](
        header=header,
        name=names,
        position=np.array([]),
        velocity=np.array(velocity),
        effort=np.array(effort),
    )
    return bytes(STORE.serialize_cdr(message, JOINT_STATE))


def test_a_third_partys_bag_is_read(third_party: Path) -> None:
    bag = Bag(third_party)
    assert bag.topics == {
        "/motor/speed": TopicInfo(FLOAT64, 12619),
        "/load/torque": TopicInfo(FLOAT64, 12619),
        "/joint_states": TopicInfo(JOINT_STATE, 12619),
    }
    assert (bag.metadata, bag.damage, bag.closed, bag.message_count) == (None, None, True, 37857)
    assert (bag.start_ns, bag.end_ns - bag.start_ns) == (1795336238823342335, 63320725425)
    times = [message.log_time_ns for message in bag.messages()]
    assert times == sorted(times)
    assert len(times) == 37857
    assert len(list(bag.messages(["motor/speed", "/load/torque"]))) == 2 * 12619


def test_a_third_partys_series_agree_with_each_other(third_party: Path) -> None:
    bag = Bag(third_party)
    time, speed = bag.scalars("motor/speed")
    joint = bag.joint("joint_states")
    assert time.shape == speed.shape == joint.time.shape == (12619,)
    assert 0.0 <= time[0] < time[-1] <= 63.320725425
    np.testing.assert_array_equal(joint.velocity["seat_height"], speed)
    np.testing.assert_array_equal(joint.effort["seat_height"], bag.scalars("load/torque")[1])
    decoded = [message.message.data for message in bag.decoded("load/torque")]
    np.testing.assert_array_equal(decoded, bag.scalars("load/torque")[1])


def test_a_single_file_and_a_bag_without_metadata_are_read(new_log: NewLog) -> None:
    with new_log(max_duration_s=0.5) as log:
        rows = fill(log, 1000)
    assert list(Bag(log.files[1]).messages()) == rows[500:]
    (log.directory / "metadata.yaml").unlink()
    bag = Bag(log.directory)
    assert list(bag.messages()) == rows
    assert bag.damage is None


@pytest.mark.parametrize("text", ["", "][", "a: 1\n", "rosbag2_bagfile_information: 3\n", "\xff\x00"])
def test_a_broken_metadata_file_is_noted_and_ignored(new_log: NewLog, text: str) -> None:
    with new_log() as log:
        rows = fill(log, 10)
    (log.directory / "metadata.yaml").write_text(text, encoding="latin-1")
    bag = Bag(log.directory)
    assert list(bag.messages()) == rows
    assert bag.damage is not None
    assert "metadata.yaml cannot be read" in bag.damage


def test_files_are_found_beyond_and_short_of_the_metadata(new_log: NewLog) -> None:
    with new_log(max_duration_s=0.1) as log:
        rows = fill(log, 1100)
    assert len(log.files) == 11
    shutil.copy(log.files[0], log.directory / "notes.mcap")  # no file of this bag
    log.files[3].rename(log.directory / "log_11.mcap")  # as after a crash right behind a split
    bag = Bag(log.directory)
    assert bag.damage == "log_3.mcap, which metadata.yaml lists, is missing."
    assert [path.name for path in bag.files[-3:]] == ["log_9.mcap", "log_10.mcap", "log_11.mcap"]
    assert list(bag.messages()) == rows


def test_a_file_cut_anywhere_gives_what_lies_before_the_cut(new_log: NewLog, tmp_path: Path) -> None:
    with new_log(chunk_size=500) as log:
        rows = fill(log, 400)
    whole = log.files[0].read_bytes()
    cut = tmp_path / "cut.mcap"
    chance = random.Random(3)
    found: list[int] = []
    refusals: list[str] = []
    for length in sorted(chance.sample(range(len(whole)), 50)):
        cut.write_bytes(whole[:length])
        try:
            bag = Bag(cut)
        except LogError as error:
            refusals.append(str(error))
            found.append(0)
            continue
        messages = list(bag.messages())
        assert messages == rows[: len(messages)]
        assert bag.message_count == len(messages)
        assert bag.damage is not None
        assert not bag.closed or length > len(whole) - 8
        found.append(len(messages))
    assert all(text.startswith(f"Nothing in the log {cut} can be read: cut.mcap: it ") for text in refusals)
    assert found == sorted(found)
    assert found[0] == 0
    assert found[-1] == 400
    assert len(set(found)) > 10


def test_a_third_partys_file_cut_behind_its_chunk_is_whole(third_party: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(next(third_party.glob("*.mcap")).read_bytes()[:-300])
    bag = Bag(cut)
    assert [bag.topics[topic].count for topic in sorted(bag.topics)] == [12619] * 3
    assert sum(1 for _ in bag.messages()) == 37857
    assert bag.damage is not None
    assert not bag.closed


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_a_flipped_bit_costs_one_chunk_at_most(new_log: NewLog, tmp_path: Path, compression: str) -> None:
    with new_log(chunk_size=500, compression=compression) as log:
        rows = fill(log, 400)
    whole = log.files[0].read_bytes()
    # A chunk's first 44 bytes are its times, sizes and codec, which no checksum covers.
    checked = [range(b.offset + 44, b.offset + b.length) for b in scan(log.files[0]).blocks]
    flipped = tmp_path / "flipped.mcap"
    chance = random.Random(5)
    hits = 0
    for _ in range(150):
        wrong, place = bytearray(whole), chance.randrange(len(whole))
        wrong[place] ^= 1 << chance.randrange(8)
        flipped.write_bytes(wrong)
        hit = any(place in stretch for stretch in checked)
        hits += hit
        try:
            bag = Bag(flipped)
            messages = list(bag.messages())
        except LogError:
            continue
        data = [message.data for message in messages]
        assert set(data) <= {row[3] for row in rows}  # never a message that nobody wrote
        # Some bits of a codec's frame mean nothing: then the messages are whole.
        assert not hit or bag.damage is not None or data == [row[3] for row in rows]
        if len(data) < len(rows):
            assert bag.damage is not None or bag.topics.keys() != {"/motor/speed"}
    assert hits > 10


def test_a_damaged_chunk_in_the_middle_is_left_out(new_log: NewLog) -> None:
    with new_log(chunk_size=500, compression="none") as log:
        rows = fill(log, 400)
    content = log.files[0].read_bytes()
    at = content.index(number(200))
    log.files[0].write_bytes(content[:at] + b"X" + content[at + 1 :])
    bag = Bag(log.directory)
    messages = list(bag.messages())
    assert 350 < len(messages) < 400
    assert rows[0] in messages
    assert rows[-1] in messages
    assert rows[200] not in messages
    assert bag.damage is not None
    assert "cannot be unpacked" in bag.damage


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"not an mcap file at all", bytes(1000)])
def test_a_file_without_anything_to_read_is_a_sentence(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with pytest.raises(LogError, match=r"Nothing in the log .*x\.mcap can be read"):
        Bag(path)


def test_no_log_and_an_empty_folder_are_sentences(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="There is no log"):
        Bag(tmp_path / "nothing")
    with pytest.raises(LogError, match=r"holds no \.mcap file"):
        Bag(tmp_path)


@pytest.mark.parametrize("plugin", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_bags_that_rosbags_writes(tmp_path: Path, plugin: StoragePlugin) -> None:
    with RosbagsWriter(tmp_path / "theirs", version=9, storage_plugin=plugin) as writer:
        writer.set_custom_data("bench", "7")
        connection = writer.add_connection("/ns/motor/speed", FLOAT64, typestore=STORE)
        for i in range(100):
            writer.write(connection, 10 + i, number(i))
    if plugin is StoragePlugin.SQLITE3:
        (tmp_path / "theirs" / "x_0.mcap").touch()
        with pytest.raises(LogError, match=r"storage 'sqlite3' .* `ros2 bag convert`"):
            Bag(tmp_path / "theirs")
        return
    bag = Bag(tmp_path / "theirs")
    time, value = bag.scalars("motor/speed")
    np.testing.assert_array_equal(value, np.arange(100.0))
    np.testing.assert_allclose(time, np.arange(100.0) * 1e-9, atol=1e-18)
    assert bag.custom_data == {"bench": "7"}


Layout = Literal["unchunked", "no statistics", "no repeated channels", "no summary"]


@pytest.mark.parametrize("layout", ["unchunked", "no statistics", "no repeated channels", "no summary"])
def test_every_layout_of_an_mcap_file_is_read(tmp_path: Path, layout: Layout) -> None:
    options: dict[Layout, dict[str, Any]] = {
        "unchunked": {"use_chunking": False},
        "no statistics": {"use_statistics": False},
        "no repeated channels": {"repeat_channels": False, "repeat_schemas": False},
        "no summary": {
            "use_statistics": False,
            "repeat_channels": False,
            "repeat_schemas": False,
            "index_types": IndexType.NONE,
            "use_summary_offsets": False,
        },
    }
    path = tmp_path / "x.mcap"
    with open(path, "wb") as file:
        writer: Any = Writer(file, chunk_size=300, compression=CompressionType.NONE, **options[layout])
        writer.start("ros2")
        type_number = writer.register_schema(FLOAT64, "ros2msg", schema(FLOAT64).text.encode())
        channels = [writer.register_channel(topic, "cdr", type_number) for topic in ("/a", "/b")]
        times = [(i * 7) % 100 for i in range(100)]  # far from ordered
        for i, at in enumerate(times):
            writer.add_message(channels[i % 2], at, number(i), at)
        writer.finish()
    bag = Bag(path)
    assert bag.topics == {"/a": TopicInfo(FLOAT64, 50), "/b": TopicInfo(FLOAT64, 50)}
    assert [message.log_time_ns for message in bag.messages()] == sorted(times)
    assert {message.data for message in bag.messages("/b")} == {number(i) for i in range(1, 100, 2)}
    assert (bag.damage, bag.closed) == (None, layout != "no summary")


def test_a_long_log_is_read_block_by_block(new_log: NewLog, monkeypatch: pytest.MonkeyPatch) -> None:
    with new_log(chunk_size=500) as log:
        rows = fill(log, 400)
    bag = Bag(log.directory)
    load, loaded = Block.messages, []

    def counted(block: Block, channels: Collection[int], odd: Counter[int] | None = None) -> list[Message]:
        loaded.append(block)
        return load(block, channels, odd)

    monkeypatch.setattr(Block, "messages", counted)
    messages = bag.messages()
    assert next(messages) == rows[0]
    assert len(loaded) == 1
    assert list(messages) == rows[1:]
    assert len(loaded) > 10


@given(times=st.lists(st.integers(0, 30), min_size=1, max_size=60), size=st.integers(0, 400), cut=st.integers(0, 60))
def test_messages_come_by_log_time_and_as_written_where_that_is_equal(times: list[int], size: int, cut: int) -> None:
    rows = [("/a", at, i, number(i)) for i, at in enumerate(times)]
    with TemporaryDirectory() as folder:
        for k, part in enumerate((rows[:cut], rows[cut:])):
            with open(Path(folder) / f"x_{k}.mcap", "wb") as file:
                writer: Any = Writer(file, chunk_size=size, compression=CompressionType.NONE)
                writer.start("ros2")
                kind = writer.register_schema(FLOAT64, "ros2msg", schema(FLOAT64).text.encode())
                channel = writer.register_channel("/a", "cdr", kind)
                for _, log_ns, publish_ns, data in part:
                    writer.add_message(channel, log_ns, data, publish_ns)
                writer.finish()
        messages = list(Bag(folder).messages())
    assert messages == sorted(rows, key=lambda row: row[1])  # sorted is stable: the oracle for ties


def test_chunks_that_touch_or_overlap_do_not_chain_a_log_into_memory(
    new_log: NewLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Each chunk of two begins at the log time at which the last one ended, as with two messages in one instant.
    with new_log(sync_interval_s=1e9) as log:
        log.add_topic("/a", FLOAT64)
        for i in range(200):
            log.write("/a", number(i), SECOND * (1 + (i + 1) // 2), i)
            if i % 2:
                log.sync(SECOND * (1 + (i + 1) // 2))
    loaded: list[int] = []
    load = Block.messages

    def counted(block: Block, channels: Collection[int], odd: Counter[int] | None = None) -> list[Message]:
        found = load(block, channels, odd)
        loaded.append(len(found))
        return found

    monkeypatch.setattr(Block, "messages", counted)
    bag = Bag(log.directory)
    held = [sum(loaded) - n for n, _ in enumerate(bag.messages())]
    assert sum(loaded) == 200
    # A message waits for the one of its own time in the next chunk, and that chunk's other one with it.
    assert max(held) <= 4


def test_a_relative_name_finds_its_topic_in_any_namespace(new_log: NewLog) -> None:
    with new_log() as log:
        for topic in ("/one/motor/speed", "/two/motor/speed", "/one/load/torque", "/motor/current"):
            log.add_topic(topic, FLOAT64)
    bag = Bag(log.directory)
    assert bag.resolve("load/torque") == "/one/load/torque"
    assert bag.resolve("/motor/current") == bag.resolve("motor/current") == "/motor/current"
    with pytest.raises(LogError, match=r"several topics called 'motor/speed' \(/one/motor/speed, /two"):
        bag.messages("motor/speed")
    with pytest.raises(LogError, match=r"no topic '/load/torque'; it holds /motor/current, /one/load"):
        bag.scalars("/load/torque")
    with pytest.raises(LogError, match="no topic 'speed_of_light'"):
        bag.messages(["motor/current", "speed_of_light"])


def test_joints_are_gathered_by_name_with_gaps_as_nan(new_log: NewLog) -> None:
    stamp = 1_795_336_238 * SECOND + 5
    with new_log() as log:
        log.add_topic("/gear_monitor/mesh_state", JOINT_STATE, MESH_STATE.qos)
        for i, (names, effort) in enumerate([(["s1_s2"], [1.5]), (["s3_s4", "s1_s2"], [2.5, 3.5]), (["s1_s2"], [])]):
            data = joint_state(names, [float(i)] * len(names), effort, stamp + i)
            log.write("/gear_monitor/mesh_state", data, stamp + i * SECOND, stamp)
    joint = Bag(log.directory).joint("gear_monitor/mesh_state")
    np.testing.assert_array_equal(joint.time, [0.0, 1.0, 2.0])
    assert joint.stamp_ns.tolist() == [stamp, stamp + 1, stamp + 2]
    np.testing.assert_array_equal(joint.effort["s1_s2"], [1.5, 3.5, math.nan])
    np.testing.assert_array_equal(joint.effort["s3_s4"], [math.nan, 2.5, math.nan])
    np.testing.assert_array_equal(joint.velocity["s1_s2"], [0.0, 1.0, 2.0])
    assert joint.position == {}


def test_statuses_become_tuples(new_log: NewLog) -> None:
    pair, status = STORE.types["diagnostic_msgs/msg/KeyValue"], STORE.types[CHAOS_WARNING.type]
    message = status(
        level=2, name="chaos", message="inside", hardware_id="", values=[pair(key="Speed (rad/s)", value="141.8")]
    )
    with new_log() as log:
        log.add_topic("/gear_monitor/chaos_warning", CHAOS_WARNING.type)
        for at in (SECOND, 3 * SECOND):
            log.write("/gear_monitor/chaos_warning", bytes(STORE.serialize_cdr(message, CHAOS_WARNING.type)), at, at)
    statuses = Bag(log.directory).statuses("gear_monitor/chaos_warning")
    assert statuses == [(at, 2, "inside", {"Speed (rad/s)": "141.8"}) for at in (0.0, 2.0)]


def test_the_wrong_kind_of_topic_and_senseless_messages_are_sentences(new_log: NewLog) -> None:
    with new_log() as log:
        log.add_topic("/a", FLOAT64)
        log.write("/a", b"\0\1\0", 0, 0)
    bag = Bag(log.directory)
    with pytest.raises(LogError, match=r"/a of .* is std_msgs/msg/Float64; expected sensor_msgs/msg/JointState"):
        bag.joint("a")
    with pytest.raises(LogError, match="A message on /a has 3 bytes"):
        bag.scalars("a")
    with pytest.raises(LogError, match="3 bytes do not hold a message"):
        list(bag.decoded("a"))


def test_a_big_endian_number_is_read(new_log: NewLog) -> None:
    with new_log() as log:
        log.add_topic("/a", FLOAT64)
        log.write("/a", struct.pack(">4sd", b"\0\0\0\0", 1.25), 0, 0)
    assert Bag(log.directory).scalars("a")[1].tolist() == [1.25]
