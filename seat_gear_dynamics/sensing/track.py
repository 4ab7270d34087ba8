"""A measured quantity over the last moments: its level, its slope and its noise, told apart."""

from math import inf, sqrt

from seat_gear_dynamics.sensing.differences import Differences
from seat_gear_dynamics.sensing.line import Samples

_EVERY = 0.02  # s between two measurements of the noise: faster inputs need no more
_JUMP = 6.0  # deviations from the fitted line beyond which a sample is no noise but a new level
_SURE = 3.0  # standard errors from which a slope is believed
_BEGINNING = 6  # parts of the window, of which the last shows a slope that has just begun; and samples it has to have
_CERTAIN = 5.0  # standard errors that such a slope asks for: there are some 60 000 of them in an hour
_GOES_ON = 2.0  # standard errors with which it goes on
_STEP = 0.5  # share of a rise from which one difference makes it a step, a sensor's or the quantity's, and no slope


class Track:
    """Follows one quantity sampled at any times; times in s, the quantity in its own unit.

    `slope` is least squares over `window`, `begun` over the last sixth of it where that is certain. `noise` is the
    standard deviation of what changes from sample to sample: the median size of second differences (`Differences`),
    which neither a ramp nor a single spike moves. Where a value is `held` between its measurements, samples that repeat
    it are none.
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
        self._begun: float | None = None
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
        self._begun = None if self._held else self._beginning(t)

    def slope(self) -> float:
        """Return the least-squares slope over the window, per s; 0 while it cannot be known."""
        return self._recent.line().slope if len(self._recent) >= 3 else 0.0

    def begun(self) -> float | None:
        """Return the slope of the last sixth of the window, six samples at least, where it is certain; else None.

        What begins to move shows there long before it does over the whole window. Certain is what exceeds five standard
        errors, both by the noise and by what the samples lie off their line, and is no step: no difference of two
        samples is more than half of the rise. It stays so while it exceeds two with its sign. Limits: a sensor's steps
        hide it that are not much finer than the rise; a value that is held is not looked at.
        """
        return self._begun

    def _beginning(self, t: float) -> float | None:
        """Return what `begun` says from time `t`, that of the last sample, on."""
        found = self._recent.rise(t - self.window / _BEGINNING, _BEGINNING)
        if found is None or not found.slope:
            return None
        error = max(found.error, self.noise / sqrt(found.square))
        if self._begun is not None and self._begun * found.slope > 0:
            return found.slope if abs(found.slope) > _GOES_ON * error else None
        certain = abs(found.slope) > _CERTAIN * error and found.largest <= _STEP
        return found.slope if certain else None

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
