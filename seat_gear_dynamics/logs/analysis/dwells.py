"""Dwells: stretches in which speed and load stand, with the motion's section and phase portrait in each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis.batches import Batch, Warned

Array = NDArray[np.float64]

SPEED_TOLERANCE = 0.01
"""Share of the mean by which a sample may differ; 8 r/min at least, for Hall steps and noise."""
LOAD_TOLERANCE = 0.08
"""Likewise; 30 N·m at least."""
SHORTEST = 0.8
"""s; shorter stretches are no dwell."""
SETTLING = 0.3
"""s at the beginning of a dwell whose section and portrait are left to the transient."""
ROOM = 1000
"""Section points, states and samples kept of a dwell: the first after settling."""
MOST_ROWS = 5000
"""Dwells listed; later ones are counted alone."""
_LEAST_SPEED = 8 * RPM
_LEAST_LOAD = 30.0
_TRUSTED = 20  # samples after which the mean of a candidate is used instead of its first sample


@dataclass(frozen=True, eq=False)
class Dwell:
    """A stretch of steady speed and load."""

    begin: float
    """s since the log's start"""
    end: float
    speed: float
    """Mean, rad/s of s1, signed."""
    load: float
    """Mean, N·m."""
    direction: int
    """+1 where reached from below, −1 from above, 0 unknown."""
    regimes: dict[str, float]
    """Share of the warnings in it that stated each regime."""
    force: Array
    """Of both meshes: mean, smallest, largest, rms, N, shape (2, 4); NaN without forces."""
    drive: Array
    """Its first samples: time (s), speed (rad/s), load (N·m), shape (n, 3), n ≤ ROOM."""
    section: Array
    """δ/b_c and rate of s1_s2 at mesh phase 0, (n, 2), after settling, n ≤ ROOM, in order."""
    state: Array
    """δ (m) and dδ/dt (m/s) of s1_s2 as published, (n, 2), after settling, n ≤ ROOM."""

    @property
    def seconds(self) -> float:
        """Its length, s."""
        return self.end - self.begin


class Dwells:
    """Finds dwells in a drive and keeps the motion of the `keep` longest; the others keep their row alone."""

    def __init__(self, *, keep: int = 12) -> None:
        self._keep = keep
        self._open: _Candidate | None = None
        self.rows: list[Dwell] = []
        """All dwells in order of time, without motion but for the longest."""
        self.count = 0
        """How many there were, listed or not."""

    def add(self, batch: Batch) -> None:
        """Take the next batch."""
        closed: list[_Candidate] = []
        for t, speed, load, direction in batch.drive.tolist():
            if self._open is not None and self._open.takes(t, speed, load):
                continue
            if self._open is not None:
                closed.append(self._open)
            self._open = _Candidate(t, speed, load, int(direction))
        for candidate in [c for c in closed if c.lasts()] + ([self._open] if self._open else []):
            candidate.gather(batch)
        for candidate in closed:
            self._close(candidate)

    def finish(self) -> None:
        """End the dwell under way."""
        if self._open is not None:
            self._close(self._open)
            self._open = None

    def longest(self, count: int) -> list[Dwell]:
        """Return the longest dwells, at most `count`, in order of time."""
        chosen = sorted(self.rows, key=lambda dwell: -dwell.seconds)[:count]
        return sorted(chosen, key=lambda dwell: dwell.begin)

    def _close(self, candidate: _Candidate) -> None:
        if not candidate.lasts():
            return
        self.count += 1
        if len(self.rows) < MOST_ROWS:
            self.rows.append(candidate.dwell())
        kept = sorted((d for d in self.rows if len(d.drive)), key=lambda dwell: -dwell.seconds)
        for dwell in kept[self._keep :]:
            self.rows[self.rows.index(dwell)] = _bare(dwell)


class _Candidate:
    """A stretch that may become a dwell."""

    def __init__(self, t: float, speed: float, load: float, direction: int) -> None:
        self._begin = self._end = t
        self._sums = [speed, load]
        self._anchor = (speed, load)
        self._count = 1
        self._direction = direction
        self._drive: list[tuple[float, float, float]] = [(t, speed, load)]
        self._section: list[Array] = []
        self._state: list[Array] = []
        self._regimes: Counter[str] = Counter()
        self._force = np.zeros((2, 2))
        self._extremes = np.array([[np.inf, -np.inf]] * 2)
        self._windows = 0

    def takes(self, t: float, speed: float, load: float) -> bool:
        """Take a sample if it still belongs to the stretch; return whether it does."""
        mean_speed, mean_load = self._means() if self._count >= _TRUSTED else self._anchor
        if t - self._end > 0.5 or abs(speed - mean_speed) > max(SPEED_TOLERANCE * abs(mean_speed), _LEAST_SPEED):
            return False
        if abs(load - mean_load) > max(LOAD_TOLERANCE * abs(mean_load), _LEAST_LOAD):
            return False
        self._end = t
        self._sums[0] += speed
        self._sums[1] += load
        self._count += 1
        if len(self._drive) < ROOM:
            self._drive.append((t, speed, load))
        return True

    def lasts(self) -> bool:
        """Return whether the stretch is a dwell: long enough, and not at rest."""
        return self._end - self._begin >= SHORTEST and abs(self._means()[0]) > _LEAST_SPEED

    def gather(self, batch: Batch) -> None:
        """Take what belongs to the stretch out of a batch."""
        begin = self._begin + SETTLING
        self._section.append(_within(batch.section, begin, self._end, sum(map(len, self._section)))[:, 1:3])
        self._state.append(_within(batch.state, begin, self._end, sum(map(len, self._state)))[:, 1:3])
        self._regimes.update(w.regime for w in _inside(batch.warnings, begin, self._end))
        rows = batch.force[(batch.force[:, 0] >= begin) & (batch.force[:, 0] <= self._end)]
        rows = rows[np.isfinite(rows[:, 1:9]).all(axis=1)]
        if len(rows):
            mean, least, most, rms = rows[:, 1:9].reshape(-1, 2, 4).transpose(2, 0, 1)
            self._force += np.column_stack([mean.sum(axis=0), (rms**2).sum(axis=0)])
            self._extremes[:, 0] = np.minimum(self._extremes[:, 0], least.min(axis=0))
            self._extremes[:, 1] = np.maximum(self._extremes[:, 1], most.max(axis=0))
            self._windows += len(rows)

    def dwell(self) -> Dwell:
        """Return the stretch as a dwell."""
        speed, load = self._means()
        stated = sum(self._regimes.values())
        force = np.full((2, 4), np.nan)
        if self._windows:
            mean, square = (self._force / self._windows).T
            force = np.column_stack([mean, self._extremes, np.sqrt(square)])
        nothing = np.empty((0, 2))
        return Dwell(
            self._begin,
            self._end,
            speed,
            load,
            self._direction,
            {name: count / stated for name, count in self._regimes.most_common()},
            force,
            np.array(self._drive),
            np.concatenate([nothing, *self._section]),
            np.concatenate([nothing, *self._state]),
        )

    def _means(self) -> tuple[float, float]:
        return self._sums[0] / self._count, self._sums[1] / self._count


def _within(rows: Array, begin: float, end: float, present: int) -> Array:
    """Return the rows from `begin` to `end`, as many as there is room for beside those present."""
    return rows[(rows[:, 0] >= begin) & (rows[:, 0] <= end)][: max(ROOM - present, 0)]


def _inside(warnings: Sequence[Warned], begin: float, end: float) -> list[Warned]:
    return [warned for warned in warnings if begin <= warned.time <= end]


def _bare(dwell: Dwell) -> Dwell:
    none = np.empty((0, 2))
    values = (dwell.begin, dwell.end, dwell.speed, dwell.load, dwell.direction, dwell.regimes, dwell.force)
    return Dwell(*values, np.empty((0, 3)), none, none)
