"""A measured quantity over the last moments: its level, its slope and its noise, told apart."""

from collections import deque
from math import sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_KEPT = 32  # last samples that the noise is measured on
_LEAST = 16  # samples below which no noise is measured
_OLDEST = 2.0  # s; what is older says nothing of the noise now
_EVERY = 0.02  # s between two measurements of it: faster inputs need no more
_MEDIAN = 0.6744897501960817  # of |x| where x is normal with deviation 1
_JUMP = 6.0  # deviations from the fitted line beyond which a sample is no noise but a new level
_SURE = 3.0  # standard errors from which a slope is believed


class Track:
    """Follows one quantity sampled at any times; times in s, the quantity in its own unit.

    `slope` is least squares over `window`. `noise` is the standard deviation of what changes from sample to sample: the
    median size of second differences, which neither a ramp nor a single spike moves (Rousseeuw & Croux 1993 for the
    median, von Neumann et al. 1941 for differences). Where a value is `held` between its
    measurements, samples that repeat it are none.
    `fitted` is the end of a line through half of `window`; a sample beyond six deviations from it begins a new line, so
    that a step is seen at once. Limits: correlated noise is taken for motion; noise below a sensor's step may read 0.
    """

    def __init__(self, window: float, *, held: bool = False) -> None:
        self.window = window
        self._held = held
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._recent: deque[tuple[float, float]] = deque()
        self._measurements: deque[tuple[float, float]] = deque(maxlen=_KEPT)
        self._jumped = -np.inf
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
        return self._recent[-1][0] if self._recent else None

    @property
    def spans_half(self) -> bool:
        """Whether the samples kept reach back half of the window."""
        return bool(self._recent) and self._recent[-1][0] - self._recent[0][0] >= self.window / 2 * (1 - 1e-9)

    def add(self, t: float, value: float) -> None:
        """Take a sample; times must not decrease."""
        self._recent.append((t, value))
        while self._recent[0][0] < t - self.window:
            self._recent.popleft()
        kept = self._measurements
        if not (self._held and kept and value == kept[-1][1]):
            kept.append((t, value))
        while kept and kept[0][0] < t - _OLDEST:
            kept.popleft()
        if self._measured is None or t - self._measured >= _EVERY:
            self._measured, self.noise = t, _noise(kept)
        self._fit(t, value)

    def slope(self) -> float:
        """Return the least-squares slope over the window, per s; 0 while it cannot be known."""
        if len(self._recent) < 3:
            return 0.0
        t, s = np.array(self._recent).T
        spread = t - t.mean()
        square = float(spread @ spread)
        return float(spread @ (s - s[0])) / square if square > 0 else 0.0  # a steady value gives 0 without rounding

    def sure_slope(self) -> float:
        """Return the slope where it is beyond three of its standard errors, else 0."""
        slope = self.slope()
        if not slope or not self.noise:
            return slope
        t = np.array([each for each, _ in self._recent])
        error = self.noise / sqrt(float(((t - t.mean()) ** 2).sum()))
        return slope if abs(slope) > _SURE * error else 0.0

    def _fit(self, t: float, value: float) -> None:
        self.fitted, self.error = value, self.noise
        if not self.noise:
            return
        begin = max(self._jumped, t - self.window / 2)
        fit = _line_end([sample for sample in self._recent if sample[0] >= begin])
        if fit is None:
            return
        if abs(value - fit[0]) > _JUMP * self.noise:
            self._jumped = t
            return
        self.fitted, self.error = fit[0], fit[1] * self.noise


def _noise(samples: deque[tuple[float, float]]) -> float:
    """Return the standard deviation of white noise on a smooth motion, from how samples lie off their neighbours."""
    if len(samples) < _LEAST:
        return 0.0
    t, x = np.array(samples).T
    whole = t[2:] - t[:-2]
    after = np.divide(t[1:-1] - t[:-2], whole, out=np.full(len(whole), 0.5), where=whole > 0)
    off = x[1:-1] - ((1 - after) * x[:-2] + after * x[2:])
    return float(np.median(np.abs(off) / np.sqrt(1 + (1 - after) ** 2 + after**2))) / _MEDIAN


def _line_end(samples: list[tuple[float, float]]) -> tuple[float, float] | None:
    """Return a line's value at the last of `samples`, and its standard error per unit of noise; None for too few."""
    if len(samples) < 3:
        return None
    t, x = np.array(samples).T
    spread = t - t.mean()
    square = float(spread @ spread)
    if square == 0:
        return float(x.mean()), 1 / sqrt(len(x))
    slope = float(spread @ x) / square
    return float(x.mean()) + slope * float(spread[-1]), sqrt(1 / len(x) + float(spread[-1]) ** 2 / square)
