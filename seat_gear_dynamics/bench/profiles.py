"""What the bench is told to do: speed of s1 and load on s4 as piecewise linear functions of time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from seat_gear_dynamics.bench.errors import BenchError

RPM = 2.0 * math.pi / 60.0  # rad/s per r/min
Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Profile:
    """A run of the bench: commanded speed of s1 and load torque T4 over time.

    `speed_points` are (s, r/min) and `load_points` (s, N·m); each list begins at 0 s, its times increase, and
    between its points the value is interpolated linearly. The longer list sets `duration`; the shorter one
    holds its last value. A profile that `repeats` must end where it began, so that it is continuous for ever;
    another holds its last values.
    """

    name: str
    description: str
    speed_points: Points
    load_points: Points
    repeats: bool = False

    def __post_init__(self) -> None:
        for what, points in (("speed", self.speed_points), ("load", self.load_points)):
            self._check(what, points)

    @property
    def duration(self) -> float:
        """Length of the run, or of one round of a repeating one, in s."""
        return max(self.speed_points[-1][0], self.load_points[-1][0])

    def speed(self, t: float) -> float:
        """Return the commanded speed of s1 at time `t` (s), in rad/s, signed.

        Before 0 s it is the first value. Raises `BenchError` for a time that is not finite.
        """
        return _interpolate(self.speed_points, self._within(t)) * RPM

    def load(self, t: float) -> float:
        """Return the load torque T4 on s4 at time `t` (s), in N·m; times as for `speed`."""
        return _interpolate(self.load_points, self._within(t))

    def _within(self, t: float) -> float:
        if not math.isfinite(t):
            raise BenchError(f"The profile {self.name!r} was asked for time {t}; expected a finite number of s.")
        return t % self.duration if self.repeats and t > 0.0 < self.duration else t

    def _check(self, what: str, points: Points) -> None:
        times = [t for t, _ in points]
        if not points or times[0] != 0.0:
            raise BenchError(f"The {what} points of profile {self.name!r} begin at {times[:1]} s; begin at 0 s.")
        if not all(math.isfinite(value) for point in points for value in point):
            raise BenchError(f"The {what} points of profile {self.name!r} hold a value that is not finite.")
        if any(b <= a for a, b in pairwise(times)):
            raise BenchError(
                f"The {what} times of profile {self.name!r} are {times} s; each must be later than the one before."
            )
        if self.repeats and points[0][1] != points[-1][1]:
            raise BenchError(
                f"The repeating profile {self.name!r} begins its {what} at {points[0][1]} and ends it at "
                f"{points[-1][1]}; make both the same, or it jumps at the end of each round."
            )


def _interpolate(points: Points, t: float) -> float:
    """Return the value at `t`; the lists are short, so a plain search is as fast as any."""
    before = points[0]
    if t <= before[0]:
        return before[1]
    for after in points[1:]:
        if t < after[0]:
            share = (t - before[0]) / (after[0] - before[0])
            return before[1] + share * (after[1] - before[1])
        before = after
    return before[1]


def path(start: float, *legs: tuple[float, float]) -> Points:
    """Return points from `start` along legs of (value to reach, seconds it takes), each longer than 0 s."""
    points = [(0.0, start)]
    for value, seconds in legs:
        points.append((points[-1][0] + seconds, value))
    return tuple(points)


_RAMP = 200.0  # r/min per s, the ramp of the default run


def _stairs(*speeds: float, dwell: float) -> list[tuple[float, float]]:
    """Return legs from rest through `speeds` (r/min) at the ramp's rate, with a dwell (s) on each."""
    legs: list[tuple[float, float]] = []
    before = 0.0
    for speed in speeds:
        legs += [(speed, abs(speed - before) / _RAMP), (speed, dwell)]
        before = speed
    return legs


UP_DOWN = Profile(
    "up-down",
    "0 to 2200 r/min with short dwells and down again, a stop, then -1200 r/min and back; about 600 N·m",
    path(0.0, *_stairs(600.0, 1300.0, 1800.0, 2200.0, 1800.0, 1000.0, 0.0, -1200.0, 0.0, dwell=1.0)),
    path(600.0, (615.0, 9.0), (590.0, 8.0), (610.0, 8.0), (585.0, 8.0), (600.0, 10.0)),
    repeats=True,
)
RUN_UP = Profile("run-up", "0 to 2150 r/min in 40 s at 600 N·m", path(0.0, (2150.0, 40.0)), path(600.0, (600.0, 40.0)))
RUN_DOWN = Profile(
    "run-down", "2150 r/min to 0 in 40 s at 600 N·m", path(2150.0, (0.0, 40.0)), path(600.0, (600.0, 40.0))
)
DWELL_IN_BAND = Profile(
    "dwell-in-band",
    "approach to 1300 r/min, then dwells inside both forbidden bands, at 1354 and at 1800 r/min; 600 N·m",
    path(
        0.0,
        (1300.0, 6.5),
        (1300.0, 4.0),
        (1354.0, 1.0),
        (1354.0, 8.0),
        (1800.0, 3.0),
        (1800.0, 8.0),
        (0.0, 9.0),
    ),
    path(600.0, (600.0, 39.5)),
)
LOAD_STEP = Profile(
    "load-step",
    "1046 r/min throughout; the load steps 600, 300, 500, 600 N·m, each step within 50 ms",
    path(1046.0, (1046.0, 40.0)),
    path(
        600.0,
        (600.0, 10.0),
        (300.0, 0.05),
        (300.0, 9.95),
        (500.0, 0.05),
        (500.0, 9.95),
        (600.0, 0.05),
        (600.0, 9.95),
    ),
    repeats=True,
)

PROFILES: Mapping[str, Profile] = {p.name: p for p in (UP_DOWN, RUN_UP, RUN_DOWN, DWELL_IN_BAND, LOAD_STEP)}
DEFAULT = UP_DOWN.name


def profile(name: str) -> Profile:
    """Return the profile called `name`; raises `BenchError`, listing the names, when there is none."""
    try:
        return PROFILES[name]
    except KeyError:
        raise BenchError(f"There is no profile {name!r}; choose one of {', '.join(PROFILES)}.") from None
