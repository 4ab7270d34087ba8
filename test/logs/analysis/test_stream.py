"""Bags as batches: nothing lost, nothing twice, whatever topics speed and load come from."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.sources import Measured, Source
from seat_gear_dynamics.logs.analysis.stream import Stream
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.run import read_run
from seat_gear_dynamics.logs.writer import BagWriter


class Recorded(Stream):
    """A stream without the model: what a log of inputs holds, and no more."""

    def __init__(self, bag: Bag, source: Source | None = None) -> None:
        super().__init__(bag, load_train(), source)
        self._estimated = None


def drive_of(path: Path, source: Source | None = None) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.concatenate([batch.drive for batch in Recorded(Bag(path), source).batches()])


def test_a_foreign_bag_gives_every_sample_once_from_topics_and_from_joint_states(third_party: Path) -> None:
    from_topics = drive_of(third_party)
    from_joints = drive_of(third_party, Source(speed_topic="joint_states"))
    assert len(from_joints) == 12619
    from_joints = from_joints[1:]  # the first speed came before the first load: from two topics it is no sample yet
    assert len(from_topics) == 12618
    # Joint states stand at their stamps, the others at the time they reached the recorder: by the longest gap later.
    np.testing.assert_allclose(from_topics[:, 0], from_joints[:, 0], atol=0.0166)
    np.testing.assert_array_equal(from_topics[:, 1], from_joints[:, 1])
    run = read_run(third_party)
    np.testing.assert_array_equal(np.sort(from_topics[:, 1]), np.sort(run.speed[1][1:]))


def test_units_are_converted(third_party: Path) -> None:
    plain, scaled = drive_of(third_party), drive_of(third_party, Source(speed_unit="r/min", load_unit="mNm"))
    np.testing.assert_allclose(scaled[:, 1], plain[:, 1] * RPM)
    np.testing.assert_allclose(scaled[:, 2], plain[:, 2] * 1e-3)


def test_no_process_at_all_is_refused(third_party: Path) -> None:
    with pytest.raises(LogError, match="number of processes is 0, expected at least 1"):
        Stream(Bag(third_party), load_train(), workers=0)


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        ({"speed_unit": "furlong"}, "expected one of rad/s"),
        ({"load_unit": "kg"}, "expected one of N·m"),
    ],
)
def test_unknown_units_are_refused(source: dict[str, str], sentence: str) -> None:
    with pytest.raises(LogError, match=sentence):
        Source(**source)


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        (Source(speed_topic="nowhere"), "no topic 'nowhere'"),
        (Source(load_topic="nowhere"), "no topic 'nowhere'"),
        (Source(speed_topic="motor/speed", load_topic="motor/speed"), "expected different topics"),
    ],
)
def test_topics_that_cannot_be_are_refused(source: Source, sentence: str, third_party: Path) -> None:
    with pytest.raises(LogError, match=sentence):
        Stream(Bag(third_party), load_train(), source)


def test_a_joint_that_no_message_names_gives_no_drive(third_party: Path) -> None:
    assert len(drive_of(third_party, Source("joint_states", joint="nobody"))) == 0


def test_a_log_of_ours_gives_all_outputs_as_the_reader_reads_them(log: Path) -> None:
    bag = Bag(log)
    stream = Stream(bag, load_train())
    batches = list(stream.batches())
    run, counts = read_run(log), {topic.lstrip("/"): info.count for topic, info in bag.topics.items()}
    assert not stream.estimated
    force = np.concatenate([batch.force for batch in batches])
    assert run.force is not None
    assert len(force) == counts["gear_monitor/mesh_force"]
    np.testing.assert_array_equal(force[:, 3], run.force.effort["s1_s2/max"])
    assert sum(len(batch.state) for batch in batches) == counts["gear_monitor/mesh_state"]
    assert sum(len(batch.drive) for batch in batches) == counts["gear_monitor/input"]
    assert sum(len(batch.warnings) for batch in batches) == counts["gear_monitor/chaos_warning"]
    section = np.concatenate([batch.section for batch in batches])
    np.testing.assert_allclose(section[:, :3], run.section[:, [2, 0, 1]], atol=1e-6)  # times of 1e9 s to 0.3 µs
    assert (np.diff(section[:, 0]) > 0).all()
    flows = {flow.topic: flow for flow in stream.flows.found()}
    for name in bag.topics:
        sent = np.array([message.publish_time_ns for message in bag.messages(name)])
        assert flows[name].count == len(sent)
        if len(sent) > 1:
            np.testing.assert_allclose(flows[name].longest_gap, np.diff(sent).max() * 1e-9)
            np.testing.assert_allclose(flows[name].period, np.median(np.diff(sent)) * 1e-9)


def test_progress_reaches_all_messages(log: Path) -> None:
    told: list[tuple[int, int]] = []
    bag = Bag(log)
    for _ in Stream(bag, load_train(), seconds=1.0).batches(lambda done, total: told.append((done, total))):
        pass
    assert told[-1] == (bag.message_count, bag.message_count)
    assert [done for done, _ in told] == sorted(done for done, _ in told)


def floats(path: Path, rows: list[tuple[int, float]], *, every: int = 3) -> Path:
    """Write speeds at log times in ms, in the order given, a chunk every few; one load stands from 0 on."""
    with BagWriter(path, system_text="", system_hash="", software_version="0", sync_interval_s=1e6) as writer:
        for topic in (topics.MOTOR_SPEED, topics.LOAD_TORQUE):
            writer.add_topic(topic.absolute(), topic.type, topic.qos)
        writer.write(topics.LOAD_TORQUE.absolute(), b"\0\1\0\0" + np.float64(600).tobytes(), 10**9, 10**9)
        for n, (ms, speed) in enumerate(rows):
            now = 10**9 + ms * 10**6
            writer.write(topics.MOTOR_SPEED.absolute(), b"\0\1\0\0" + np.float64(speed).tobytes(), now, now)
            if n % every == every - 1:
                writer.sync(now)
    return path


def test_chunks_whose_times_overlap_come_in_order(tmp_path: Path) -> None:
    times = [10, 40, 20, 30, 60, 50, 35, 90, 80, 70, 100, 45]
    path = floats(tmp_path / "log", [(ms, float(ms)) for ms in times])
    assert Bag(path).message_count == 13
    np.testing.assert_allclose(drive_of(path)[:, 1], sorted(times))


def test_repeated_and_late_samples_are_refused_and_a_clock_set_back_is_followed(tmp_path: Path) -> None:
    path = floats(tmp_path / "log", [(10, 1.0), (20, 2.0), (20, 3.0), (30, 4.0)])
    np.testing.assert_array_equal(drive_of(path)[:, 1], [1, 2, 4])
    stream = Recorded(Bag(path))
    stream._load = 600.0
    for t, speed in ((5.0, 1.0), (5.2, 2.0), (5.1, 3.0), (2.0, 4.0), (2.1, 5.0)):
        said = Measured(None, speed, None)
        stream._take_drive({b"": said}.__getitem__, 0, round(t * 1e9) + stream.bag.start_ns, b"")
    assert [row[1] for row in stream._drive] == [1.0, 2.0, 5.0]
