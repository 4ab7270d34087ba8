"""The recorder's behaviour without ROS: states, counts, dynamic topics, a disk that fills, snapshots by themselves."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from seat_gear_dynamics.logs.counters import Counters
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.recording import Recording
from seat_gear_dynamics.logs.snapshot import EventTrigger
from seat_gear_dynamics.logs.space import SpaceWatch
from seat_gear_dynamics.logs.topics import BOOL, DIAGNOSTIC_STATUS, FLOAT64, IN_FORBIDDEN_BAND, Qos
from seat_gear_dynamics.logs.writer import BagWriter

SECOND = 1_000_000_000
MB = 1_000_000
WARNING = "/gear_monitor/chaos_warning"
TOPICS = {"/a": (FLOAT64, Qos()), WARNING: (DIAGNOSTIC_STATUS, Qos())}


@pytest.fixture
def recording(new_log: Callable[..., BagWriter], tmp_path: Path) -> Recording:
    return Recording(
        tmp_path / "run",
        new_log,
        TOPICS,
        ring_seconds=5.0,
        trigger=EventTrigger(2, after=2.0, spacing=5.0, limit=3),
        trigger_topic=WARNING,
        space=SpaceWatch(reserve=100 * MB, warn_seconds=60.0),
    )


def feed(recording: Recording, count: int, start: int = SECOND, step: int = SECOND // 10) -> int:
    """Feed `count` messages; return the time behind the last."""
    for k in range(count):
        recording.receive("/a", bytes(12), start + k * step, 0)
    return start + count * step


def warn(recording: Recording, level: int, at: int) -> None:
    recording.receive(WARNING, b"\0\1\0\0" + bytes([level]) + bytes(20), at, 0)


def test_totals_run_through_all_bags_and_count_what_came_while_not_recording(recording: Recording) -> None:
    now = feed(recording, 3)
    recording.start()
    now = feed(recording, 10, now)
    recording.pause()
    now = feed(recording, 5, now)
    recording.resume()
    now = feed(recording, 2, now)
    recording.stop()
    recording.start()
    now = feed(recording, 7, now)
    recording.sync(now)
    assert recording.totals["/a"] == Counters(received=27, written=19, dropped=0)
    assert recording.counters["/a"] == Counters(7, 7, 0)
    assert recording.not_recorded["/a"] == 8
    recording.stop()
    assert Bag(recording.directory).topics["/a"].count == 12
    assert Bag(recording.directory).custom_data["messages of /a"] == "received 12, written 12, dropped 0"
    assert Bag(recording.directory.with_name("run_run2")).topics["/a"].count == 7


def test_a_topic_found_later_is_in_the_log_and_in_later_bags(recording: Recording) -> None:
    recording.start()
    now = feed(recording, 5)
    recording.add_topic("/band", BOOL, IN_FORBIDDEN_BAND.qos)
    recording.receive("/band", b"\0\1\0\0\1", now, 0)
    recording.split(now)
    recording.stop()
    recording.start()
    recording.stop()
    assert Bag(recording.directory).topics["/band"].count == 2, "repeated in the second file"
    assert "/band" in Bag(recording.directory.with_name("run_run2")).topics


def test_a_type_that_no_log_can_describe_is_refused_and_the_rest_goes_on(recording: Recording) -> None:
    recording.start()
    with pytest.raises(LogError, match="'acme_msgs/msg/Gear' is not among"):
        recording.add_topic("/gear", "acme_msgs/msg/Gear", Qos())
    feed(recording, 5)
    recording.stop()
    recording.start()
    assert Bag(recording.directory).topics["/a"].count == 5


def test_a_disk_that_fills_ends_the_log_in_good_time(recording: Recording) -> None:
    recording.start()
    feed(recording, 20)
    recording.watch_space(0.0, 500 * MB)
    recording.watch_space(10.0, 300 * MB)
    assert recording.space is not None
    assert (recording.space.room, recording.state) == ("low", "recording")
    with pytest.raises(LogError, match=r"was ended because its disk is full \(90 MB free.*\); make room"):
        recording.watch_space(20.0, 90 * MB)
    assert recording.state == "failed"
    assert recording.failure is not None
    recording.watch_space(21.0, 90 * MB)
    feed(recording, 5)
    assert recording.totals["/a"] == Counters(25, 20, 0)
    bag = Bag(recording.directory)
    assert bag.closed
    assert bag.damage is None
    assert bag.topics["/a"].count == 20
    assert "disk is full" in bag.custom_data["failure"]
    with pytest.raises(LogError, match=r"disk of .* is full .*make room, then start"):
        recording.start()
    recording.watch_space(22.0, 900 * MB)
    assert recording.start().name == "run_run2"
    assert recording.failure is None


def test_a_warning_that_begins_takes_a_snapshot_of_what_led_to_it_and_of_what_followed(recording: Recording) -> None:
    now = feed(recording, 100)
    warn(recording, 2, now)
    assert recording.take_due_snapshot(now + SECOND) is None
    feed(recording, 20, now)
    path = recording.take_due_snapshot(now + 2 * SECOND)
    assert path == recording.directory.with_name("run_snapshot1")
    assert recording.snapshots == [path]
    bag = Bag(path)
    assert bag.closed
    assert bag.custom_data["snapshot"] == "a warning began"
    times = [message.log_time_ns for message in bag.messages("/a")]
    # The ring's 5 s end with the last message: 3.1 s before the warning, 1.9 s behind it.
    assert (min(times), max(times)) == (now + 19 * SECOND // 10 - 5 * SECOND, now + 19 * SECOND // 10)
    assert bag.topics[WARNING].count == 1
    assert recording.take_due_snapshot(now + 99 * SECOND) is None


def test_a_snapshot_that_waits_is_taken_at_the_end(recording: Recording) -> None:
    warn(recording, 2, feed(recording, 10))
    assert recording.take_due_snapshot(SECOND, ending=True) is not None
    assert recording.take_due_snapshot(SECOND, ending=True) is None


def test_milder_levels_take_none(recording: Recording) -> None:
    now = feed(recording, 10)
    for level in (0, 1, 3):
        warn(recording, level, now)
    recording.receive(WARNING, b"", now, 0)
    assert recording.take_due_snapshot(now, ending=True) is None


def test_a_snapshot_in_a_taken_place_is_an_error_and_the_next_gets_another_name(recording: Recording) -> None:
    feed(recording, 10)
    recording.directory.with_name("run_snapshot1").mkdir()
    with pytest.raises(LogError, match="run_snapshot1 exists already"):
        recording.snapshot()
    assert recording.snapshot()[0].name == "run_snapshot2"
    assert recording.state == "stopped"


def test_messages_whose_time_is_not_known_are_counted_and_kept_out(recording: Recording) -> None:
    recording.start()
    recording.ignore("/a")
    assert recording.totals["/a"] == Counters(1, 0, 0)
    assert recording.not_recorded["/a"] == 1
    with pytest.raises(LogError, match="nothing to snapshot"):
        recording.snapshot()


def test_a_clock_that_steps_back_an_hour_goes_on_recording(recording: Recording) -> None:
    recording.start()
    feed(recording, 50, 3600 * SECOND + SECOND)
    now = feed(recording, 50, SECOND)
    recording.sync(now)
    assert recording.totals["/a"].written == 100
    directory, count = recording.snapshot()
    assert count == 50, "of before the step nothing is within 5 s"
    recording.stop()
    assert len(list(Bag(recording.directory).messages())) == 100
    assert Bag(directory).closed


@pytest.mark.parametrize(
    ("states", "action"),
    [((), "pause"), ((), "stop"), (("start",), "resume"), (("start", "pause"), "pause"), (("start", "stop"), "split")],
)
def test_what_the_state_does_not_allow_is_a_sentence(
    recording: Recording, states: tuple[str, ...], action: str
) -> None:
    for step in states:
        getattr(recording, step)()
    with pytest.raises(LogError, match=r"The recorder is \w+ and cannot be \w+; it has to be"):
        getattr(recording, action)(*([0] if action == "split" else []))
