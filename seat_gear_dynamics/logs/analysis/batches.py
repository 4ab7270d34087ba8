"""A log as a stream of batches of arrays: a few seconds of drive, forces, section and warnings at a time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MESHES = ("s1_s2", "s3_s4")
STATISTICS = ("mean", "min", "max", "rms")
FORCE_NAMES = tuple(f"{mesh}/{statistic}" for mesh in MESHES for statistic in STATISTICS)
"""Columns 1 to 8 of `Batch.force`."""
DRIVE_COLUMNS = ("time", "speed", "load", "direction")
STATE_COLUMNS = ("time", *(f"{mesh}/{what}" for mesh in MESHES for what in ("deflection", "rate", "force")))
FORCE_COLUMNS = ("time", *FORCE_NAMES, "speed", "load")
SECTION_COLUMNS = ("time", "deflection", "rate", "speed", "direction")


class Warned(NamedTuple):
    """A warning as published: s since the log's start, level, text, the regime it states."""

    time: float
    level: int
    text: str
    regime: str


def empty(columns: tuple[str, ...]) -> Array:
    """Return no rows of `columns`."""
    return np.empty((0, len(columns)))


@dataclass(eq=False)
class Batch:
    """A stretch of a log; times in s since its start, rows in order of time, SI units."""

    drive: Array = field(default_factory=lambda: empty(DRIVE_COLUMNS))
    """(n, 4): time, speed (rad/s, signed), load (N·m), direction (+1 run-up, −1 run-down, 0 not known yet)."""
    force: Array = field(default_factory=lambda: empty(FORCE_COLUMNS))
    """(n, 11): time, mean, min, max and rms of both mesh forces (N), and speed and load there."""
    state: Array = field(default_factory=lambda: empty(STATE_COLUMNS))
    """(n, 7): time, δ (m), dδ/dt (m/s) and force (N) of both meshes."""
    section: Array = field(default_factory=lambda: empty(SECTION_COLUMNS))
    """(n, 5): time, δ/b_c and dimensionless rate of s1_s2 at mesh phase 0, and speed and direction there."""
    warnings: list[Warned] = field(default_factory=list)
    restarts: list[tuple[float, str]] = field(default_factory=list)
    """Where the model was restarted and why; known only where its outputs are estimated here."""


class Direction:
    """Tells run-up from run-down: the sign of the last change of |speed| by more than `threshold` (rad/s).

    A dwell belongs to the direction from which it was reached, as in a sweep that carries the state over.
    """

    def __init__(self, threshold: float) -> None:
        self._threshold = threshold
        self._extreme: float | None = None
        self._direction = 0.0

    def follow(self, speed: Array) -> Array:
        """Return the direction at each of `speed` (n,), rad/s, which goes on where the last call ended."""
        found = np.empty(len(speed))
        for i, magnitude in enumerate(np.abs(speed).tolist()):
            found[i] = self._step(magnitude)
        return found

    def _step(self, magnitude: float) -> float:
        if self._extreme is None or not np.isfinite(self._extreme):
            self._extreme = magnitude
        change = magnitude - self._extreme
        if change * self._direction > 0:
            self._extreme = magnitude
        elif abs(change) > self._threshold:
            self._direction, self._extreme = float(np.sign(change)), magnitude
        return self._direction


class Recent:
    """The drive of the last seconds, to look up what speed and load were when something else was measured."""

    def __init__(self, seconds: float = 10.0) -> None:
        self._seconds = seconds
        self._drive = empty(DRIVE_COLUMNS)

    def extend(self, drive: Array) -> None:
        """Take the next rows and forget those that are too old."""
        kept = np.concatenate([self._drive, drive])
        self._drive = kept[kept[:, 0] >= kept[-1, 0] - self._seconds] if len(kept) else kept

    def at(self, time: Array, column: str) -> Array:
        """Return a column of the drive at `time` (n,): direction as it stood, others linear; NaN without a drive."""
        if not len(self._drive):
            return np.full(len(time), np.nan)
        values = self._drive[:, DRIVE_COLUMNS.index(column)]
        if column == "direction":
            before = np.searchsorted(self._drive[:, 0], time, side="right") - 1
            return np.asarray(values[np.clip(before, 0, len(values) - 1)])
        return np.asarray(np.interp(time, self._drive[:, 0], values))

    def placed(self, points: Array) -> Array:
        """Return section points (n, 3) of time, δ/b_c and rate, with speed and direction at their time."""
        if not len(points):
            return empty(SECTION_COLUMNS)
        time = points[:, 0]
        return np.column_stack([points, self.at(time, "speed"), self.at(time, "direction")])
