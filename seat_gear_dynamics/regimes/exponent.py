"""The largest Lyapunov exponent from the growth of a tangent, with its uncertainty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_BLOCKS = 8  # block means of successive periods are nearly independent, single periods are not


@dataclass(frozen=True)
class Exponent:
    """A largest Lyapunov exponent per unit of dimensionless time and its standard error."""

    value: float
    error: float


def largest_exponent(growth: Array, interval: float) -> Exponent:
    """Return the mean logarithmic growth rate of a tangent (Benettin et al. 1980) and its standard error.

    `growth` has shape (n,), n >= 16: the logarithmic growth over successive intervals of length `interval` (τ).
    The error is that of the mean of eight blocks; it covers sampling, not a transient that has not decayed. Limit:
    a train with nearly free rotation has an exponent just below zero whatever it does.
    """
    if len(growth) < 2 * _BLOCKS:
        raise ValueError(f"An exponent was asked of {len(growth)} intervals; expected at least {2 * _BLOCKS}.")
    used = growth[len(growth) % _BLOCKS :]
    means = used.reshape(_BLOCKS, -1).mean(axis=1) / interval
    return Exponent(float(means.mean()), float(means.std(ddof=1) / np.sqrt(_BLOCKS)))
