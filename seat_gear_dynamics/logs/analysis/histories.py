"""Time histories of bounded size: smallest, largest and mean of each quantity in equal bins of time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Binned:
    """Smallest, largest and mean of several quantities in `bins` equal bins from time `begin` to `end`, s.

    Rows before `begin` or after `end` count in the first or last bin; NaN counts nowhere. A bin without numbers is NaN.
    """

    def __init__(self, names: Sequence[str], begin: float, end: float, *, bins: int) -> None:
        if bins < 1 or not end >= begin:
            raise ValueError(f"Asked for {bins} bins from {begin!r} to {end!r} s, expected 1 or more and an end after.")
        self.names = tuple(names)
        self._begin, self._width = begin, max((end - begin) / bins, 1e-9)
        shape = (bins, len(self.names))
        self._least, self._most = np.full(shape, np.nan), np.full(shape, np.nan)
        self._sum, self._count = np.zeros(shape), np.zeros(shape)

    def add(self, time: Array, values: Array) -> None:
        """Take rows: `time` (n,), `values` (n, quantities)."""
        if not len(time):
            return
        where = np.clip((time - self._begin) // self._width, 0, len(self._sum) - 1).astype(np.int64)
        known = np.isfinite(values)
        np.fmin.at(self._least, where, np.where(known, values, np.nan))
        np.fmax.at(self._most, where, np.where(known, values, np.nan))
        np.add.at(self._sum, where, np.where(known, values, 0.0))
        np.add.at(self._count, where, known.astype(float))

    @property
    def time(self) -> Array:
        """The bins' middles, s, shape (bins,)."""
        return np.asarray(self._begin + (np.arange(len(self._sum)) + 0.5) * self._width)

    @property
    def width(self) -> float:
        """How long a bin is, s."""
        return self._width

    def least(self, name: str) -> Array:
        """Return the smallest value of each bin, (bins,)."""
        return np.asarray(self._least[:, self.names.index(name)])

    def most(self, name: str) -> Array:
        """Return the largest value of each bin, (bins,)."""
        return np.asarray(self._most[:, self.names.index(name)])

    def mean(self, name: str) -> Array:
        """Return the mean of each bin's rows, (bins,)."""
        column = self.names.index(name)
        with np.errstate(invalid="ignore"):
            return np.asarray(self._sum[:, column] / self._count[:, column])
