"""The operating points that a candidate is judged at, claim by claim."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DAMPING_RATIO, LOAD, BACKLASH = 0.07, 600.0, 20e-6


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """All points as columns, with the names of the claims they serve."""

    frequency: Array
    damping_ratio: Array
    load: Array
    backlash: Array
    """m"""
    claim: tuple[str, ...]

    def of(self, claim: str) -> NDArray[np.intp]:
        """Return the indices of a claim's points, in the order they were laid out."""
        return np.flatnonzero(np.array(self.claim) == claim)


@lru_cache(maxsize=1)
def operating_points() -> OperatingPoints:
    """Return the 226 points of the search.

    They are no round frequencies on purpose: `reproduce` judges on others. C10 is looked at at Ω = 1, as C9 is.
    """
    rows: list[tuple[float, float, float, float, str]] = []

    def lay(claim: str, frequencies: Array, xi: float = DAMPING_RATIO) -> None:
        rows.extend((float(f), xi, LOAD, BACKLASH, claim) for f in frequencies)

    lay("C1", np.linspace(0.1, 0.69, 8))
    lay("C5", np.linspace(0.704, 1.2445, 36))
    lay("C2", np.array([1.255, 1.265, 1.275, 1.285, 1.29, 1.295, 1.30, 1.31, 1.32]))
    lay("C5", np.linspace(1.3355, 1.5135, 13))
    lay("C3", np.linspace(1.5225, 1.9685, 46))
    lay("C4", np.array([1.98, 1.99, 2.005]))
    for xi in (0.09, 0.11, 0.13):
        lay(f"C7 {xi}", np.linspace(0.73, 1.97, 9), xi)
    lay("C8", np.linspace(0.7, 1.4, 8), 0.03)
    for claim, loads in (
        ("C9 low", np.linspace(22, 397, 33)),
        ("C9 about", (403, 409, 415, 421, 427, 433, 439)),
        ("C9 high", np.linspace(443, 637, 14)),
    ):
        rows.extend((1.0, DAMPING_RATIO, float(load), BACKLASH, claim) for load in loads)
    rows.extend((1.0, DAMPING_RATIO, 100.0, float(b), "C10") for b in 3.5e-6 * 1.085 ** np.arange(22))
    columns = list(zip(*rows, strict=True))
    numbers = [np.array(column) for column in columns[:4]]
    return OperatingPoints(numbers[0], numbers[1], numbers[2], numbers[3], tuple(columns[4]))
