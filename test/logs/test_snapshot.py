"""The ring of the last seconds, and when a snapshot is due."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.logs.batch import Kept
from seat_gear_dynamics.logs.snapshot import EventTrigger, Ring

SECOND = 1_000_000_000
MUCH = 10**9


def filled(ring: Ring, times: list[int], topic: str = "/a") -> Ring:
    for t in times:
        ring.add(topic, str(t).encode(), t, t)
    return ring


def test_the_ring_keeps_the_last_seconds_and_no_more() -> None:
    ring = filled(Ring(2.0, MUCH), [k * SECOND // 10 for k in range(100)])
    assert [kept.log_ns for kept in ring.messages()] == [k * SECOND // 10 for k in range(79, 100)]


@given(st.lists(st.integers(0, 100 * SECOND), min_size=1, max_size=60), st.integers(1, 20))
def test_whatever_the_clock_does_the_oldest_is_within_the_span_of_the_newest(times: list[int], span: int) -> None:
    ring = filled(Ring(span, MUCH), times)
    kept = [message.log_ns for message in ring.messages()]
    assert kept == times[len(times) - len(kept) :]
    assert abs(kept[0] - kept[-1]) <= span * SECOND


def test_a_clock_that_steps_back_an_hour_does_not_make_the_ring_grow() -> None:
    hour = 3600 * SECOND
    before = [hour + k * SECOND // 10 for k in range(100)]
    after = [k * SECOND // 10 for k in range(100)]
    ring = filled(Ring(1.0, MUCH), before + after)
    assert [kept.log_ns for kept in ring.messages()] == after[-11:]


def test_a_flood_is_held_by_the_bytes_it_may_take() -> None:
    ring = Ring(3600.0, 100_000)
    for k in range(10_000):
        ring.add("/flood", bytes(700), k, k)
    assert len(ring) == 100  # 700 bytes and 300 of overhead each
    ring.add("/flood", bytes(200_000), 10_001, 0)
    assert len(ring) == 0, "a message larger than the room is not kept"
    assert ring.messages() == []


def test_the_last_of_a_latched_topic_stands_at_the_rings_beginning() -> None:
    ring = Ring(1.0, MUCH)
    ring.latch("/band")
    ring.add("/band", b"old", 0, 1)
    ring.add("/band", b"new", 1, 2)
    filled(ring, [k * SECOND for k in range(5, 8)])
    assert ring.messages()[0] == Kept("/band", b"new", 6 * SECOND, 2)
    ring.add("/band", b"newest", 7 * SECOND, 3)
    assert [kept.data for kept in ring.messages() if kept.topic == "/band"] == [b"newest"], "it is in the ring itself"


def trigger(limit: int = 9) -> EventTrigger:
    return EventTrigger(2, after=2.0, spacing=10.0, limit=limit)


OK, WARN, ERROR, STALE = range(4)


def test_a_snapshot_is_due_some_time_after_the_beginning() -> None:
    event = trigger()
    assert [event.update(level, 0) for level in (OK, WARN, STALE, ERROR, ERROR)] == [False, False, False, True, False]
    assert event.waiting
    assert not event.due(2 * SECOND - 1)
    assert event.due(2 * SECOND)
    event.taken(2 * SECOND)
    assert not event.waiting
    assert not event.due(99 * SECOND)


def test_a_warning_that_comes_and_goes_takes_no_second_snapshot_within_the_spacing() -> None:
    event = trigger()
    event.update(ERROR, 0)
    assert not event.update(OK, SECOND)
    assert not event.update(ERROR, SECOND), "one waits already"
    event.taken(2 * SECOND)
    event.update(OK, 3 * SECOND)
    assert not event.update(ERROR, 11 * SECOND)
    event.update(OK, 11 * SECOND)
    assert event.update(ERROR, 12 * SECOND)


def test_no_more_than_the_limit_are_taken() -> None:
    event = trigger(limit=2)
    begun = 0
    for k in range(10):
        begun += event.update(ERROR, k * 60 * SECOND)
        event.taken(k * 60 * SECOND)
        event.update(OK, k * 60 * SECOND)
    assert begun == 2


def test_a_clock_that_steps_back_does_not_hold_a_snapshot_up() -> None:
    event = trigger()
    event.update(ERROR, 3600 * SECOND)
    assert event.due(0)
