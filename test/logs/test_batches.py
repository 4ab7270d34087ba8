"""Messages written many at a time: byte for byte what writing them one after the other makes, in every respect."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.logs import disk
from seat_gear_dynamics.logs.batch import Batch, Kept
from seat_gear_dynamics.logs.counters import Counters
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.limits import Limits
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.recording import Recording
from seat_gear_dynamics.logs.snapshot import EventTrigger, Ring
from seat_gear_dynamics.logs.topics import BOOL, DIAGNOSTIC_STATUS, FLOAT64, IN_FORBIDDEN_BAND, Qos
from seat_gear_dynamics.logs.writer import BagWriter

SECOND = 1_000_000_000
NAMES = ("/a", "/b", "/band")
TYPES = (FLOAT64, FLOAT64, BOOL)
QOS = (Qos(), Qos(), IN_FORBIDDEN_BAND.qos)
WARNING = "/gear_monitor/chaos_warning"

NewLog = Callable[..., BagWriter]


def batch_of(messages: Sequence[Kept], names: tuple[str, ...] = NAMES) -> Batch:
    """Lay messages out as a batch, in a buffer with a gap before each."""
    data = b"".join(b"#" + kept.data for kept in messages)
    sizes = np.array([len(kept.data) for kept in messages], np.int64)
    return Batch(
        names,
        np.array([names.index(kept.topic) for kept in messages], np.int64),
        np.cumsum(sizes + 1) - sizes,
        sizes,
        np.array([kept.log_ns for kept in messages], np.int64),
        np.array([kept.publish_ns for kept in messages], np.int64),
        np.frombuffer(data, np.uint8),
    )


class Story(NamedTuple):
    """Messages, where they are cut into batches, and the limits of the log they go to."""

    messages: list[Kept]
    cuts: list[int]
    limits: dict[str, Any]


@st.composite
def stories(draw: st.DrawFn) -> Story:
    steps = draw(
        st.lists(
            st.tuples(st.sampled_from(NAMES), st.sampled_from([0, 1, 10**8, 4 * 10**8, SECOND, -(10**8), -5 * SECOND])),
            max_size=60,
        )
    )
    now, messages = 100 * SECOND, []
    for k, (topic, step) in enumerate(steps):
        now = max(0, now + step)
        messages.append(Kept(topic, bytes([k]) * draw(st.integers(0, 60)), now, k))
    cuts = sorted(draw(st.sets(st.integers(1, max(1, len(messages) - 1)), max_size=6)))
    limits = {
        "chunk_size": draw(st.sampled_from([1, 200, 1000, 10**6])),
        "sync_interval_s": draw(st.sampled_from([0.3, 1.0, 1e6])),
        "max_duration_s": draw(st.sampled_from([None, 0.5, 2.0])),
        "max_size_bytes": draw(st.sampled_from([None, 3000, 10_000])),
        "keep_files": draw(st.sampled_from([None, 3])),
        "compression": draw(st.sampled_from(["none", "zstd"])),
    }
    return Story(messages, cuts, limits)


def pieces(story: Story) -> list[list[Kept]]:
    edges = [0, *story.cuts, len(story.messages)]
    return [story.messages[a:b] for a, b in pairwise(edges)]


def written(new_log: NewLog, folder: Path, story: Story, *, whole: bool) -> tuple[dict[str, bytes], Any]:
    with new_log(folder / "log", **story.limits) as log:
        for name, kind, qos in zip(NAMES, TYPES, QOS, strict=True):
            log.add_topic(name, kind, qos)
        for piece in pieces(story):
            if whole:
                assert log.write_batch(batch_of(piece))
            else:
                for kept in piece:
                    assert log.write(*kept)
        counters = log.counters
    return {path.name: path.read_bytes() for path in (folder / "log").iterdir()}, counters


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(stories())
def test_a_batch_makes_the_same_files_as_its_messages(
    new_log: NewLog, monkeypatch: pytest.MonkeyPatch, story: Story
) -> None:
    monkeypatch.setattr("os.fsync", lambda handle: None)  # what is compared needs no disk
    with TemporaryDirectory() as one, TemporaryDirectory() as other:
        assert written(new_log, Path(one), story, whole=True) == written(new_log, Path(other), story, whole=False)


@settings(max_examples=100, deadline=None)
@given(stories(), st.sampled_from([0.2, 1.0, 3.0]))
def test_the_ring_keeps_the_same_messages(story: Story, seconds: float) -> None:
    # Beside their data messages of a batch take less memory, so that only unlimited rings keep the same.
    one, other = Ring(seconds, 10**9), Ring(seconds, 10**9)
    for ring in (one, other):
        ring.latch("/band")
    for piece in pieces(story):
        if piece:
            one.add_batch(batch_of(piece))
        for kept in piece:
            other.add(*kept)
    assert one.messages() == other.messages()
    assert len(one) == len(other)


def test_a_ring_of_batches_is_held_by_the_bytes_it_may_take() -> None:
    ring = Ring(3600.0, 100_000)
    for k in range(100):
        ring.add_batch(batch_of([Kept("/a", bytes(960), 10 * k + i, 0) for i in range(10)]))
    assert len(ring) == 100  # 960 bytes and 40 of overhead each
    assert [kept.log_ns for kept in ring.messages()] == list(range(900, 1000))
    ring.add_batch(batch_of([Kept("/a", bytes(200_000), 1001, 0)]))
    assert len(ring) == 0, "a message larger than the room is not kept"
    assert ring.parts() == []


def test_a_run_ends_where_a_limit_has_to_be_asked() -> None:
    limits = Limits(1000, 1.0, None, 5.0)
    times = np.array([0, 4, 10, 11, 30, 60], np.int64) * SECOND // 10
    assert limits.run(times, None, 0, None) == 3, "the third is 1 s behind the first: a sync is due with it"
    assert limits.run(times[3:], 11 * SECOND // 10, 0, 0) == 2
    assert limits.run(times[5:], 55 * SECOND // 10, 0, 0) == 1, "one at least"
    slow = Limits(1000, 100.0, None, 5.0)
    assert slow.run(times, 0, 0, 0) == 5, "the last belongs into the next file"
    assert slow.run(times, 0, 0, 3 * SECOND) == 5, "the file's beginning is its earliest message"
    assert Limits(1000, 100.0, 500, None).run(times, 0, 500, 0) == 1, "a file that is full from its beginning"
    assert slow.run(times[::-1], 0, 0, None) == 6, "a clock that steps back makes no file old"


def test_a_disk_that_refuses_amid_a_batch_drops_the_rest_of_it(
    new_log: NewLog, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    log = new_log(chunk_size=500, compression="none", sync_interval_s=1.0)
    log.add_topic("/a", FLOAT64)
    messages = [Kept("/a", bytes([k]) * 12, k * SECOND // 10, 0) for k in range(100)]
    put, room = disk.DurableFile._put, [20_000]

    def little(self: disk.DurableFile, data: bytes) -> None:
        room[0] -= len(data)
        if room[0] < 0:
            raise OSError(28, "No space left on device")
        put(self, data)

    monkeypatch.setattr(disk.DurableFile, "_put", little)
    log.write_batch(batch_of(messages[:50], ("/a",)))
    room[0] = 2000
    with pytest.raises(LogError, match="No space left") as told:
        log.write_batch(batch_of(messages[50:], ("/a",)))
    received, durable, dropped = log.counters["/a"]
    assert received == 100
    assert 50 <= durable < 100
    assert dropped == 100 - durable
    assert f"{dropped} messages since the last sync are lost" in str(told.value)
    assert log.write_batch(batch_of(messages[:7], ("/a",))) is False
    assert log.counters["/a"] == Counters(107, durable, dropped + 7)
    assert [message.data[0] for message in Bag(tmp_path / "log").messages()] == list(range(durable))


def test_impossible_messages_are_named_and_the_others_are_written(new_log: NewLog, tmp_path: Path) -> None:
    with new_log() as log:
        log.add_topic("/a", FLOAT64)
        messages = [Kept("/a", bytes(12), t, p) for t, p in ((5, 5), (-1, 5), (6, -7), (7, 7))]
        with pytest.raises(LogError, match="A message on /a has log time -1 ns and publish time 5 ns"):
            log.write_batch(batch_of(messages, ("/a",)))
        assert log.counters["/a"].received == 2
        with pytest.raises(LogError, match="'/b' is not declared in this log"):
            log.write_batch(batch_of(messages[:1], ("/a", "/b")))
        assert log.write_batch(batch_of([], ("/a",)))
    assert [message.log_time_ns for message in Bag(tmp_path / "log").messages()] == [5, 7]


@pytest.fixture
def recording(new_log: NewLog, tmp_path: Path) -> Recording:
    topics = {"/a": (FLOAT64, Qos()), WARNING: (DIAGNOSTIC_STATUS, Qos())}
    trigger = EventTrigger(2, after=2.0, spacing=5.0, limit=3)
    return Recording(tmp_path / "run", new_log, topics, ring_seconds=5.0, trigger=trigger, trigger_topic=WARNING)


def some(count: int, start: int) -> Batch:
    return batch_of([Kept("/a", bytes(12), start + k, 0) for k in range(count)], ("/a", WARNING))


def test_batches_are_counted_in_every_state(recording: Recording) -> None:
    recording.receive_batch(some(3, SECOND))
    recording.start()
    recording.receive_batch(some(10, 2 * SECOND))
    recording.receive_batch(some(0, 0))
    recording.pause()
    recording.receive_batch(some(4, 3 * SECOND))
    recording.resume()
    recording.receive("/a", bytes(12), 4 * SECOND, 0)
    recording.sync(4 * SECOND)
    assert recording.totals["/a"] == Counters(18, 11, 0)
    assert recording.not_recorded["/a"] == 7
    directory, count = recording.snapshot()
    recording.stop()
    assert count == 18
    assert Bag(recording.directory).topics["/a"].count == 11
    assert Bag(directory).topics["/a"].count == 18


def test_a_warning_in_a_batch_takes_a_snapshot(recording: Recording) -> None:
    status = Kept(WARNING, b"\0\1\0\0\2" + bytes(20), SECOND, 0)
    empty = Kept(WARNING, b"", SECOND, 0)
    recording.receive_batch(batch_of([empty, status], ("/a", WARNING)))
    assert recording.take_due_snapshot(2 * SECOND) is None
    path = recording.take_due_snapshot(3 * SECOND)
    assert path is not None
    assert Bag(path).topics[WARNING].count == 2


def test_what_was_lost_before_it_was_received_stands_in_the_bag_it_is_missing_from(recording: Recording) -> None:
    assert recording.note_lost({"/a": 3}, datagrams=1) == {"/a": 3}, "nothing is recorded yet"
    recording.start()
    recording.receive_batch(some(2, SECOND))
    assert recording.note_lost({"/a": 10, WARNING: 0}, datagrams=5) == {"/a": 7}
    assert recording.note_lost({"/a": 10}, datagrams=5) == {}
    assert recording.note_lost({"/a": 12}) == {"/a": 2}
    assert (recording.lost["/a"], recording.datagrams) == (12, 5)
    recording.stop()
    custom = Bag(recording.directory).custom_data
    assert custom["lost unread of /a"] == "9"
    assert custom["datagrams dropped by the system"] == "4"
    assert f"lost unread of {WARNING}" not in custom
    again = recording.start()
    recording.stop()
    assert "lost unread of /a" not in Bag(again).custom_data
