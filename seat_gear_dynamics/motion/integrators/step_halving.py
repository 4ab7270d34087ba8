"""Classical Runge-Kutta with the step halved until (22) is met."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.motion import kernel
from seat_gear_dynamics.motion.integrators import field, run, tableau
from seat_gear_dynamics.motion.integrators.checks import positive
from seat_gear_dynamics.motion.integrators.field import FREE, Field, rates
from seat_gear_dynamics.motion.integrators.run import (
    DIVERGED,
    EVALUATIONS,
    FINISHED,
    FULL,
    NOW,
    REFUSED,
    REJECTED,
    STEPS,
    Run,
    diverged,
    full,
    note_sides,
    note_step,
    side,
)
from seat_gear_dynamics.motion.integrators.tableau import RUNGE_KUTTA_4, Tableau, step
from seat_gear_dynamics.motion.revision import revision

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class StepHalving:
    """The paper's own control: one step of h against two of h/2, halved until they differ by less than `tolerance`.

    Δ of (22) is taken as the largest difference of any of the 24 components, in b_c and b_c per τ. Every step begins
    anew with `step`, as the paper names no way for it to grow again, and the state goes on from the two half steps.
    With `extrapolate` it goes on from y(h/2) + (y(h/2) − y(h))/15 (local extrapolation, of fifth order; Hairer,
    Nørsett & Wanner 1993, II.4), of which the paper knows nothing.

    Limits: blind to changes of contact, across which it halves until the tolerance is met; that (22) is an estimate of
    one step's error, not of the motion's. A tangent lacks the jump that damping in contact only gives it.
    StepRefusedError where a step would be below `smallest_step`.
    """

    step: float = 0.2
    tolerance: float = 1e-8
    smallest_step: float = 1e-7
    extrapolate: bool = False

    def __post_init__(self) -> None:
        for name in ("step", "tolerance", "smallest_step"):
            positive(name, getattr(self, name))

    @property
    def tableau(self) -> Tableau:
        """The Runge-Kutta method of its steps."""
        return RUNGE_KUTTA_4

    def first_step(self, span: float) -> float:
        """Return the length that its first step tries over `span`."""
        return min(self.step, span)

    def march(self, run: Run, field: Field, start: float, end: float) -> int:
        """Take `run` from where it is to `end`; return how that ended."""
        lengths = map(float, (self.step, self.tolerance, self.smallest_step))
        return int(_march(run, field, end, *lengths, self.extrapolate))


@njit(error_model="numpy")
def _apart(first: Array, second: Array) -> float:
    """Return Δ of (22), infinite where a number is missing."""
    worst = 0.0
    for i in range(24):
        difference = abs(first[0, i] - second[0, i])
        if not difference < np.inf:
            return np.inf
        worst = max(worst, difference)
    return worst


@njit(error_model="numpy")
def _halve(run: Run, field: Field, h: float, tolerance: float, smallest: float, free: Index, second: Array) -> float:
    """Try h, h/2, ... until (22) is met; leave y(h) in run.end and y(h/2) and its stages in second; 0 is a refusal."""
    t, count = run.clock[NOW], run.rows.shape[0]
    middle, found = np.empty_like(run.end), second[run.k.shape[0]]
    step(t, h, run.rows, count, run.k, run.end, RUNGE_KUTTA_4, free, field, False)
    run.counts[EVALUATIONS] += 3
    while True:
        step(t, h / 2, run.rows, count, run.k, middle, RUNGE_KUTTA_4, free, field)
        second[0] = run.k[run.k.shape[0] - 1]
        step(t + h / 2, h / 2, middle, count, second, found, RUNGE_KUTTA_4, free, field)
        run.counts[EVALUATIONS] += 8
        if _apart(run.end, found) < tolerance:
            return h
        h /= 2
        run.counts[REJECTED] += 1
        run.end[:] = middle
        if h < smallest:
            return 0.0


def _entry(revision: int) -> Any:
    @njit(cache=True, error_model="numpy", nogil=True)
    def march(
        run: Run, field: Field, end: float, longest: float, tolerance: float, smallest: float, extrapolate: bool
    ) -> int:
        _ = revision
        free, stages, count = np.full(2, FREE), run.k.shape[0], run.rows.shape[0]
        second, before = np.zeros((stages + 1, count, 24)), np.empty(2)
        if run.counts[STEPS] == 0:
            rates(run.clock[NOW], run.rows, run.k[0], count, free, field)
            run.counts[EVALUATIONS] += 1
            for j in range(2):
                run.branches[j] = side(field.mesh[j, 0], field.half_backlash[j])
        while run.clock[NOW] < end:
            if full(run):
                return FULL
            before[:] = field.mesh[:, 0]
            remaining = end - run.clock[NOW]
            whole = min(longest, remaining)
            h = _halve(run, field, whole, tolerance, smallest, free, second)
            if h == 0.0:
                return REFUSED
            run.rows[:] = second[stages]
            run.k[0] = second[stages - 1]
            run.clock[NOW] = end if h == remaining else run.clock[NOW] + h
            if extrapolate:
                run.rows[:] += (second[stages] - run.end) / 15
                rates(run.clock[NOW], run.rows, run.k[0], count, free, field)
                run.counts[EVALUATIONS] += 1
            if diverged(field):
                return DIVERGED
            note_step(run, h)
            note_sides(run, before, run.branches, h, field)
        return FINISHED

    return march


_march = _entry(revision(kernel, field, tableau, run))
