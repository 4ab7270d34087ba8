"""Replays of whole logs, of later files and of snapshots: the forces again, bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.rerun import rerun
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.topics import ORIGIN_NAMES
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.sensing import Session
from seat_gear_dynamics.sensing.virtual_sensor import SENSOR_STATE_NAMES

NewLog = Callable[..., BagWriter]
STORE: Any = get_typestore(Stores.ROS2_JAZZY)
START = 1_795_336_238_123_456_789
STEP = 9_876_543
STATE_EVERY = 25


def joint(stamp: int, names: Sequence[str], **columns: Sequence[float]) -> bytes:
    """Return a serialized JointState."""
    fields = {key: np.array(columns.get(key, ()), dtype=np.float64) for key in ("position", "velocity", "effort")}
    header = STORE.types["std_msgs/msg/Header"](
        STORE.types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9), ""
    )
    message = STORE.types[topics.JOINT_STATE](header, list(names), **fields)
    return bytes(STORE.serialize_cdr(message, topics.JOINT_STATE))


def monitored(train: GearTrain, log: BagWriter, count: int, *, begin: int = 0, split: int | None = None) -> None:
    """Do what the monitor does for `count` samples, and record it from sample `begin` on."""
    session = Session(train)
    for topic in (topics.MODEL_INPUT, topics.MODEL_STATE, topics.MESH_FORCE):
        log.add_topic(topic.absolute(), topic.type, topic.qos)

    def record(topic: topics.Topic, data: bytes, stamp: int) -> None:
        if k >= begin:
            log.write(topic.absolute(), data, stamp, stamp)

    for k in range(count):
        if k == split:
            log.split(START + k * STEP)
        stamp = START + k * STEP
        speed, load = (1000 + 500 * np.sin(k / 9)) * RPM, 600.0 + k % 7
        session.feed((stamp - START) * 1e-9, speed, load)
        record(topics.MODEL_INPUT, joint(stamp, ["s1"], velocity=[speed], effort=[load]), stamp)
        if k % 3 != 2:
            continue
        windows = session.take_windows()
        names = [f"{mesh}/{s}" for mesh in ("s1_s2", "s3_s4") for s in ("mean", "min", "max", "rms")]
        record(
            topics.MESH_FORCE,
            joint(stamp, names, effort=[v for w in windows for v in (w.mean, w.min, w.max, w.rms)]),
            stamp,
        )
        if k % STATE_EVERY == STATE_EVERY - 1:
            state = session.sensor.state
            assert state is not None
            position = [*state, START // 10**9, START % 10**9]
            record(topics.MODEL_STATE, joint(stamp, [*SENSOR_STATE_NAMES, *ORIGIN_NAMES], position=position), stamp)


def test_a_log_from_the_first_sample_is_replayed_from_there(train: GearTrain, new_log: NewLog) -> None:
    with new_log() as log:
        monitored(train, log, 150)
    result = rerun(log.directory, train)
    assert (result.begins, result.samples, result.messages, result.equal) == ("first input", 150, 50, 50)


def test_a_log_that_begins_amid_a_run_is_replayed_from_the_first_state_in_it(train: GearTrain, new_log: NewLog) -> None:
    with new_log() as log:
        monitored(train, log, 300, begin=100)
    result = rerun(log.directory, train)
    # States stand at samples 74, 149, 224 and 299, behind the forces of the same sample.
    assert (result.begins, result.samples, result.messages) == ("model state", 150, 50)
    assert result.first_difference is None
    assert result.equal == 50


def test_a_later_file_of_a_split_log_is_replayed_alone(train: GearTrain, new_log: NewLog) -> None:
    """It begins with the latched state of sample 74, whose next inputs are in the file before: of no use."""
    with new_log() as log:
        monitored(train, log, 300, split=100)
    result = rerun(log.directory / "log_1.mcap", train)
    assert (result.begins, result.samples, result.equal, result.messages) == ("model state", 150, 50, 50)
    assert rerun(log.directory, train).equal == 100


def without(source: Path, target: Path, lost: set[int], *, wrong: int | None = None) -> Path:
    """Copy a log without these force messages; in number `wrong` of those left, flip the sign of the last number."""
    seen = kept = 0
    with BagWriter(target, system_text="", system_hash="", software_version="0") as writer:
        bag = Bag(source)
        for name, info in bag.topics.items():
            writer.add_topic(name, info.type)
        for topic, log_ns, publish_ns, data in bag.messages():
            if topic == topics.MESH_FORCE.absolute():
                seen += 1
                if seen in lost:
                    continue
                kept += 1
                data = data[:-1] + bytes([data[-1] ^ 0x80]) if kept == wrong else data
            writer.write(topic, data, log_ns, publish_ns)
    return target


@pytest.fixture
def recorded(train: GearTrain, new_log: NewLog, tmp_path: Path) -> Path:
    """A log from the first sample on, with 50 force messages, each over three samples."""
    with new_log(tmp_path / "recorded") as log:
        monitored(train, log, 150)
    return log.directory


@pytest.mark.parametrize("lost", [{1}, {1, 2, 3}])
def test_a_first_window_that_begins_behind_a_lost_message_is_counted_and_not_compared(
    train: GearTrain, recorded: Path, tmp_path: Path, lost: set[int]
) -> None:
    result = rerun(without(recorded, tmp_path / "cut", lost), train)
    assert (result.windows_before_log, result.first_difference, result.begins) == (1, None, "first input")
    assert result.messages == result.equal == 50 - len(lost) - 1
    logged, replayed = result.forces["s1_s2"]
    assert logged == replayed, "what is not compared has no share in the totals"


def test_a_log_with_its_first_force_message_has_no_window_before_it(train: GearTrain, recorded: Path) -> None:
    result = rerun(recorded, train)
    assert (result.windows_before_log, result.messages, result.equal) == (0, 50, 50)


@pytest.mark.parametrize(("lost", "wrong"), [({1}, 2), ({1}, 1), (set(), 1), (set(), 2)])
def test_a_wrong_message_is_named_all_the_same(
    train: GearTrain, recorded: Path, tmp_path: Path, lost: set[int], wrong: int
) -> None:
    """A first message that is equal from no sample on is no later beginning: it is wrong."""
    result = rerun(without(recorded, tmp_path / "cut", lost, wrong=wrong), train)
    assert result.windows_before_log == int(bool(lost) and wrong == 2)
    assert result.messages - result.equal == 1
    stamp = START + (3 * (len(lost) + wrong) - 1) * STEP
    assert result.first_difference is not None
    assert f"mesh_force, stamp {stamp} ns: " in result.first_difference


def test_the_only_force_message_may_be_the_one_that_is_not_compared(
    train: GearTrain, recorded: Path, tmp_path: Path
) -> None:
    result = rerun(without(recorded, tmp_path / "cut", set(range(1, 50))), train)
    assert (result.windows_before_log, result.messages, result.equal, result.identical) == (1, 0, 0, True)


def test_without_a_usable_state_the_difference_is_said(train: GearTrain, new_log: NewLog) -> None:
    with new_log() as log:
        monitored(train, log, 140, begin=100)
    result = rerun(log.directory, train)
    assert result.begins == "first input"
    assert result.first_difference is not None
    assert result.equal < result.messages


def test_a_wrong_train_is_noticed_from_a_state_too(
    train: GearTrain, make_train: Callable[..., GearTrain], new_log: NewLog
) -> None:
    with new_log() as log:
        monitored(train, log, 300, begin=100)
    result = rerun(log.directory, make_train({"meshes.*.backlash": 25}))
    assert result.equal == 0
    assert result.first_difference is not None


@pytest.mark.parametrize("fault", ["names", "nan"])
def test_states_that_cannot_be_used_are_passed_over(train: GearTrain, new_log: NewLog, fault: str) -> None:
    with new_log() as log:
        monitored(train, log, 60)
        names = ["other"] * 60 if fault == "names" else [*SENSOR_STATE_NAMES, *ORIGIN_NAMES]
        stamp = START + 60 * STEP
        data = joint(stamp, names, position=[np.nan] * 60)
        log.write(topics.MODEL_STATE.absolute(), data, stamp, stamp)
    result = rerun(log.directory, train)
    assert (result.begins, result.equal) == ("first input", 20)


def test_a_log_without_the_monitors_inputs_is_a_sentence(train: GearTrain, new_log: NewLog, tmp_path: Path) -> None:
    with new_log(tmp_path / "other") as log:
        log.add_topic("/a", topics.FLOAT64)
    with pytest.raises(LogError, match="no topic 'gear_monitor/input'"):
        rerun(log.directory, train)
