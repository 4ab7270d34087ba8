"""Watching the room on a disk: how long it will last at the present rate, and when to stop in good time."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Literal

Room = Literal["enough", "low", "full"]
_WINDOW = 30.0  # s over which the rate is taken
_SHORTEST = 2.0  # s; a rate over less says nothing


@dataclass(frozen=True)
class Space:
    """The room on a log's disk: free bytes, and s until only the reserve is left (None while it does not shrink)."""

    room: Room
    free: int
    time_to_full: float | None

    @property
    def text(self) -> str:
        """The state in words."""
        amount = f"{self.free / 1e6:.0f} MB free"
        if self.time_to_full is None:
            return amount
        return f"{amount}, full in {self.time_to_full:.0f} s at the present rate"


class SpaceWatch:
    """Takes the free bytes of a disk now and then and judges them.

    `full` at `reserve` bytes or fewer: room that is kept for the end of the log and for the rest of the machine. `low`
    when the reserve is reached within `warn_seconds`, at the rate at which free bytes went down over the last half
    minute, whoever took them, or when less than twice the reserve is free.
    """

    def __init__(self, *, reserve: int, warn_seconds: float) -> None:
        self.reserve, self.warn_seconds = reserve, warn_seconds
        self._seen: deque[tuple[float, int]] = deque()

    def update(self, t: float, free: int) -> Space:
        """Return the judgement at time `t` (s of a steady clock) of `free` bytes."""
        if self._seen and t < self._seen[-1][0]:
            self._seen.clear()
        self._seen.append((t, free))
        while self._seen[0][0] < t - _WINDOW:
            self._seen.popleft()
        left = self._time_to_full()
        if free <= self.reserve:
            return Space("full", free, 0.0)
        if (left is not None and left <= self.warn_seconds) or free < 2 * self.reserve:
            return Space("low", free, left)
        return Space("enough", free, left)

    def _time_to_full(self) -> float | None:
        (begin, before), (end, now) = self._seen[0], self._seen[-1]
        if end - begin < _SHORTEST or before <= now:
            return None
        return max(0.0, (now - self.reserve) * (end - begin) / (before - now))
