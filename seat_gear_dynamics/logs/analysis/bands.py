"""How long the drive stayed in which band of speed, and what the mesh forces were there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.logs.analysis.batches import MESHES
from seat_gear_dynamics.logs.analysis.occupancy import holds

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stretch:
    """A range of |speed|: a forbidden band, or what lies between two."""

    low: float
    """rad/s of s1"""
    high: float
    """rad/s of s1; infinity for what lies above the last band."""
    forbidden: bool


@dataclass(frozen=True)
class MeshForces:
    """Statistics of one mesh force over the time spent in a stretch, N; NaN without any."""

    mean: float
    min: float
    max: float
    rms: float


@dataclass(frozen=True)
class BandStay:
    """What happened in one stretch of speeds."""

    stretch: Stretch
    seconds: float
    visits: int
    """How often the drive came into it."""
    longest: float
    """The longest visit, s."""
    force_seconds: float
    """Time over which forces are known, s."""
    forces: dict[str, MeshForces]


def stretches(bands: Sequence[ForbiddenBand]) -> tuple[Stretch, ...]:
    """Return all speeds from 0 up cut into forbidden bands and what lies between, in order.

    Bands, at whatever load they hold, must not overlap.
    """
    ordered = sorted(bands, key=lambda band: band.low)
    edges = [0.0, *(edge for band in ordered for edge in (band.low, band.high)), np.inf]
    cuts = [Stretch(low, high, bool(i % 2)) for i, (low, high) in enumerate(pairwise(edges))]
    return tuple(cut for cut in cuts if cut.high > cut.low)


class BandStays:
    """Sums time and forces by stretch of |speed|; windows of force count with the speed at their end."""

    def __init__(self, bands: Sequence[ForbiddenBand]) -> None:
        self.stretches = stretches(bands)
        n = len(self.stretches)
        self._lows = np.array([stretch.low for stretch in self.stretches])
        self._seconds, self._longest, self._visits = np.zeros(n), np.zeros(n), np.zeros(n, dtype=np.int64)
        self._force = np.zeros((n, 2, 2))  # integrals of force and of its square
        self._extremes = np.tile(np.array([np.inf, -np.inf]), (n, 2, 1))
        self._force_seconds = np.zeros(n)
        self._place, self._stay = -1, 0.0
        self._before: float | None = None
        self._force_before: float | None = None

    def add(self, drive: Array, force: Array) -> None:
        """Take rows as `Batch.drive` and `Batch.force`."""
        if len(drive):
            self._add_drive(drive)
        if len(force):
            self._add_force(force)

    def found(self) -> tuple[BandStay, ...]:
        """Return what each stretch saw, by speed."""
        self._end_visit()
        return tuple(self._stay_in(i) for i in range(len(self.stretches)))

    def _where(self, speed: Array) -> NDArray[np.int64]:
        return np.searchsorted(self._lows, np.abs(speed), side="right") - 1

    def _add_drive(self, drive: Array) -> None:
        where, seconds = self._where(drive[:, 1]), holds(drive[:, 0], self._before)
        self._before = float(drive[-1, 0])
        self._seconds += np.bincount(where, seconds, len(self._seconds))
        starts = np.flatnonzero(np.diff(where, prepend=self._place))
        for first, after in pairwise([0, *starts[starts > 0].tolist(), len(where)]):
            if where[first] != self._place:
                self._end_visit()
                self._place = int(where[first])
                self._visits[self._place] += 1
            self._stay += float(seconds[first:after].sum())

    def _end_visit(self) -> None:
        if self._place >= 0:
            self._longest[self._place] = max(self._longest[self._place], self._stay)
        self._stay = 0.0

    def _add_force(self, force: Array) -> None:
        known = force[np.isfinite(force).all(axis=1)]
        if not len(known):
            return
        where, seconds = self._where(known[:, 9]), holds(known[:, 0], self._force_before)
        self._force_before = float(known[-1, 0])
        self._force_seconds += np.bincount(where, seconds, len(self._force_seconds))
        for mesh in range(2):
            mean, least, most, rms = known[:, 1 + 4 * mesh : 5 + 4 * mesh].T
            np.add.at(self._force[:, mesh, 0], where, mean * seconds)
            np.add.at(self._force[:, mesh, 1], where, rms**2 * seconds)
            np.minimum.at(self._extremes[:, mesh, 0], where, least)
            np.maximum.at(self._extremes[:, mesh, 1], where, most)

    def _stay_in(self, i: int) -> BandStay:
        forces = {mesh: self._forces_in(i, m) for m, mesh in enumerate(MESHES)}
        return BandStay(
            self.stretches[i],
            float(self._seconds[i]),
            int(self._visits[i]),
            float(self._longest[i]),
            float(self._force_seconds[i]),
            forces,
        )

    def _forces_in(self, i: int, mesh: int) -> MeshForces:
        seconds = self._force_seconds[i]
        if not seconds:
            return MeshForces(np.nan, np.nan, np.nan, np.nan)
        mean, square = self._force[i, mesh] / seconds
        least, most = self._extremes[i, mesh]
        return MeshForces(float(mean), float(least), float(most), float(np.sqrt(square)))
