"""The alarm: from speed, load and regime to a warning level, pure logic with time as an argument."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from math import isfinite

import numpy as np

from seat_gear_dynamics.gears import ForbiddenBand, GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes import Regime

_FAR = 3600.0  # s; a band farther ahead than this is not ahead: such an acceleration is noise


class Level(IntEnum):
    """Levels with the numbers of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class AlarmSettings:
    """How cautious the alarm is; speeds in rad/s of s1, times in s."""

    margin: float = 40 * RPM
    """WARN when closer to a band than this."""
    horizon: float = 1.0
    """WARN when the present acceleration reaches a band within this time."""
    hysteresis: float = 4 * RPM
    """A band is left only when this far outside it, and the margin likewise."""
    debounce: float = 0.03
    """A worse level has to last this long before it is shown."""
    hold: float = 0.3
    """A better level has to last this long before it is shown."""
    slope_window: float = 0.3
    """Acceleration is the least-squares slope of the speed over this time."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not isfinite(value) or value < 0:
                raise ValueError(f"The alarm's {name} is {value!r}, expected a finite number of at least 0.")
        if self.slope_window == 0:
            raise ValueError("The alarm's slope_window is 0 s, expected more than 0: a slope needs two samples.")


@dataclass(frozen=True)
class Verdict:
    """What the alarm says at a moment."""

    level: Level
    reason: str
    in_band: bool
    """Inside a forbidden band (with hysteresis and debounce): the trip signal."""
    band: ForbiddenBand | None
    """The band that the speed is in or nearest to."""
    distance: float | None
    """From |speed| to that band's nearest edge, rad/s; negative inside."""
    time_to_band: float | None
    """Until the present acceleration reaches the next band, s; 0 inside, None when none is ahead."""
    calm_speed: float | None
    """The nearest speed outside every band and its margin, with the sign of the present speed, rad/s."""


class Alarm:
    """Follows one drive and keeps the warning level steady.

    Bands hold for |speed|: the model is the same in both directions. Beyond the speed that the bands' source covers
    nothing is known, and the level is STALE. Bands are those given, whatever the load; a map by load comes later.
    """

    def __init__(
        self, bands: Sequence[ForbiddenBand], *, covered_speed: float, settings: AlarmSettings | None = None
    ) -> None:
        self.bands = tuple(sorted(bands, key=lambda band: band.low))
        self.covered_speed = covered_speed
        self.settings = settings or AlarmSettings()
        self.reset()

    @classmethod
    def for_train(cls, train: GearTrain, settings: AlarmSettings | None = None) -> "Alarm":
        """Return an alarm on the published bands of `train`."""
        return cls(train.bands, covered_speed=train.model.covered_speed, settings=settings)

    def reset(self) -> None:
        """Forget the past; the next update is taken as it is."""
        self._speeds: deque[tuple[float, float]] = deque()
        self._inside: ForbiddenBand | None = None
        self._near = False
        # One latch for the trip signal and one for each severity above the least: that it is at least so bad.
        self._tripped, *self._at_least = (_Latch(self.settings) for _ in Level)

    def update(self, t: float, speed: float, load: float, regime: Regime) -> Verdict:
        """Return the verdict at time `t` (s) for `speed` (rad/s of s1), `load` (N·m) and the motion's `regime`."""
        if self._speeds and t < self._speeds[-1][0]:
            self.reset()  # a clock that stepped back: its old times mean nothing any more
        magnitude = abs(speed)
        self._speeds.append((t, magnitude))
        while self._speeds[0][0] < t - self.settings.slope_window:
            self._speeds.popleft()
        ahead = self._time_to_band(magnitude)
        self._track(magnitude)
        level, reason = self._judge(magnitude, load, ahead, regime)
        found, level = level, self._steady(t, level)
        in_band = self._tripped.update(t, self._inside is not None)
        if (found, self._inside is not None) != (level, in_band):
            reason = f"{reason} (holding {level.name})"
        band = self._inside or self._nearest(magnitude)
        distance = _distance(band, magnitude) if band else None
        sign = -1.0 if speed < 0 else 1.0
        calm = self.calm_speed(magnitude, rattling=regime.name == "chaotic")
        return Verdict(level, reason, in_band, band, distance, ahead, None if calm is None else sign * calm)

    def stale(self, reason: str) -> Verdict:
        """Return the verdict for missing inputs; the next update starts afresh."""
        self.reset()
        return Verdict(Level.STALE, reason, False, None, None, None, None)

    def calm_speed(self, magnitude: float, *, rattling: bool = False) -> float | None:
        """Return the |speed| nearest to `magnitude`, rad/s, outside every band by the margin; None if there is none.

        Where the drive is `rattling` at `magnitude` itself, that speed is none either, whatever the bands say, nor are
        those within the margin of it.
        """
        margin = self.settings.margin
        blocked = [(band.low - margin, band.high + margin) for band in self.bands]
        if rattling:
            blocked.append((magnitude - margin, magnitude + margin))
        candidates = [magnitude, self.covered_speed, *(edge for pair in blocked for edge in pair)]
        calm = [
            c for c in candidates if 0 <= c <= self.covered_speed and not any(low < c < high for low, high in blocked)
        ]
        return min(calm, key=lambda c: abs(c - magnitude), default=None)

    def acceleration(self) -> float:
        """Return the least-squares slope of |speed| over the slope window, rad/s²; 0 while it cannot be known."""
        if len(self._speeds) < 3:
            return 0.0
        t, s = np.array(self._speeds).T
        spread = t - t.mean()
        square = float(spread @ spread)
        return float(spread @ (s - s[0])) / square if square > 0 else 0.0  # a steady speed gives 0 without rounding

    def _time_to_band(self, magnitude: float) -> float | None:
        if any(band.low <= magnitude <= band.high for band in self.bands):
            return 0.0
        slope = self.acceleration()
        gaps = [band.low - magnitude if slope > 0 else magnitude - band.high for band in self.bands]
        times = [gap / abs(slope) for gap in gaps if 0 < gap < abs(slope) * _FAR]
        return min(times, default=None)

    def _track(self, magnitude: float) -> None:
        """Follow being inside a band and near one, each left only beyond the hysteresis."""
        slack = self.settings.hysteresis
        if self._inside and not self._inside.low - slack <= magnitude <= self._inside.high + slack:
            self._inside = None
        for band in self.bands:
            if band.low <= magnitude <= band.high:
                self._inside = band
        nearest = self._nearest(magnitude)
        reach = self.settings.margin + (slack if self._near else 0.0)
        self._near = nearest is not None and _distance(nearest, magnitude) <= reach

    def _nearest(self, magnitude: float) -> ForbiddenBand | None:
        return min(self.bands, key=lambda band: _distance(band, magnitude), default=None)

    def _judge(self, magnitude: float, load: float, ahead: float | None, regime: Regime) -> tuple[Level, str]:
        rpm = magnitude / RPM
        if self._inside:
            low, high = self._inside.low / RPM, self._inside.high / RPM
            return Level.ERROR, f"{rpm:.0f} r/min is inside the forbidden band {low:.0f}-{high:.0f} r/min"
        if regime.name == "chaotic":
            return (
                Level.ERROR,
                f"the motion is chaotic at {rpm:.0f} r/min and {load:.0f} N·m: {regime.reason}",
            )
        if magnitude > self.covered_speed:
            return (
                Level.STALE,
                f"{rpm:.0f} r/min is beyond the studied range, which ends at {self.covered_speed / RPM:.0f} r/min",
            )
        if ahead is not None and ahead <= self.settings.horizon:
            return Level.WARN, f"a forbidden band is {ahead:.1f} s ahead at the present acceleration"
        if self._near:
            return (
                Level.WARN,
                f"{rpm:.0f} r/min is within {self.settings.margin / RPM:.0f} r/min of a forbidden band",
            )
        if regime.leans_chaotic:
            return Level.WARN, f"evidence of chaos is building: {regime.reason}"
        return Level.OK, f"{rpm:.0f} r/min is clear of the forbidden bands"

    def _steady(self, t: float, level: Level) -> Level:
        """Return the level to show: changed only once it has been worse for `debounce` or better for `hold`.

        Each severity has its own latch, so that levels which alternate cannot keep each other from being shown.
        """
        severity = _severity(level)
        shown = [latch.update(t, severity > rank) for rank, latch in enumerate(self._at_least)]
        return next(each for each in Level if _severity(each) == sum(shown))


class _Latch:
    """A statement that is shown as true once it held for `debounce`, and as false once it did not for `hold`."""

    def __init__(self, settings: AlarmSettings) -> None:
        self._settings = settings
        self._shown: bool | None = None
        self._since: float | None = None

    def update(self, t: float, found: bool) -> bool:
        """Return what to show at time `t` (s) of a statement found true or false; the first is shown at once."""
        if self._shown is None or found == self._shown:
            self._shown, self._since = found, None
            return found
        if self._since is None:
            self._since = t
        if t - self._since >= (self._settings.debounce if found else self._settings.hold):
            self._shown, self._since = found, None
        return self._shown


def _severity(level: Level) -> int:
    """Order levels by what they ask of a person: STALE says less than OK does, and stops no trip."""
    return {Level.STALE: 0, Level.OK: 1, Level.WARN: 2, Level.ERROR: 3}[level]


def _distance(band: ForbiddenBand, magnitude: float) -> float:
    """Return how far outside `band` a speed is, rad/s; negative inside by the way to the nearer edge."""
    return max(band.low - magnitude, magnitude - band.high)
