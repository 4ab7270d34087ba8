"""The calibration loop: how fast this machine is at plain dependent arithmetic, the unit that others are counted in.

One loop for all benchmarks: the logistic map x → a·x·(1 − x) with a and x given at run time, compiled by numba as it
stands. Each step waits for the one before, rounding makes the order of its operations part of the result, and its
orbit comes to no rest for a = 3.9, so that a compiler can leave out none of them. What it cannot tell: vector width,
memory and the number of processors.
"""

from typing import Any

from numba import njit

from benchmarks.timing import best_of

UNIT = 100_000_000
"""Steps of the loop that count as one calibration."""
GROWTH, START = 3.9, 0.4  # a chaotic orbit; passed as arguments, so that nothing is known to the compiler


def _logistic(x: float, growth: float, count: int) -> float:
    for _ in range(count):
        x = growth * x * (1.0 - x)
    return x


logistic: Any = njit("f8(f8, f8, i8)")(_logistic)
"""logistic(x, growth, count): x after `count` steps."""


def calibration_seconds(*, steps: int = UNIT // 10, repeats: int = 3) -> float:
    """Return the seconds of the wall that UNIT steps take now, by the quickest of `repeats` runs of `steps`."""
    return best_of(lambda: logistic(START, GROWTH, steps), repeats) * UNIT / steps


def calibration_run(steps: int = 100_000) -> float:
    """Run `steps` of the loop and return how many: a run as `timing.in_turn` wants it."""
    logistic(START, GROWTH, steps)
    return float(steps)
