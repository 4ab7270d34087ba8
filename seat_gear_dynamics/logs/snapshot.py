"""The ring of the last seconds, and when a snapshot of it is due by itself."""

from __future__ import annotations

from collections import deque

import numpy as np

from seat_gear_dynamics.logs.batch import Batch, Kept

_OVERHEAD = 300  # bytes that a kept message costs beside its data
_SHARE = 40  # the same in a batch: five numbers


class Ring:
    """Keeps the messages of the last `seconds` of log time in at most `max_bytes`, and the last of each latched topic.

    A message leaves when its log time is farther than `seconds` from the newest one's, in either direction: a clock
    that steps back empties the ring rather than letting it grow until the clock has caught up.
    """

    def __init__(self, seconds: float, max_bytes: int) -> None:
        self._span_ns = int(seconds * 1e9)
        self._max_bytes = max_bytes
        self._kept: deque[Kept | Batch] = deque()
        self._bytes = self._count = 0
        self._oldest = self._highest = 0  # log time of the first; none in the ring is later
        self._latched: dict[str, Kept | None] = {}

    def __len__(self) -> int:
        return self._count

    def latch(self, topic: str) -> None:
        """Keep the last message of `topic` however old: a late subscriber would be sent it too."""
        self._latched.setdefault(topic, None)

    def add(self, topic: str, data: bytes, log_ns: int, publish_ns: int) -> None:
        """Take a message and let go what is too old or too much."""
        self._append(Kept(topic, data, log_ns, publish_ns), log_ns)
        self._count += 1
        self._bytes += len(data) + _OVERHEAD
        self._trim(log_ns)

    def add_batch(self, batch: Batch) -> None:
        """Take messages, at least one, and let go what is too old or too much."""
        first_ns, last_ns = int(batch.log_ns[0]), int(batch.log_ns[-1])
        if (self._kept and self._highest - first_ns > self._span_ns) or np.any(np.diff(batch.log_ns) < 0):
            # A step back lets go what the last message alone would not show.
            for kept in batch:
                self.add(*kept)
            self._highest = max((_latest(part) for part in self._kept), default=0)
            return
        self._append(batch, first_ns)
        self._highest = max(self._highest, last_ns)
        self._count += len(batch)
        self._bytes += _weight(batch)
        self._trim(last_ns)

    def _append(self, part: Kept | Batch, first_ns: int) -> None:
        if not self._kept:
            self._oldest = first_ns
        if first_ns > self._highest:
            self._highest = first_ns
        self._kept.append(part)

    def _trim(self, newest_ns: int) -> None:
        while self._kept and (self._bytes > self._max_bytes or abs(newest_ns - self._oldest) > self._span_ns):
            first = self._kept[0]
            if isinstance(first, Batch):
                self._trim_batch(first, newest_ns)
            else:
                self._kept.popleft()
                self._count -= 1
                self._bytes -= len(first.data) + _OVERHEAD
                self._last_of(first)
            if self._kept:
                self._oldest = _earliest(self._kept[0])

    def _trim_batch(self, first: Batch, newest_ns: int) -> None:
        """Let go the beginning of the oldest batch, or all of it."""
        leaving = self._leaving(first, newest_ns)
        gone, rest = first.part(slice(0, leaving)), first.part(slice(leaving, None))
        self._count -= leaving
        self._bytes -= _weight(gone)
        for kept in gone.of(frozenset(self._latched)):
            self._last_of(kept)
        if len(rest):
            self._kept[0] = rest
        else:
            self._kept.popleft()

    def _leaving(self, batch: Batch, newest_ns: int) -> int:
        """Return how many of a batch's first messages are too old or too much."""
        fresh = np.abs(batch.log_ns - newest_ns) <= self._span_ns
        old = int(np.argmax(fresh)) if fresh.any() else len(batch)
        excess = self._bytes - self._max_bytes
        surplus = int(np.searchsorted(np.cumsum(batch.size + _SHARE), excess)) + 1 if excess > 0 else 0
        return min(max(old, surplus), len(batch))

    def _last_of(self, kept: Kept) -> None:
        if kept.topic in self._latched:
            self._latched[kept.topic] = kept

    def parts(self) -> list[Kept | Batch]:
        """Return latched messages older than the ring, at the log time of its first one, and then the ring.

        What came in batches is given so.
        """
        if not self._kept:
            return []
        begin = _earliest(self._kept[0])
        present = {n for part in self._kept for n in (part.counts() if isinstance(part, Batch) else (part.topic,))}
        older = [kept for topic, kept in self._latched.items() if kept is not None and topic not in present]
        return [*(kept._replace(log_ns=begin) for kept in older), *self._kept]

    def messages(self) -> list[Kept]:
        """Return the same one by one."""
        return [kept for part in self.parts() for kept in (part if isinstance(part, Batch) else (part,))]


def _earliest(part: Kept | Batch) -> int:
    return int(part.log_ns[0]) if isinstance(part, Batch) else part.log_ns


def _latest(part: Kept | Batch) -> int:
    return int(part.log_ns.max()) if isinstance(part, Batch) else part.log_ns


def _weight(batch: Batch) -> int:
    return int(batch.size.sum()) + _SHARE * len(batch)


class EventTrigger:
    """Finds where a graded level begins to be serious, and when the snapshot of that moment is due.

    The snapshot is due `after` s later, so that it shows the event and not only what led to it. While one waits, and
    for `spacing` s after it, a further beginning starts none; after `limit` of them none does. Times are ns of any
    clock that is passed in each time; one that steps back brings a waiting snapshot forward.
    """

    def __init__(self, threshold: int, *, ceiling: int = 2, after: float, spacing: float, limit: int) -> None:
        self._levels = range(threshold, ceiling + 1)
        self._after_ns, self._spacing_ns = int(after * 1e9), int(spacing * 1e9)
        self._left = limit
        self._serious = False
        self._begun: int | None = None
        self._taken: int | None = None

    def update(self, level: int, now_ns: int) -> bool:
        """Take a level; return whether an event begins with it, for which `due` will become true."""
        before, self._serious = self._serious, level in self._levels
        if before or not self._serious or self._begun is not None or self._left == 0:
            return False
        if self._taken is not None and abs(now_ns - self._taken) < self._spacing_ns:
            return False
        self._begun = now_ns
        self._left -= 1
        return True

    @property
    def waiting(self) -> bool:
        """Whether an event has begun whose snapshot has not been taken."""
        return self._begun is not None

    def due(self, now_ns: int) -> bool:
        """Return whether the snapshot of an event is due now."""
        return self._begun is not None and abs(now_ns - self._begun) >= self._after_ns

    def taken(self, now_ns: int) -> None:
        """Note that the event's snapshot has been taken, or tried."""
        self._begun, self._taken = None, now_ns
