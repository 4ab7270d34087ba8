"""Replays of whole logs, of later files and of snapshots: the forces again, bit for bit."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from seat_gear_dynamics.commands import main
from seat_gear_dynamics.gears import GearTrain, packaged_description
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.rerun import rerun
from seat_gear_dynamics.logs.analysis.what_if import (
    MonitorSettings,
    monitor_settings,
    other_bands,
    recorded_bands,
    with_numbers,
)
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.topics import ORIGIN_NAMES
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.regimes import RegimeMap
from seat_gear_dynamics.regimes.regime_map import fingerprint
from seat_gear_dynamics.sensing import BandSource, MapBands, Session, Verdict, packaged_map
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


def warning(verdict: Verdict, *, says_bands: bool) -> bytes:
    """Return a serialized warning, with its bands as newer monitors name them."""
    values = [STORE.types["diagnostic_msgs/msg/KeyValue"]("bands", verdict.bands)] if says_bands else []
    level, kind = int(verdict.level), STORE.types[topics.DIAGNOSTIC_STATUS]
    return bytes(STORE.serialize_cdr(kind(level, "w", verdict.reason, "", values), topics.DIAGNOSTIC_STATUS))


def event(values: Mapping[str, float], *, node: str = "/gear_monitor", new: bool = False) -> bytes:
    """Return a serialized event of parameters, with one beside them that no replay knows."""
    value, parameter = STORE.types["rcl_interfaces/msg/ParameterValue"], STORE.types["rcl_interfaces/msg/Parameter"]
    kind, none = STORE.types[topics.PARAMETER_EVENTS.type], np.array([])

    def one(name: str, number: float) -> Any:
        of, whole = (2, int(number)) if name == "section_points" else (3, 0)
        arrays: tuple[Any, ...] = (none.astype(np.uint8), none.astype(bool), none.astype(np.int64), none, [])
        return parameter(name, value(of, False, whole, 0.0 if of == 2 else number, "", *arrays))

    given = [one(name, number) for name, number in {**values, "publish_rate": 20.0}.items()]
    now = STORE.types["builtin_interfaces/msg/Time"](0, 0)
    return bytes(STORE.serialize_cdr(kind(now, node, given if new else [], [] if new else given, []), kind.__msgtype__))


def monitored(
    train: GearTrain,
    log: BagWriter,
    count: int,
    *,
    begin: int = 0,
    split: int | None = None,
    bands: BandSource | None = None,
    says_bands: bool | None = None,
    changes: Mapping[int, Mapping[str, float]] | None = None,
    tells: bool = True,
) -> None:
    """Do what the monitor does for `count` samples, and record it from sample `begin` on.

    Warnings are recorded too where it is given whether they say their bands; `changes` of parameters come right before
    the samples that they are named by, and are recorded too where it `tells` of them.
    """
    session, settings = Session(train, bands=bands), MonitorSettings()
    recorded = [topics.MODEL_INPUT, topics.MODEL_STATE, topics.MESH_FORCE, topics.CHAOS_WARNING]
    for topic in (*recorded, *((topics.PARAMETER_EVENTS,) if changes and tells else ())):
        log.add_topic(topic.absolute(), topic.type, topic.qos)

    def record(topic: topics.Topic, data: bytes, stamp: int) -> None:
        if k >= begin:
            log.write(topic.absolute(), data, stamp, stamp)

    for k in range(count):
        if k == split:
            log.split(START + k * STEP)
        stamp = START + k * STEP
        if changes and k in changes:
            settings = with_numbers(settings, changes[k])
            if settings.alarm != session.alarm.settings:  # as the monitor's Watch.adopt
                session.alarm.settings = settings.alarm
                session.alarm.reset()
            session.sensor.max_gap = settings.max_gap
            if tells:
                record(topics.PARAMETER_EVENTS, event(changes[k], new=k == 0), stamp - 1)
                record(topics.PARAMETER_EVENTS, event({"margin_rpm": 999.0}, node="/other"), stamp - 1)
        speed, load = (1000 + 500 * np.sin(k / 9)) * RPM, 600.0 + k % 7
        verdict = session.feed((stamp - START) * 1e-9, speed, load).verdict
        if says_bands is not None:
            record(topics.CHAOS_WARNING, warning(verdict, says_bands=says_bands), stamp)
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


@pytest.fixture
def chart(train: GearTrain) -> MapBands:
    """Bands of a map of `train` with chaos from 700 to 1000 r/min, where nothing is published."""
    speeds, loads = np.linspace(100, 2100, 21) * RPM, np.array([300.0, 900.0])
    chaos = np.tile(((speeds >= 700 * RPM) & (speeds <= 1000 * RPM)).astype(float), (2, 1))
    zeros = np.zeros(chaos.shape, dtype=np.int64)
    found = RegimeMap(speeds, loads, zeros, zeros, chaos, chaos, chaos, chaos, 0, fingerprint(train), 1, 48)
    return MapBands(found, train)


def test_a_log_judged_by_a_map_is_replayed_with_it_bit_for_bit(
    train: GearTrain, chart: MapBands, new_log: NewLog
) -> None:
    with new_log() as log:
        monitored(train, log, 150, bands=chart, says_bands=True)
    assert recorded_bands(Bag(log.directory)) == chart.label
    same = rerun(log.directory, train, MonitorSettings(bands=chart))
    assert same.identical
    assert same.bands == (chart.label, chart.label)
    other = rerun(log.directory, train)
    assert other.bands == (chart.label, "published")
    assert other.topics[0].equal == other.topics[0].messages == 50, "forces do not depend on bands"
    assert other.topics[-1].equal < other.topics[-1].messages


def test_a_log_that_does_not_say_its_bands_is_taken_for_the_published_ones(
    train: GearTrain, chart: MapBands, new_log: NewLog
) -> None:
    with new_log() as log:
        monitored(train, log, 60, says_bands=False)
    assert recorded_bands(Bag(log.directory)) is None
    assert rerun(log.directory, train).identical
    assert rerun(log.directory, train, MonitorSettings(bands=chart)).bands == (None, chart.label)


def test_a_log_without_warnings_names_no_bands(train: GearTrain, new_log: NewLog) -> None:
    with new_log() as log:
        monitored(train, log, 30)
    assert recorded_bands(Bag(log.directory)) is None


@pytest.mark.parametrize(
    ("logged", "replayed", "words"),
    [
        (None, "published", None),
        ("published", "published", None),
        ("map 0123", "map 0123", None),
        ("map 0123", "published", "of `map 0123`, the replay's by those of `published`"),
        ("published", "map 0123", "of `published`, the replay's by those of `map 0123`"),
        (None, "map 0123", "does not say"),
    ],
)
def test_other_bands_are_said_in_words(logged: str | None, replayed: str, words: str | None) -> None:
    found = other_bands(logged, replayed)
    assert (found is None) == (words is None)
    if words is not None:
        assert found is not None
        assert words in found


def test_the_command_judges_by_a_map_and_says_that_the_log_was_judged_otherwise(
    capsys: pytest.CaptureFixture[str],
) -> None:
    described = packaged_description()
    log = str(Path(__file__).parents[2] / "bags" / "bench_dwell")
    words = ["--system", str(described), "--map", str(packaged_map()), "--json"]
    assert main(["replay", log, *words]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["what_if"] is True
    assert values["bands"]["logged"] in (None, "published")
    assert values["bands"]["replayed"].startswith("map ")
    assert values["other_bands"].count("`") in (2, 4)


def test_the_command_refuses_what_is_no_map_in_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "map.npz").write_bytes(b"no map")
    log = str(Path(__file__).parents[2] / "bags" / "bench_dwell")
    assert main(["replay", log, "--map", str(tmp_path / "map.npz")]) == 1
    assert "cannot be used" in capsys.readouterr().err


CHANGES = {0: {"margin_rpm": 60.0}, 40: {"margin_rpm": 90.0, "hysteresis_rpm": 8.0}, 95: {"debounce": 0.0}}


def test_thresholds_that_were_changed_at_run_time_are_followed(train: GearTrain, new_log: NewLog) -> None:
    with new_log() as log:
        monitored(train, log, 150, says_bands=True, changes=CHANGES)
    found = rerun(log.directory, train)
    assert found.identical
    assert (found.setting_changes, found.threshold_words) == (3, None)
    assert found.topics[-1].messages == 150


def test_a_change_takes_effect_with_its_own_sample(train: GearTrain, new_log: NewLog, tmp_path: Path) -> None:
    """The same changes told of a sample later are another run."""
    with new_log() as log:
        monitored(train, log, 150, says_bands=True, changes=CHANGES)
    with new_log(tmp_path / "later") as later:
        for name, info in Bag(log.directory).topics.items():
            later.add_topic(name, info.type)
        for topic, log_ns, publish_ns, data in Bag(log.directory).messages():
            late = STEP if topic == topics.PARAMETER_EVENTS.name else 0
            later.write(topic, data, log_ns + late, publish_ns + late)
    assert not rerun(later.directory, train).identical


def test_what_was_asked_for_is_not_changed_by_the_log(train: GearTrain, new_log: NewLog) -> None:
    with new_log() as log:
        monitored(train, log, 150, says_bands=True, changes=CHANGES)
    asked = rerun(log.directory, train, monitor_settings({"margin_rpm": "90"}))
    assert asked.topics[-1].equal < asked.topics[-1].messages
    assert monitor_settings({"margin_rpm": "90"}).given == {"margin_rpm"}


def test_changes_that_the_log_does_not_tell_of_are_named_as_what_may_be(
    train: GearTrain, new_log: NewLog, capsys: pytest.CaptureFixture[str]
) -> None:
    with new_log(system_text=train.text) as log:
        monitored(train, log, 150, says_bands=True, changes={40: CHANGES[40]}, tells=False)
    found = rerun(log.directory, train)
    assert found.equal == found.messages
    assert found.setting_changes is None
    words = found.threshold_words
    assert words is not None
    first = START + 40 * STEP
    assert "changed at run time" in words
    named = int(words.split("log time ")[1].split(" ns")[0])
    assert first <= named < first + 30 * STEP, "the first warning that differs, soon after the change"
    assert f"({(named - START) * 1e-9:.2f} s into the log)" in words
    assert main(["replay", str(log.directory)]) == 1
    assert words in capsys.readouterr().out


def test_other_forces_or_bands_are_not_laid_to_the_thresholds(
    train: GearTrain, make_train: Callable[..., GearTrain], chart: MapBands, new_log: NewLog
) -> None:
    with new_log() as log:
        monitored(train, log, 150, bands=chart, says_bands=True)
    assert rerun(log.directory, train).threshold_words is None
    assert rerun(log.directory, make_train({"meshes.*.backlash": 25})).threshold_words is None


def test_a_section_length_of_the_start_is_taken_from_its_declaration(train: GearTrain, new_log: NewLog) -> None:
    with new_log() as log:
        monitored(train, log, 60, says_bands=True, changes={0: {"section_points": 64.0, "input_timeout": 0.3}})
    found = rerun(log.directory, train)
    assert (found.identical, found.setting_changes) == (True, 1)


@pytest.mark.parametrize("values", [{"input_timeout": 0.0}, {"section_points": 0.0}, {"hold": -1.0}])
def test_impossible_numbers_are_a_sentence(values: dict[str, float]) -> None:
    with pytest.raises(LogError, match="expected"):
        with_numbers(MonitorSettings(), values)
