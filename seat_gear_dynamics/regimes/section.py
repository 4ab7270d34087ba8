"""Periods in a stroboscopic Poincaré section."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LONGEST_PERIOD = 16
"""Longest period looked for, in mesh periods; a cascade of doublings is taken for irregular beyond it."""


def recurrence(section: Array, period: int) -> float:
    """Return the largest distance between section points `period` apart, in the section's unit.

    `section` has shape (n, 2), n > period. Zero for an exactly periodic motion.
    """
    if not 0 < period < len(section):
        raise ValueError(
            f"Period {period} was asked of {len(section)} section points; expected 1 to {len(section) - 1}."
        )
    return float(np.abs(section[period:] - section[:-period]).max())


def find_period(section: Array, *, tolerance: float, longest: int = LONGEST_PERIOD) -> int | None:
    """Return the smallest period whose recurrence is within `tolerance`, or None.

    `section` has shape (n, 2) in units of b_c. A period needs three rounds of it in the record to be believed. Limits:
    a period-doubled motion whose split is below `tolerance` counts as undoubled.
    """
    for period in range(1, min(longest, len(section) // 3) + 1):
        if recurrence(section, period) <= tolerance:
            return period
    return None
