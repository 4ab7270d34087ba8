"""What a bifurcation sweep goes through: its grid of values, the point at each, and how far it has come."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes.points import Point

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


@dataclass(frozen=True)
class Plan:
    """What a sweep goes through, and how long it looks at each value.

    Raises ValueError, a sentence, for impossible ranges.
    """

    over: Quantity
    """frequency (Ω), speed (rad/s of s1), speed_rpm (r/min), damping (ξ) or backlash_um (µm) of both meshes, or load
    (T4, N·m)."""
    start: float
    """Lowest value."""
    stop: float
    """Highest value."""
    points: int
    """Values in equal steps, both ends included."""
    direction: Direction = "cold"
    """`cold` starts each value at static deflection, as `simulate` does. `up` and `down` (through decreasing values)
    carry the state at mesh phase 0 over to the next value: the adiabatic sweep, in which a motion is followed until it
    loses its stability. `both` gives up and down in turn."""
    transient: int = 600
    """Mesh periods run in at each value."""
    periods: int = 400
    """Mesh periods sampled at each value."""

    def __post_init__(self) -> None:
        if self.over not in UNITS:
            raise ValueError(f"Asked for a sweep over {self.over!r}, expected one of {', '.join(UNITS)}.")
        if not (isfinite(self.start) and isfinite(self.stop) and self.start < self.stop):
            raise ValueError(
                f"The sweep goes from {self.start!r} to {self.stop!r}, expected finite numbers, the lower first; "
                f"for decreasing values choose the direction down."
            )
        if self.points < 2:
            raise ValueError(f"The sweep has {self.points} points, expected at least 2.")
        if self.direction not in get_args(Direction):
            raise ValueError(f"The direction is {self.direction!r}, expected one of {', '.join(get_args(Direction))}.")

    @property
    def ways(self) -> tuple[Way, ...]:
        """The directions that take turns, of `up`, `down` and `cold`."""
        return ("up", "down") if self.direction == "both" else (self.direction,)

    @property
    def rows(self) -> int:
        """How many rows the sweep gives."""
        return len(self.ways) * self.points

    def values(self, way: Way, numbers: range) -> list[float]:
        """Return the values that the sweep meets as its `numbers`-th on `way`, counted from 0.

        They are those of `numpy.linspace` to the last bit, but a block of them takes no more memory than the block.
        """
        down = way == "down"
        places = range(self.points - numbers.stop, self.points - numbers.start) if down else numbers
        step = (self.stop - self.start) / (self.points - 1)
        grid: list[float] = (np.arange(places.start, places.stop) * step + self.start).tolist()
        if places.stop == self.points:
            grid[-1] = float(self.stop)
        return grid[::-1] if down else grid

    def point(self, system: System, value: float) -> Point:
        """Return the point of `system` at a value of the sweep; raises ValueError for an impossible one."""
        at = system.operating_point
        kept = Point(1.0, at.load, transient=self.transient, periods=self.periods)
        if self.over in ("frequency", "speed", "speed_rpm"):
            factor = {"speed": 1.0, "speed_rpm": RPM}
            known = self.over in factor
            return replace(kept, frequency=system.train.frequency(value * factor[self.over]) if known else value)
        running = replace(kept, frequency=at.frequency)
        if self.over == "load":
            return replace(running, load=value)
        if self.over == "damping":
            return replace(running, damping_ratio=value)
        return replace(running, backlash=value * 1e-6)

    def check(self, system: System) -> None:
        """Raise ValueError where a value of the sweep is none that `system` can be run at."""
        # A point is impossible at the ends or at standstill, which is on the grid at the value nearest to it.
        nearest = round(-self.start / (self.stop - self.start) * (self.points - 1))
        between = [n for n in (nearest - 1, nearest, nearest + 1) if 0 <= n < self.points]
        for number in (0, *between, self.points - 1):
            self.point(system, self.values("up", range(number, number + 1))[0])


@dataclass(frozen=True, eq=False)
class Begun:
    """How far a sweep has come: what `sweep_each` needs to go on with the row after the last."""

    rows: int = 0
    """Rows found, of all directions together."""
    states: Mapping[Way, Sequence[float] | Array | None] = field(default_factory=dict)
    """`state` of the last row of each direction; not needed in a cold sweep."""
