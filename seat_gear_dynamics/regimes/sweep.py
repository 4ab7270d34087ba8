"""Bifurcation sweeps: one quantity varied, the motion at each value, up, down or each from rest."""

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes.attractors import TOLERANCE, same_motion
from seat_gear_dynamics.regimes.classification import Name, Regime
from seat_gear_dynamics.regimes.points import Answer, Motion, Point, abreast, follow, regime_of, respond
from seat_gear_dynamics.regimes.simulate import MeshForce

Array = NDArray[np.float64]
Quantity = Literal["frequency", "speed", "speed_rpm", "damping", "backlash_um", "load"]
Direction = Literal["up", "down", "both", "cold"]
Way = Literal["up", "down", "cold"]

UNITS: dict[Quantity, str] = {
    "frequency": "1",
    "speed": "rad/s",
    "speed_rpm": "r/min",
    "damping": "1",
    "backlash_um": "µm",
    "load": "N·m",
}
"""What can be swept, and the unit of its values; speeds are those of s1."""


@dataclass(frozen=True, eq=False)
class Row:
    """What the motion is at one value of a sweep."""

    value: float
    """In the sweep's unit."""
    direction: Way
    regime: Regime
    force: MeshForce | None
    """Force of P12, N; None where the motion diverged."""
    section: Array
    """Section points of P12, (periods, 2), units of b_c; (0, 2) where the motion diverged."""

    def as_dict(self) -> dict[str, Any]:
        """Return the row without its section as plain values, forces in N; None where there is none."""
        force = self.force
        return {
            "value": self.value,
            "regime": self.regime.name,
            "period": self.regime.period,
            "lyapunov": self.regime.lyapunov,
            "contact_loss": force and force.contact_loss,
            "force_min": force and force.min,
            "force_max": force and force.max,
            "force_mean": force and force.mean,
            "force_rms": force and force.rms,
            "direction": self.direction,
        }


@dataclass(frozen=True, eq=False)
class Sweep:
    """A finished sweep."""

    over: Quantity
    rows: tuple[Row, ...]
    """In the order in which they were found; up and down alternate."""

    def along(self, direction: Way) -> tuple[Row, ...]:
        """Return the rows of one direction by increasing value."""
        return tuple(sorted((row for row in self.rows if row.direction == direction), key=lambda row: row.value))

    @property
    def directions(self) -> tuple[Way, ...]:
        """The directions that the sweep has, of `up`, `down` and `cold`."""
        return tuple(way for way in get_args(Way) if any(row.direction == way for row in self.rows))

    def coexisting(self, *, tolerance: float = TOLERANCE) -> tuple[float, ...]:
        """Return the values at which up and down end on different motions; empty where the sweep is not of both.

        Sections are compared as sets within `tolerance` b_c, see `same_motion`. A value where one of them diverged and
        the other did not counts.
        """
        down = {row.value: row for row in self.along("down")}
        pairs = ((row, down[row.value]) for row in self.along("up") if row.value in down)
        return tuple(first.value for first, second in pairs if _differ(first, second, tolerance))


def _differ(first: Row, second: Row, tolerance: float) -> bool:
    if first.force is None or second.force is None:
        return first.force is not second.force
    return not same_motion(first.section, second.section, tolerance=tolerance)


def sweep(
    system: System,
    *,
    over: Quantity,
    start: float,
    stop: float,
    points: int,
    direction: Direction = "cold",
    transient: int = 600,
    periods: int = 400,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Sweep:
    """Return the bifurcation sweep of `system` over one quantity; arguments as `sweep_rows`.

    `progress` is told (rows done, rows in all).
    """
    rows = sweep_rows(
        system,
        over=over,
        start=start,
        stop=stop,
        points=points,
        direction=direction,
        transient=transient,
        periods=periods,
        workers=workers,
    )
    total, found = row_count(points, direction), []
    for row in rows:
        found.append(row)
        if progress is not None:
            progress(len(found), total)
    return Sweep(over, tuple(found))


def row_count(points: int, direction: Direction) -> int:
    """Return how many rows a sweep of `points` values gives."""
    return 2 * points if direction == "both" else points


def sweep_rows(
    system: System,
    *,
    over: Quantity,
    start: float,
    stop: float,
    points: int,
    direction: Direction = "cold",
    transient: int = 600,
    periods: int = 400,
    workers: int | None = None,
) -> Generator[Row, None, None]:
    """Yield the rows of a sweep over `points` equal steps from `start` to `stop`, both included, as they are found.

    `over` is frequency (Ω), speed (rad/s of s1), speed_rpm (r/min), damping (ξ) or backlash_um (µm) of both meshes, or
    load (T4, N·m); everything else is as `system` has it. `cold` starts each value at static deflection, as `simulate`
    does, in `workers` threads. `up` and `down` (through decreasing values) carry the state at mesh phase 0 over to the
    next value: the adiabatic sweep, in which a motion is followed until it loses its stability. `both` gives up and
    down in turn, each in a thread of its own. Closing the generator ends the sweep. Raises ValueError, at once, for
    impossible ranges and values. Limit: a state is carried by steps, so a step wider than a motion's basin leaves it;
    see `follow` for P34.
    """
    values = _values(over, start, stop, points)
    if direction not in get_args(Direction):
        raise ValueError(f"The direction is {direction!r}, expected one of {', '.join(get_args(Direction))}.")
    asked = [_point(system, over, value, transient=transient, periods=periods) for value in values]
    if direction == "cold":
        return _rows(system, "cold", values, asked, respond(system.train, asked, workers=workers))
    up = _rows(system, "up", values, asked, follow(system.train, asked))
    down = _rows(system, "down", values[::-1], asked[::-1], follow(system.train, asked[::-1]))
    return abreast({"up": [up], "down": [down], "both": [up, down]}[direction])


def _values(over: Quantity, start: float, stop: float, points: int) -> list[float]:
    if over not in UNITS:
        raise ValueError(f"Asked for a sweep over {over!r}, expected one of {', '.join(UNITS)}.")
    if not (isfinite(start) and isfinite(stop) and start < stop):
        raise ValueError(
            f"The sweep goes from {start!r} to {stop!r}, expected finite numbers, the lower first; "
            f"for decreasing values choose the direction down."
        )
    if points < 2:
        raise ValueError(f"The sweep has {points} points, expected at least 2.")
    return [float(value) for value in np.linspace(start, stop, points)]


def _point(system: System, over: Quantity, value: float, *, transient: int, periods: int) -> Point:
    at = system.operating_point
    kept = Point(1.0, at.load, transient=transient, periods=periods)
    if over in ("frequency", "speed", "speed_rpm"):
        factor = {"speed": 1.0, "speed_rpm": RPM}
        return replace(kept, frequency=system.train.frequency(value * factor[over]) if over in factor else value)
    running = replace(kept, frequency=at.frequency)
    if over == "load":
        return replace(running, load=value)
    if over == "damping":
        return replace(running, damping_ratio=value)
    return replace(running, backlash=value * 1e-6)


def _rows(
    system: System, way: Way, values: Iterable[float], asked: Iterable[Point], answers: Iterable[Answer]
) -> Generator[Row, None, None]:
    unit = system.coefficients.force_unit
    for value, point, found in zip(values, asked, answers, strict=True):
        regime = regime_of(found)
        if isinstance(found, Motion):
            static = system.train.static_forces(point.load)[0]
            yield Row(value, way, regime, MeshForce.from_window(found.forces[0], unit, static), found.section)
        else:
            yield Row(value, way, regime, None, np.empty((0, 2)))


def intervals(found: Sweep, regime: Name, *, direction: Way | None = None) -> tuple[tuple[float, float], ...]:
    """Return the ranges of values (lowest, highest) over which the motion is of `regime`, in the sweep's unit.

    Of one `direction`, or of any that the sweep has. A range goes from the first to the last value found so; its ends
    are uncertain by one step of the sweep outwards, and a single value gives a range of no width.
    """
    rows = found.rows if direction is None else found.along(direction)
    holds: dict[float, bool] = {}
    for row in rows:
        holds[row.value] = holds.get(row.value, False) or row.regime.name == regime
    ranges: list[tuple[float, float]] = []
    before = False
    for value, held in sorted(holds.items()):
        if held:
            ranges = [*ranges[:-1], (ranges[-1][0], value)] if before else [*ranges, (value, value)]
        before = held
    return tuple(ranges)
