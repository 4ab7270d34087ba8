"""The dead zone f(δ) of (1) on samples of a motion, with its corners weighed where they fall between samples.

Sampled plainly, the harmonics of f(δ) have a derivative that jumps each time a corner passes a sample: near folds and
period doublings Newton's method then runs in circles. By the Euler-Maclaurin formula the trapezoidal sum of a function
whose slope jumps by s at the share p of a cell of length h is wrong by s·h²·(p(1 - p)/2 - 1/12); this is taken out at
the samples beside the corner. The harmonics are then as smooth in δ as those of f(δ) truly are, but for the third
order in h, and more exact.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def dead_zone(delta: Array, half: float) -> tuple[Array, Array]:
    """Return (f(δ), its slope) for sums over the samples of one period, each (n,); `half` is b/2 in δ's unit.

    Away from corners these are f(δ) and 1 or 0; the two samples beside a corner carry the correction. A teeth contact
    that begins and ends between two samples is not seen.
    """
    beyond = delta - np.clip(delta, -half, half)
    contact = (np.abs(delta) > half).astype(float)
    for side in (1.0, -1.0):
        over = side * delta - half
        after = np.roll(over, -1)
        left = np.flatnonzero((over > 0) != (after > 0))
        right = (left + 1) % len(delta)
        a, b = np.abs(over[left]), np.abs(after[left])
        share = a / (a + b)
        ramp = side * ((a + b) / 12 - a * b / (a + b) / 2)
        lacking = np.where(over[left] > 0, a - b, b - a) / (a + b) / 2
        for target, amount in ((beyond, ramp), (contact, lacking)):
            np.add.at(target, left, amount * (1 - share))
            np.add.at(target, right, amount * share)
    return beyond, contact
