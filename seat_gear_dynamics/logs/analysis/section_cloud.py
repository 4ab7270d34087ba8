"""The recorded bifurcation diagram: section points by speed, run-up and run-down apart, a fair sample of each speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM

Array = NDArray[np.float64]

SPEED_BIN = 5 * RPM
"""rad/s of s1; points of one bin are drawn together."""


class SectionCloud:
    """Keeps up to `room` section points for each bin of |speed| and direction, each point with equal chance.

    Reservoir sampling (Vitter 1985, algorithm R) with random numbers from `seed`: the same log gives the same diagram.
    Memory grows with the speeds visited, not with time. Points of unknown direction are left out.
    """

    def __init__(self, *, room: int = 60, seed: int = 0) -> None:
        self._room = room
        self._random = np.random.Generator(np.random.PCG64(seed))
        self._kept: dict[tuple[int, int], Array] = {}
        self._seen: dict[tuple[int, int], int] = {}

    def add(self, section: Array) -> None:
        """Take rows of (time, δ, rate, speed, direction) as `Batch.section`."""
        rows = section[np.isfinite(section).all(axis=1) & (section[:, 4] != 0)]
        if not len(rows):
            return
        keys = np.column_stack([np.abs(rows[:, 3]) // SPEED_BIN, rows[:, 4]]).astype(np.int64)
        found, which = np.unique(keys, axis=0, return_inverse=True)
        for i, key in enumerate(found.tolist()):
            self._fill((key[0], key[1]), rows[which.ravel() == i])

    def points(self, direction: int) -> Array:
        """Return the points of +1 (run-up) or −1 (run-down): (|speed| in rad/s, δ/b_c, rate, s), shape (n, 4)."""
        kept = [self._kept[key][: self._seen[key]] for key in sorted(self._kept) if key[1] == direction]
        return np.concatenate(kept) if kept else np.empty((0, 4))

    @property
    def seen(self) -> int:
        """How many points have come, kept or not."""
        return sum(self._seen.values())

    def _fill(self, key: tuple[int, int], rows: Array) -> None:
        points = np.column_stack([np.abs(rows[:, 3]), rows[:, 1], rows[:, 2], rows[:, 0]])
        kept = self._kept.setdefault(key, np.empty((self._room, 4)))
        seen = self._seen.get(key, 0)
        room = max(self._room - seen, 0)
        kept[seen : seen + room][: len(points)] = points[:room]
        rest = points[room:]
        # Point number n takes the place of a kept one with chance room/n.
        numbers = np.arange(seen + room + 1, seen + room + 1 + len(rest))
        places = (self._random.random(len(rest)) * numbers).astype(np.int64)
        for place, point in zip(places.tolist(), rest, strict=True):
            if place < self._room:
                kept[place] = point
        self._seen[key] = seen + len(points)
