"""Signal-to-noise ratios in dB: one number for the level and the scatter of repeated observations; larger is better.

Formulae: Phadke, Quality Engineering Using Robust Design (1989), chapter 5; Yang & El-Haik, Design for Six Sigma
(2003), (14.15), (14.18) and (14.20). The ratio is taken over the last axis.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def smaller_the_better(observations: ArrayLike) -> Array:
    """Return −10·lg(mean of y²), dB, of observations y ≥ 0 whose ideal is 0; shape (…, n) to (…).

    Raises ValueError for no observation, numbers that are not finite, negative ones, and where all are 0: the ratio is
    infinite there.
    """
    y = _observations(observations, least=1)
    if np.any(y < 0):
        raise ValueError(f"An observation is {y.min():g}, expected at least 0: smaller-the-better has its ideal at 0.")
    return _decibels(1.0, np.mean(y**2, axis=-1), "all observations of a run are 0")


def larger_the_better(observations: ArrayLike) -> Array:
    """Return −10·lg(mean of 1/y²), dB, of observations y > 0 whose ideal is infinite; shape (…, n) to (…).

    Raises ValueError for no observation, numbers that are not finite, and any that is not positive.
    """
    y = _observations(observations, least=1)
    if np.any(y <= 0):
        raise ValueError(f"An observation is {y.min():g}, expected more than 0: larger-the-better takes its inverse.")
    return _decibels(1.0, np.mean(1 / y**2, axis=-1), "all observations of a run are infinite")


def nominal_the_best(observations: ArrayLike) -> Array:
    """Return 10·lg(mean²/variance), dB, for a target that the mean is adjusted to afterwards; shape (…, n) to (…).

    The variance is that of a sample (n − 1); Taguchi's own form takes variance/n from mean² first, which for small
    scatter is the same. Raises ValueError for fewer than two observations, numbers that are not finite, no scatter at
    all and a mean of 0.
    """
    y = _observations(observations, least=2)
    mean_square = np.mean(y, axis=-1) ** 2
    if np.any(mean_square == 0):
        raise ValueError("The mean of a run is 0, where mean²/variance says nothing; take the form for signed values.")
    return _decibels(mean_square, np.var(y, axis=-1, ddof=1), "the observations of a run do not scatter")


def signed_nominal_the_best(observations: ArrayLike) -> Array:
    """Return −10·lg(variance), dB, for a target where values of both signs occur; shape (…, n) to (…).

    The second form of nominal-the-best: scatter alone, in the square of the observations' unit. Raises ValueError for
    fewer than two observations, numbers that are not finite and no scatter at all.
    """
    y = _observations(observations, least=2)
    return _decibels(1.0, np.var(y, axis=-1, ddof=1), "the observations of a run do not scatter")


def _observations(observations: ArrayLike, *, least: int) -> Array:
    y = np.asarray(observations, dtype=float)
    if y.ndim == 0 or y.shape[-1] < least:
        raise ValueError(f"A run has {0 if y.ndim == 0 else y.shape[-1]} observations, expected at least {least}.")
    if not np.isfinite(y).all():
        raise ValueError("An observation is not a finite number; leave the run out and say so.")
    return y


def _decibels(signal: Array | float, noise: Array, cause: str) -> Array:
    if np.any(noise == 0):
        raise ValueError(f"The ratio is infinite: {cause}.")
    return np.asarray(10 * np.log10(signal / noise))
