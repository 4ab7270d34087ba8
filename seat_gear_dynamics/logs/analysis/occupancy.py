"""Where in the plane of speed and load the drive was, and for how long."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM

Array = NDArray[np.float64]

SPEED_CELL = 10 * RPM
"""Width of a cell, rad/s of s1."""
LOAD_CELL = 10.0
"""Height of a cell, N·m."""
LONGEST_HOLD = 0.5
"""s; a sample stands until the next one, but no longer than this: a gap is no time anywhere."""


def holds(time: Array, before: float | None) -> Array:
    """Return how long each interval between samples counts, s, shape (n,): that which ends at each sample.

    `time` (n,) increasing; `before` is the last sample's of the stretch before, None without one (the first counts 0).
    Intervals longer than LONGEST_HOLD count 0.
    """
    if not len(time):
        return np.empty(0)
    steps = np.diff(time, prepend=time[0] if before is None else before)
    return np.where((steps > 0) & (steps <= LONGEST_HOLD), steps, 0.0)


class Occupancy:
    """Seconds spent in cells of |speed| and load; memory grows with the cells visited, not with time."""

    def __init__(self) -> None:
        self._seconds: dict[tuple[int, int], float] = defaultdict(float)
        self._before: float | None = None
        self.total = 0.0
        """s counted."""

    def add(self, drive: Array) -> None:
        """Take rows of (time, speed, load, …) as `Batch.drive`."""
        if not len(drive):
            return
        seconds = holds(drive[:, 0], self._before)
        self._before = float(drive[-1, 0])
        cells = np.column_stack([np.abs(drive[:, 1]) // SPEED_CELL, drive[:, 2] // LOAD_CELL]).astype(np.int64)
        found, which = np.unique(cells, axis=0, return_inverse=True)
        spent = np.bincount(which.ravel(), seconds, len(found))
        for (column, row), amount in zip(found.tolist(), spent.tolist(), strict=True):
            if amount:
                self._seconds[column, row] += amount
        self.total += float(seconds.sum())

    def cells(self) -> Array:
        """Return (|speed| in rad/s, load in N·m, s) of each cell visited, its middle, shape (n, 3), sorted."""
        rows = [((c + 0.5) * SPEED_CELL, (r + 0.5) * LOAD_CELL, s) for (c, r), s in sorted(self._seconds.items())]
        return np.array(rows).reshape(-1, 3)

    def load_range(self, share: float = 0.02) -> tuple[float, float]:
        """Return the loads (N·m) below and above which the drive spent `share` of its time; NaN without any."""
        cells = self.cells()
        if not len(cells):
            return np.nan, np.nan
        order = np.argsort(cells[:, 1], kind="stable")
        passed = np.cumsum(cells[order, 2]) / cells[:, 2].sum()
        low, high = np.searchsorted(passed, (share, 1 - share))
        loads = cells[order, 1]
        return float(loads[low]), float(loads[min(high, len(loads) - 1)])
