"""Whether a noisy drive stands where it stood: a dwell tested on means, not on samples."""

from math import sqrt

from seat_gear_dynamics.sensing.differences import Differences
from seat_gear_dynamics.sensing.line import Samples

_ANCHOR = 0.2  # s from the beginning whose mean is where the drive stands
_NOW = 0.1  # s whose mean is where it is now
_COURSE = 0.3  # s whose slope tells a ramp
_LOOKBACK = 0.5  # s of record that a judgement of the motion looks back on
_JUMP = 6.0  # deviations of noise beyond which a single sample is no noise
_SURE = 4.0  # standard errors from which a mean or a slope has changed


class Standing:
    """Whether one quantity stands where it stood when its record began.

    It may range by `tolerance` (relative to where it stood) and by `floor` (its own unit) at least: at light loads and
    low speeds a share of the value lies inside the bench's noise and means nothing to the motion. It has moved where

    - a sample is farther off than that by six deviations of the noise: a step, seen at once;
    - the mean of the last 0.1 s is farther off, by four standard errors, from that of the first 0.2 s: a drift;
    - the slope of the last 0.3 s is sure (four standard errors), and would lead farther off within the half second
      that a record spans: a ramp, which a mean sees late.

    Noise is measured as the sample comes (`Differences.average`, which sees the steps of a coarse sensor as well), so
    a quiet drive is held to the tolerance alone. Times in s. Where a value is `held` between its measurements, samples
    that repeat it count once. Every sample is tested and the measured noise scatters by a fifth, so white noise alone
    crosses four errors about once in 40 s, which costs a judgement 0.3 s. Limits: before 16 measurements no noise is
    known and samples are tested bare; noise that is correlated over 0.1 s counts as motion; a drift that four errors of
    its means hide is not seen, up to 1.6 deviations of the noise at 100 samples a second beyond the tolerance.
    """

    def __init__(self, tolerance: float, floor: float, *, held: bool = False) -> None:
        self._tolerance, self._floor = tolerance, floor
        self._held = held
        self.forget()

    def forget(self) -> None:
        """Forget where it stood, and its noise."""
        self._differences = Differences(held=self._held)
        self._recent = Samples(_COURSE, held=self._held)
        self._began: float | None = None

    def moved(self, t: float, value: float) -> bool:
        """Take a sample; return whether the quantity has moved, and then let a new record begin here.

        The first sample begins a record and has not moved.
        """
        noise = self._differences.average()
        self._differences.add(t, value)
        if self._began is None:
            self.begin(t, value)
            return False
        self._recent.add(t, value)
        if self._left(t, value, noise):
            self.begin(t, value)
            return True
        if t - self._began <= _ANCHOR:
            self._anchor, self._count = self._recent.mean(self._began)
        return False

    def begin(self, t: float, value: float) -> None:
        """Let a record begin at a sample."""
        self._began, self._anchor, self._count = t, value, 1
        self._recent.clear()
        self._recent.add(t, value)

    def _left(self, t: float, value: float, noise: float) -> bool:
        allowed = max(self._tolerance * abs(self._anchor), self._floor)
        if abs(value - self._anchor) > allowed + _JUMP * noise:
            return True
        mean, count = self._recent.mean(t - _NOW)
        if abs(mean - self._anchor) > allowed + _SURE * noise * sqrt(1 / count + 1 / self._count):
            return True
        first = self._recent.first
        if first is None or t - first < _COURSE / 2:
            return False
        line = self._recent.line()
        if abs(line.slope) * _LOOKBACK <= allowed:
            return False
        _, measured = self._recent.mean()
        return abs(line.slope) * sqrt(line.square * measured / line.samples) > _SURE * noise
