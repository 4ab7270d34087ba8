"""Replays: bit for bit on this build, differences named, and what other parameters would have done."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.gears.description import parse_train
from seat_gear_dynamics.gears.errors import DescriptionError
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.rerun import rerun
from seat_gear_dynamics.logs.analysis.rerun_result import Rerun
from seat_gear_dynamics.logs.analysis.what_if import monitor_settings, split, with_values
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.sensing import AlarmSettings, Session


@pytest.fixture(scope="module")
def same(log: Path) -> Rerun:
    return rerun(log, load_train())


def test_every_output_is_equal_bit_for_bit_on_the_same_build(same: Rerun, log: Path) -> None:
    counts = {topic.lstrip("/"): info.count for topic, info in Bag(log).topics.items()}
    assert same.samples == counts["gear_monitor/input"]
    assert {each.topic: each.messages for each in same.topics} == {
        name: counts[name]
        for name in (f"gear_monitor/{what}" for what in ("mesh_force", "mesh_state", "poincare", "chaos_warning"))
    }
    assert same.first_difference is None
    assert same.identical
    assert same.forces["s1_s2"][0] == same.forces["s1_s2"][1]
    assert same.begins == "first input"


def test_one_wrong_bit_is_named_with_its_stamp_and_both_values(log: Path, tmp_path: Path, generator: Any) -> None:
    wrong, seen = tmp_path / "wrong", 0
    bag = Bag(log)
    with BagWriter(wrong, system_text="", system_hash="", software_version="0") as writer:
        for name, info in bag.topics.items():
            writer.add_topic(name, info.type)
        for topic, log_ns, publish_ns, data in bag.messages():
            seen += topic == "/gear_monitor/mesh_force"
            if topic == "/gear_monitor/mesh_force" and seen == 100:
                data = data[:-1] + bytes([data[-1] ^ 0x80])  # the sign of s3_s4's rms, the message's last number
            writer.write(topic, data, log_ns, publish_ns)
    found = rerun(wrong, load_train())
    forces = found.topics[0]
    assert (forces.messages - forces.equal, found.identical) == (1, False)
    assert found.first_difference is not None
    assert "gear_monitor/mesh_force, stamp 179" in found.first_difference
    assert "s3_s4/rms is -" in found.first_difference
    assert all(each.equal == each.messages for each in found.topics[1:])


def test_other_parameters_answer_what_if(log: Path, same: Rerun) -> None:
    train = parse_train(with_values(load_train().text, {"model.load_scale": str(2 * load_train().model.load_scale)}))
    found = rerun(log, train)
    logged, replayed = found.forces["s1_s2"]
    assert logged == same.forces["s1_s2"][0]
    # The mean force carries the torque, whatever the motion: it doubles but for the inertia of the run-up.
    assert replayed["mean"] / logged["mean"] == pytest.approx(2, rel=0.01)
    assert not found.identical


def test_a_wider_margin_leaves_less_time_at_ok_and_changes_no_force(log: Path) -> None:
    found = rerun(log, load_train(), monitor_settings({"margin_rpm": "200"}))
    logged, replayed = found.level_seconds
    assert replayed[0] < logged[0]
    assert replayed[1] > logged[1]
    assert {each.topic for each in found.topics if each.equal < each.messages} == {"gear_monitor/chaos_warning"}


def test_level_seconds_of_log_and_replay_agree_where_nothing_differs(same: Rerun) -> None:
    logged, replayed = same.level_seconds
    assert set(logged) == set(replayed)
    for level, seconds in logged.items():
        # Levels are logged as they change, and every 0.1 s: first and last stretch differ by so much.
        assert replayed[level] == pytest.approx(seconds, abs=0.11)


def test_progress_and_missing_topics(log: Path, third_party: Path) -> None:
    told: list[tuple[int, int]] = []
    rerun(log, load_train(), progress=lambda done, total: told.append((done, total)))
    assert told == [(500, 600)]
    with pytest.raises(LogError, match="no topic 'gear_monitor/input'"):
        rerun(third_party, load_train())


def test_a_real_benchs_log_starts_silent_and_is_compared_whole(bench_dwell: Path) -> None:
    kept = (Bag(bench_dwell).metadata or {})["system"]
    found = rerun(bench_dwell, parse_train(kept))
    assert found.samples == 810
    assert found.silences > 0
    forces = found.forces["s1_s2"]
    # On another machine rounding differs and chaos grows it; means over 16 s hold nevertheless.
    assert forces[1]["mean"] == pytest.approx(forces[0]["mean"], rel=1e-3)


def test_values_are_replaced_by_path_and_pattern_and_nothing_else_changes() -> None:
    plain = load_train()
    text = with_values(plain.text, {"meshes.*.damping_ratio": "0.11", "gears.s1.mass": "0.05", "bands[0].high": "1400"})
    found = parse_train(text)
    assert [mesh.damping_ratio for mesh in found.meshes] == [0.11, 0.11]
    assert found.gears[0].mass == 0.05
    assert found.bands[0].high == pytest.approx(1400 * RPM)
    assert found.gears[1] == plain.gears[1]
    assert found.model == plain.model
    assert parse_train(with_values(plain.text, {"model.time_scale": "derived"})).model.time_scale == pytest.approx(
        plain.derived_time_scale
    )


def test_what_cannot_be_set_is_refused_with_a_sentence() -> None:
    text = load_train().text
    assert with_values(text, {}) == text
    with pytest.raises(LogError, match=r"no parameter 'gears\.s9\.mass'"):
        with_values(text, {"gears.s9.mass": "1"})
    with pytest.raises(DescriptionError, match=r"gears.s1.mass: found -1"):
        parse_train(with_values(text, {"gears.s1.mass": "-1"}))
    with pytest.raises(LogError, match="expected NAME=VALUE"):
        split(["margin"])
    for name, value, sentence in (
        ("margin", "1", "is unknown"),
        ("horizon", "soon", "expected a number"),
        ("hold", "-1", "at least 0"),
        ("input_timeout", "0", "more than 0"),
    ):
        with pytest.raises(LogError, match=sentence):
            monitor_settings({name: value})


def test_settings_are_split_and_take_the_monitors_units() -> None:
    assert split(["a.b=1", "hold=2", "a.c==x"]) == ({"a.b": "1", "a.c": "=x"}, {"hold": "2"})
    found = monitor_settings({"margin_rpm": "60", "section_points": "10", "input_timeout": "2"})
    assert found.alarm == AlarmSettings(margin=60 * RPM)
    assert (found.max_gap, found.section_points) == (2.0, 10)
    assert np.isclose(monitor_settings({}).alarm.margin, 40 * RPM)


def test_a_wrong_section_point_is_named(log: Path, tmp_path: Path) -> None:
    wrong, seen, bag = tmp_path / "wrong", 0, Bag(log)
    with BagWriter(wrong, system_text="", system_hash="", software_version="0") as writer:
        for name, info in bag.topics.items():
            writer.add_topic(name, info.type)
        for topic, log_ns, publish_ns, data in bag.messages():
            seen += topic == "/gear_monitor/poincare"
            if topic == "/gear_monitor/poincare" and seen == 50:
                data = data[:-2] + bytes([data[-2] ^ 0x01]) + data[-1:]  # the last point's time, before is_dense
            writer.write(topic, data, log_ns, publish_ns)
    found = rerun(wrong, load_train())
    assert found.first_difference is not None
    assert "gear_monitor/poincare" in found.first_difference
    assert "t of point" in found.first_difference
    assert [each.messages - each.equal for each in found.topics] == [0, 0, 1, 0]


def test_silence_in_the_log_resets_the_alarm_of_the_replay_as_it_did_the_monitors(
    tmp_path: Path, generator: Any
) -> None:
    session, path = Session(load_train()), tmp_path / "silent"
    messages, step = generator.messages, generator.STEP_NS
    with BagWriter(path, system_text="", system_hash="", software_version="0") as writer:
        for topic in topics.TOPICS:
            writer.add_topic(topic.absolute(), topic.type, topic.qos)

        def put(topic: topics.Topic, message: Any, now: int) -> None:
            writer.write(topic.absolute(), generator.written(topic, message, 0, "").data, now, now)

        for k in range(60):
            now = generator.FIRST_NS + k * step
            # In the band, then out of it: without the silence between, ERROR would be held for 0.3 s.
            change = session.feed(k * step * 1e-9, (1800 if k < 30 else 1000) * RPM, 600.0)
            put(topics.CHAOS_WARNING, messages.chaos_warning("w", change.verdict, change.reading), now)
            put(topics.MODEL_INPUT, messages.model_input(now, change.reading.speed, 600.0), now)
            windows = session.take_windows()
            if windows[0].duration:
                put(topics.MESH_FORCE, messages.mesh_force(now, windows), now)
            if k == 29:
                session.silence("no speed for more than 0.5 s")
                put(topics.CHAOS_WARNING, messages.chaos_warning("w", session.verdict, session.sample), now + 1)
    found = rerun(path, load_train())
    assert found.silences == 1
    assert found.first_difference is None
    assert found.topics[-1].messages == 60
