"""The 0-1 test for chaos: a walk driven by a series stays bounded for regular motion and strays for chaos."""

from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Verdict = Literal["regular", "chaotic", "undecided"]

SHORTEST_SERIES = 100
"""Samples below which there is no value: the displacement is taken over a tenth of them, and ten make a correlation."""
TRUSTED_SERIES = 300
"""Samples below which a value is given but nothing is said: tori of 150 points were met with values up to 0.98."""
REGULAR, CHAOTIC = 0.2, 0.8
"""Values up to the first are called regular, from the second on chaotic; what lies between is undecided."""
_CONSTANT = 1e-12  # a spread below this share of the magnitude is rounding


@dataclass(frozen=True)
class ZeroOne:
    """What the 0-1 test gives for one series."""

    value: float | None
    """K: near 0 for regular, near 1 for chaotic motion; None for a series shorter than SHORTEST_SERIES."""
    spread: float | None
    """Interquartile range of K over the frequencies c; None where the value is."""
    samples: int
    """Length of the series."""

    @property
    def verdict(self) -> Verdict:
        """What the value says: "regular", "chaotic", or "undecided" between them and below TRUSTED_SERIES samples."""
        if self.value is None or self.samples < TRUSTED_SERIES or REGULAR < self.value < CHAOTIC:
            return "undecided"
        return "regular" if self.value <= REGULAR else "chaotic"


def zero_one(series: Array, generator: np.random.Generator, *, frequencies: int = 100) -> ZeroOne:
    """Return K of the 0-1 test (Gottwald & Melbourne 2009, SIAM J. Appl. Dyn. Syst. 8, 129-145).

    `series` (n,) is one quantity of the motion, in any unit, once a period of the excitation; `generator` draws the
    `frequencies` values of c from (π/5, 4π/5), and equal generators give equal results. For each c the mean-square
    displacement of the walk p, q over up to n/10 steps, less its oscillating term, is correlated with the number of
    steps; K is the median over c. Raises ValueError for a series that is not one-dimensional and finite, and for less
    than one frequency.

    Limits. An oversampled series looks regular whatever it is: give a stroboscopic section, never a time history.
    Noise gives 1, as chaos does. A large periodic part hides weak chaos, and needs to be taken out first. Motion near
    the edge of a locking tongue, where it passes slowly through a bottleneck, gives values up to 1 in short records.
    """
    if series.ndim != 1 or not np.isfinite(series).all():
        raise ValueError(
            f"The series has shape {series.shape} and {int((~np.isfinite(series)).sum())} values that are not finite; "
            "expected one dimension of finite values."
        )
    if frequencies < 1:
        raise ValueError(f"The test was asked for with {frequencies} frequencies; expected at least 1.")
    n = len(series)
    if n < SHORTEST_SERIES:
        return ZeroOne(None, None, n)
    magnitude = float(np.abs(series).max())
    if np.ptp(series) <= _CONSTANT * magnitude:
        return ZeroOne(0.0, 0.0, n)
    c = generator.uniform(pi / 5, 4 * pi / 5, frequencies)
    low, middle, high = np.quantile(_correlations(series / magnitude, c), [0.25, 0.5, 0.75])
    return ZeroOne(float(middle), float(high - low), n)


def _correlations(series: Array, c: Array) -> Array:
    """Return the correlation of displacement with the number of steps for each c, shape of c."""
    steps = np.arange(1, len(series) // 10 + 1)
    oscillation = series.mean() ** 2 * (1 - np.cos(np.outer(c, steps))) / (1 - np.cos(c))[:, None]
    displacement = _displacement(np.ascontiguousarray(series), c, len(steps)) - oscillation
    displacement -= displacement.mean(axis=1, keepdims=True)
    centred = steps - steps.mean()
    norms = np.sqrt((displacement**2).sum(axis=1) * (centred @ centred))
    return np.asarray(np.divide(displacement @ centred, norms, out=np.zeros(len(c)), where=norms > 0))


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _displacement(series: Array, c: Array, longest: int) -> Array:
    """Return the mean-square displacement of the walk over 1 to `longest` steps for each c, (c, longest).

    Sums may be reordered: in their strict order they take four times as long, and the result moves by rounding only.
    """
    n = len(series)
    window = n - longest
    p, q, found = np.empty(n), np.empty(n), np.empty((len(c), longest))
    for k in range(len(c)):
        x, y = 0.0, 0.0
        for j in range(n):
            x += series[j] * np.cos((j + 1) * c[k])
            y += series[j] * np.sin((j + 1) * c[k])
            p[j], q[j] = x, y
        for step in range(1, longest + 1):
            total = 0.0
            for j in range(window):
                along, across = p[j + step] - p[j], q[j + step] - q[j]
                total += along * along + across * across
            found[k, step - 1] = total / window
    return found
