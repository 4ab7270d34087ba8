"""The ring of the last seconds, and when a snapshot of it is due by itself."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

_OVERHEAD = 300  # bytes that a kept message costs beside its data


class Kept(NamedTuple):
    """A message in the ring: absolute topic, CDR bytes, log and publish time, ns."""

    topic: str
    data: bytes
    log_ns: int
    publish_ns: int


class Ring:
    """Keeps the messages of the last `seconds` of log time in at most `max_bytes`, and the last of each latched topic.

    A message leaves when its log time is farther than `seconds` from the newest one's, in either direction: a clock
    that steps back empties the ring rather than letting it grow until the clock has caught up.
    """

    def __init__(self, seconds: float, max_bytes: int) -> None:
        self._span_ns = int(seconds * 1e9)
        self._max_bytes = max_bytes
        self._kept: deque[Kept] = deque()
        self._bytes = 0
        self._latched: dict[str, Kept | None] = {}

    def __len__(self) -> int:
        return len(self._kept)

    def latch(self, topic: str) -> None:
        """Keep the last message of `topic` however old: a late subscriber would be sent it too."""
        self._latched.setdefault(topic, None)

    def add(self, topic: str, data: bytes, log_ns: int, publish_ns: int) -> None:
        """Take a message and let go what is too old or too much."""
        self._kept.append(Kept(topic, data, log_ns, publish_ns))
        self._bytes += len(data) + _OVERHEAD
        while abs(log_ns - self._kept[0].log_ns) > self._span_ns or self._bytes > self._max_bytes:
            gone = self._kept.popleft()
            self._bytes -= len(gone.data) + _OVERHEAD
            if gone.topic in self._latched:
                self._latched[gone.topic] = gone
            if not self._kept:
                break

    def messages(self) -> list[Kept]:
        """Return latched messages older than the ring, at the log time of its first one, and then the ring."""
        if not self._kept:
            return []
        begin, present = self._kept[0].log_ns, {kept.topic for kept in self._kept}
        older = [kept for topic, kept in self._latched.items() if kept is not None and topic not in present]
        return [*(kept._replace(log_ns=begin) for kept in older), *self._kept]


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
