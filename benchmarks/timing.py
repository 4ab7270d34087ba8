"""How times are taken: the shortest of several, and rounds in which all that is compared takes its turn.

What else a machine does makes a run longer, never shorter. So the shortest of several counts; what is to be compared
runs in turn, so that a slow stretch of the machine falls on all alike; and what one thread does is timed by the
processor's clock, which stands while others have the processor.
"""

from collections.abc import Callable, Mapping
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Work = Callable[[], float]
"""Does something and returns how much of it, in a unit of its own."""

Clock = Callable[[], float]
"""Seconds, of the wall or of the processor."""

GROUPS = 5
"""Repeats that a ratio is made of, where its runs are short: enough to see how far it scatters."""


def seconds_of(action: Callable[[], Any], clock: Clock = perf_counter) -> float:
    """Return the seconds that one run of `action` takes by `clock`."""
    begin = clock()
    action()
    return clock() - begin


def best_of(action: Callable[[], Any], repeats: int = 3, clock: Clock = perf_counter) -> float:
    """Return the seconds of the shortest of `repeats` runs of `action` by `clock`."""
    return min(seconds_of(action, clock) for _ in range(repeats))


def in_turn(runs: Mapping[str, Work], rounds: int, clock: Clock = process_time) -> dict[str, Array]:
    """Return what each run does in a second, round by round, (rounds,), after one run of each that may compile.

    By processor time unless told otherwise, which is right for work of one thread only.
    """
    for run in runs.values():
        run()
    rates = {name: np.empty(rounds) for name in runs}
    for n in range(rounds):
        for name, run in runs.items():
            begin = clock()
            done = run()
            rates[name][n] = done / (clock() - begin)
    return rates


def best_in_groups(rates: Mapping[str, Array], groups: int = GROUPS) -> dict[str, Array]:
    """Return the best rate of each of `groups` stretches of rounds, (groups,): repeats that were disturbed least."""
    return {name: np.array([part.max() for part in np.array_split(found, groups)]) for name, found in rates.items()}
