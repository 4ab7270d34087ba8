"""How long the drive stayed in which band of speed, and what the mesh forces were there."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.logs.analysis.batches import MESHES
from seat_gear_dynamics.logs.analysis.occupancy import holds
from seat_gear_dynamics.logs.analysis.zones import Stretch, Zones

Array = NDArray[np.float64]


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


class BandStays:
    """Sums time and forces by stretch of |speed|; windows of force count with the speed and load at their end."""

    def __init__(self, cut: Zones) -> None:
        self._zones = cut
        self._seconds, self._longest, self._visits = np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.int64)
        self._force = np.zeros((0, 2, 2))  # integrals of force and of its square
        self._extremes = np.zeros((0, 2, 2))
        self._force_seconds = np.zeros(0)
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
        """Return what each stretch saw, by load and speed; what lies outside a map comes last."""
        self._end_visit()
        known = self._zones.stretches()
        self._make_room(len(known))
        order = sorted(range(len(known)), key=lambda i: (known[i].outside, known[i].load or 0.0, known[i].low))
        return tuple(self._stay_in(i, known[i]) for i in order)

    def _where(self, speed: Array, load: Array) -> NDArray[np.int64]:
        where = self._zones.where(speed, load)
        self._make_room(int(where.max(initial=-1)) + 1)
        return where

    def _make_room(self, count: int) -> None:
        more = count - len(self._seconds)
        if more <= 0:
            return
        self._seconds, self._longest, self._visits, self._force, self._force_seconds = (
            np.concatenate([values, np.zeros((more, *values.shape[1:]), dtype=values.dtype)])
            for values in (self._seconds, self._longest, self._visits, self._force, self._force_seconds)
        )
        self._extremes = np.concatenate([self._extremes, np.tile(np.array([np.inf, -np.inf]), (more, 2, 1))])

    def _add_drive(self, drive: Array) -> None:
        where, seconds = self._where(drive[:, 1], drive[:, 2]), holds(drive[:, 0], self._before)
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
        where, seconds = self._where(known[:, 9], known[:, 10]), holds(known[:, 0], self._force_before)
        self._force_before = float(known[-1, 0])
        self._force_seconds += np.bincount(where, seconds, len(self._force_seconds))
        for mesh in range(2):
            mean, least, most, rms = known[:, 1 + 4 * mesh : 5 + 4 * mesh].T
            np.add.at(self._force[:, mesh, 0], where, mean * seconds)
            np.add.at(self._force[:, mesh, 1], where, rms**2 * seconds)
            np.minimum.at(self._extremes[:, mesh, 0], where, least)
            np.maximum.at(self._extremes[:, mesh, 1], where, most)

    def _stay_in(self, i: int, stretch: Stretch) -> BandStay:
        forces = {mesh: self._forces_in(i, m) for m, mesh in enumerate(MESHES)}
        return BandStay(
            stretch,
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
