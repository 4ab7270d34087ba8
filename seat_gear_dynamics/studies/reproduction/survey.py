"""Looking at many operating points: the regime at each, and what share of them is of a kind."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Window
from seat_gear_dynamics.regimes import Regime, classify
from seat_gear_dynamics.regimes.points import Motion, Point, respond

Array = NDArray[np.float64]
TRANSIENT, PERIODS = 1000, 800
"""Mesh periods run in and judged: soft torsional supports let some motions settle over many hundred periods."""

Progress = Callable[[int, int], None]
"""Called with (points done, points in all)."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What was seen at one operating point."""

    point: Point
    regime: Regime | None
    """None where the solution diverged."""
    section: Array
    """(periods, 2): δ/b_c and its rate; empty where the solution diverged."""
    force: Window | None
    """Of P12, dimensionless; None where the solution diverged."""

    @property
    def chaotic(self) -> bool:
        """Whether the motion is chaotic."""
        return self.regime is not None and self.regime.name == "chaotic"

    @property
    def calm(self) -> bool:
        """Whether the motion is periodic or quasi-periodic: known not to be chaotic."""
        return self.regime is not None and self.regime.name in ("periodic", "quasi-periodic")

    @property
    def period(self) -> int | None:
        """The period in mesh periods, None where the motion is not periodic."""
        return None if self.regime is None else self.regime.period

    @property
    def name(self) -> str:
        """The motion in a word or two."""
        if self.regime is None:
            return "diverged"
        return f"period-{self.regime.period}" if self.regime.period is not None else self.regime.name


def standard_point(frequency: float, load: float, **options: float) -> Point:
    """Return a point to be looked at for as long as every verdict is; `options` are damping_ratio and backlash (m)."""
    return Point(frequency, load, transient=TRANSIENT, periods=PERIODS, **options)  # type: ignore[arg-type]


def survey(train: GearTrain, points: Sequence[Point], progress: Progress | None = None) -> list[Seen]:
    """Return what each of `points` shows, in their order."""
    seen: list[Seen] = []
    for point, motion in zip(points, respond(train, points), strict=True):
        if isinstance(motion, Motion):
            regime = classify(motion.section, motion.growth, motion.interval)
            seen.append(Seen(point, regime, motion.section, motion.forces[0]))
        else:
            seen.append(Seen(point, None, np.empty((0, 2)), None))
        if progress is not None:
            progress(len(seen), len(points))
    return seen


def share(seen: Sequence[Seen], holds: Callable[[Seen], bool]) -> float:
    """Return the share of `seen` for which `holds` is true; NaN for none."""
    return sum(map(holds, seen)) / len(seen) if seen else float("nan")


def between(seen: Sequence[Seen], low: float, high: float) -> list[Seen]:
    """Return those with a frequency from `low` to `high`, both included to 1e-9."""
    return [s for s in seen if low - 1e-9 <= s.point.frequency <= high + 1e-9]


def windows(values: Sequence[float], marks: Sequence[bool]) -> list[tuple[float, float]]:
    """Return the stretches of successive `values` that are marked, as (first, last)."""
    found: list[tuple[float, float]] = []
    running = False
    for value, mark in zip(values, marks, strict=True):
        if mark and running:
            found[-1] = (found[-1][0], value)
        elif mark:
            found.append((value, value))
        running = mark
    return found


def spell(stretches: Sequence[tuple[float, float]], digits: int = 2) -> str:
    """Return stretches in words, as in `1.52-1.97, 2.00`; `nowhere` for none."""
    parts = [f"{low:.{digits}f}" if low == high else f"{low:.{digits}f}-{high:.{digits}f}" for low, high in stretches]
    return ", ".join(parts) or "nowhere"
