"""Straight lines through the last samples of a quantity, in compiled sums over a buffer that is written in place."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROOM = 256  # samples at first; doubled where a window holds more


class Line(NamedTuple):
    """A least-squares line; all 0 of no samples."""

    samples: int
    mean: float
    """Of the values."""
    slope: float
    """Per s; 0 where all times are equal."""
    square: float
    """Sum of the squared distances of the times from their mean, s²."""
    after: float
    """From the times' mean to the last time, s."""


class Rise(NamedTuple):
    """How a quantity rose or fell over a few samples; all 0 where all times are equal."""

    slope: float
    """Of the least-squares line, per s."""
    error: float
    """Standard error of the slope by what the samples lie off the line, per s."""
    square: float
    """Sum of the squared distances of the times from their mean, s²."""
    largest: float
    """The largest difference of two neighbours, over that of the first and the last; infinite where that is 0."""


class Samples:
    """The samples of the last `window` s, one after the other in memory.

    Where a value is `held` between its measurements, samples that repeat it are none.
    """

    def __init__(self, window: float, *, held: bool = False) -> None:
        self.window = window
        self._held = held
        self._time, self._value = np.empty(_ROOM), np.empty(_ROOM)
        self.clear()

    def clear(self) -> None:
        """Forget all samples."""
        self._first = self._end = 0
        self.first: float | None = None
        """Time of the oldest sample kept, s."""
        self.last: float | None = None
        """Time of the newest, s."""

    def __len__(self) -> int:
        return self._end - self._first

    def add(self, t: float, value: float) -> None:
        """Take a sample; times must not decrease."""
        if self._end == len(self._time):
            self._make_room()
        self._time[self._end], self._value[self._end] = t, value
        self._end += 1
        self.first = t if self.first is None else self.first
        self.last = t
        while self.first < t - self.window:
            self._first += 1
            self.first = float(self._time[self._first])

    def line(self, since: float = -np.inf) -> Line:
        """Return the line through the samples from time `since` (s) on."""
        return Line(*_line(self._time, self._value, self._first, self._end, since))

    def rise(self, since: float, least: int) -> Rise | None:
        """Return how the samples from time `since` (s) on rose, or the last `least` of them where those are more.

        None where there are fewer.
        """
        if len(self) < least:
            return None
        return Rise(*_rise(self._time, self._value, self._first, self._end, since, least))

    def mean(self, since: float = -np.inf) -> tuple[float, int]:
        """Return the mean of the samples from time `since` (s) on, and of how many measurements it is."""
        mean, count, stretches = _mean(self._time, self._value, self._first, self._end, since)
        return mean, stretches if self._held else count

    def _make_room(self) -> None:
        kept = slice(self._first, self._end)
        room = len(self._time) * (2 if len(self) > len(self._time) // 2 else 1)
        for name in ("_time", "_value"):
            moved = np.empty(room)
            moved[: len(self)] = getattr(self, name)[kept]
            setattr(self, name, moved)
        self._first, self._end = 0, len(self)


@njit(cache=True, nogil=True, error_model="numpy")
def _line(time: Array, value: Array, first: int, end: int, since: float) -> tuple[int, float, float, float, float]:
    """Return what `Line` holds; sums run in order of time, so that every processor gives the same numbers."""
    while first < end and time[first] < since:
        first += 1
    n = end - first
    if n == 0:
        return 0, 0.0, 0.0, 0.0, 0.0
    t0, x0 = time[first], value[first]  # sums over differences: a steady value gives a slope of 0 without rounding
    t_sum, x_sum = 0.0, 0.0
    for k in range(first, end):
        t_sum += time[k] - t0
        x_sum += value[k] - x0
    t_mean = t_sum / n
    square, product = 0.0, 0.0
    for k in range(first, end):
        spread = time[k] - t0 - t_mean
        square += spread * spread
        product += spread * (value[k] - x0)
    slope = product / square if square > 0 else 0.0
    return n, x0 + x_sum / n, slope, square, time[end - 1] - t0 - t_mean


@njit(cache=True, nogil=True, error_model="numpy")
def _rise(time: Array, value: Array, first: int, end: int, since: float, least: int) -> tuple[float, ...]:
    while first < end - least and time[first] < since:
        first += 1
    n, _, slope, square, after = _line(time, value, first, end, -np.inf)
    if n < 3 or not square > 0:
        return 0.0, 0.0, 0.0, 0.0
    t_mean, x_sum = time[end - 1] - after, 0.0
    for k in range(first, end):
        x_sum += value[k] - value[first]
    off, largest = 0.0, 0.0
    for k in range(first, end):
        residual = value[k] - value[first] - x_sum / n - slope * (time[k] - t_mean)
        off += residual * residual
        if k > first:
            largest = max(largest, abs(value[k] - value[k - 1]))
    whole = abs(value[end - 1] - value[first])
    return slope, np.sqrt(off / (n - 2) / square), square, largest / whole if whole > 0 else np.inf


@njit(cache=True, nogil=True, error_model="numpy")
def _mean(time: Array, value: Array, first: int, end: int, since: float) -> tuple[float, int, int]:
    while first < end and time[first] < since:
        first += 1
    if first == end:
        return 0.0, 0, 0
    total, stretches = 0.0, 1
    for k in range(first, end):
        total += value[k]
        stretches += k > first and value[k] != value[k - 1]
    return total / (end - first), end - first, stretches
