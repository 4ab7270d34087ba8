"""A measured quantity over the last moments: its level, its slope and its noise, told apart."""

from math import inf, sqrt

from seat_gear_dynamics.sensing.differences import Differences
from seat_gear_dynamics.sensing.line import Samples

_EVERY = 0.02  # s between two measurements of the noise: faster inputs need no more
_JUMP = 6.0  # deviations from the fitted line beyond which a sample is no noise but a new level
_SURE = 3.0  # standard errors from which a slope is believed


class Track:
    """Follows one quantity sampled at any times; times in s, the quantity in its own unit.

    `slope` is least squares over `window`. `noise` is the standard deviation of what changes from sample to sample: the
    median size of second differences (`Differences`), which neither a ramp nor a single spike moves. Where a value is
    `held` between its measurements, samples that repeat it are none.
    `fitted` is the end of a line through half of `window`; a sample beyond six deviations from it begins a new line, so
    that a step is seen at once. Limits: correlated noise is taken for motion; noise below a sensor's step may read 0.
    """

    def __init__(self, window: float, *, held: bool = False) -> None:
        self.window = window
        self._held = held
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._recent = Samples(self.window)
        self._differences = Differences(held=self._held)
        self._jumped = -inf
        self._measured: float | None = None
        self.noise = 0.0
        """Standard deviation from sample to sample; 0 while it cannot be known."""
        self.fitted = 0.0
        """The line's value at the last sample; the sample itself while there are fewer than three or no noise."""
        self.error = 0.0
        """Standard error of `fitted`."""

    @property
    def last(self) -> float | None:
        """Time of the last sample, s; None before the first."""
        return self._recent.last

    @property
    def spans_half(self) -> bool:
        """Whether the samples kept reach back half of the window."""
        first, last = self._recent.first, self._recent.last
        return first is not None and last is not None and last - first >= self.window / 2 * (1 - 1e-9)

    def add(self, t: float, value: float) -> None:
        """Take a sample; times must not decrease."""
        self._recent.add(t, value)
        self._differences.add(t, value)
        if self._measured is None or t - self._measured >= _EVERY:
            self._measured, self.noise = t, self._differences.robust()
        self._fit(t, value)

    def slope(self) -> float:
        """Return the least-squares slope over the window, per s; 0 while it cannot be known."""
        return self._recent.line().slope if len(self._recent) >= 3 else 0.0

    def sure_slope(self) -> float:
        """Return the slope where it is beyond three of its standard errors, else 0."""
        if len(self._recent) < 3:
            return 0.0
        line = self._recent.line()
        if not line.slope or not self.noise:
            return line.slope
        return line.slope if abs(line.slope) > _SURE * self.noise / sqrt(line.square) else 0.0

    def _fit(self, t: float, value: float) -> None:
        self.fitted, self.error = value, self.noise
        if not self.noise:
            return
        line = self._recent.line(max(self._jumped, t - self.window / 2))
        if line.samples < 3:
            return
        end = line.mean + line.slope * line.after
        if abs(value - end) > _JUMP * self.noise:
            self._jumped = t
            return
        error = sqrt(1 / line.samples + (line.after * line.after / line.square if line.square else 0.0))
        self.fitted, self.error = end, error * self.noise
