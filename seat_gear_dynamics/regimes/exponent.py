"""The largest Lyapunov exponent from the growth of a tangent, with its uncertainty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.winding import weighted_mean, windowed_means

Array = NDArray[np.float64]

SHORTEST_GROWTH = 16
"""Least number of intervals for an exponent."""
_BLOCKS = 8  # block means of successive periods are nearly independent, single periods are not


@dataclass(frozen=True)
class Exponent:
    """A largest Lyapunov exponent per unit of dimensionless time and its standard error."""

    value: float
    error: float

    def above(self, threshold: float, *, errors: float) -> bool:
        """Return whether the exponent lies above `threshold` by more than that many standard errors."""
        return self.value - errors * self.error > threshold

    def within(self, threshold: float, *, errors: float) -> bool:
        """Return whether the exponent is within `threshold` of zero, and that many standard errors are as well."""
        return abs(self.value) <= threshold and errors * self.error <= threshold


def largest_exponent(growth: Array, interval: float) -> Exponent:
    """Return the mean logarithmic growth rate of a tangent (Benettin et al. 1980) and its standard error.

    `growth` has shape (n,), n >= 16: the logarithmic growth over successive intervals of length `interval` (τ).
    The error is that of the mean of eight blocks; it covers sampling, not a transient that has not decayed. Limit:
    a train with nearly free rotation has an exponent just below zero whatever it does.
    """
    _long_enough(growth)
    used = growth[len(growth) % _BLOCKS :]
    means = used.reshape(_BLOCKS, -1).mean(axis=1) / interval
    return Exponent(float(means.mean()), float(means.std(ddof=1) / np.sqrt(_BLOCKS)))


def weighted_exponent(growth: Array, interval: float) -> Exponent:
    """Return the growth rate as a weighted Birkhoff average, and how far it differs between halves of the record.

    Arguments and units as for `largest_exponent`. On a torus growth comes and goes with the phase, which makes the
    error of block means large though it adds up to nothing; the weighted average is then zero to many digits. For
    chaos it is the poorer estimate of the two. Limit: the error is the scatter of three overlapping halves, too small
    by chance now and then; alone it decides nothing.
    """
    _long_enough(growth)
    halves = windowed_means(growth) / interval
    return Exponent(float(weighted_mean(growth)) / interval, float(halves.std(ddof=1)))


def _long_enough(growth: Array) -> None:
    if len(growth) < SHORTEST_GROWTH:
        raise ValueError(f"An exponent was asked of {len(growth)} intervals; expected at least {SHORTEST_GROWTH}.")
