"""Classical Runge-Kutta (20)-(21) with equal steps, blind to changes of contact."""

from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from numba import njit

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
    PLACE,
    Run,
    diverged,
    full,
    note_sides,
    note_step,
    side,
)
from seat_gear_dynamics.motion.integrators.tableau import RUNGE_KUTTA_4, Tableau, advance, step
from seat_gear_dynamics.motion.revision import revision


@dataclass(frozen=True)
class FixedStep:
    """(20)-(21) with the factor 1/6 that (20) lacks, in equal steps of at most `step` in τ that end with the span.

    Of fourth order on smooth arcs and of about second across changes of contact, which fall inside steps. A tangent
    lacks the jump that damping in contact only gives it. Source: the paper's (20)-(21).
    """

    step: float = 0.05

    def __post_init__(self) -> None:
        positive("step", self.step)

    @property
    def tableau(self) -> Tableau:
        """The Runge-Kutta method of its steps."""
        return RUNGE_KUTTA_4

    def first_step(self, span: float) -> float:
        """Return the length of its first step over `span`."""
        return span / ceil(span / self.step * (1 - 1e-12))

    def march(self, run: Run, field: Field, start: float, end: float) -> int:
        """Take `run` from where it is to `end`, of a span from `start`; return how that ended."""
        return int(_march(run, field, start, end, round((end - start) / self.first_step(end - start))))


def _entry(revision: int) -> Any:
    @njit(cache=True, error_model="numpy", nogil=True)
    def march(run: Run, field: Field, start: float, end: float, pieces: int) -> int:
        _ = revision
        free, count = np.full(2, FREE), run.rows.shape[0]
        h, before = (end - start) / pieces, np.empty(2)
        if run.counts[PLACE] == 0:
            rates(run.clock[NOW], run.rows, run.k[0], count, free, field)
            run.counts[EVALUATIONS] += 1
            for j in range(2):
                run.branches[j] = side(field.mesh[j, 0], field.half_backlash[j])
        while run.counts[PLACE] < pieces:
            if full(run):
                return FULL
            before[:] = field.mesh[:, 0]
            step(run.clock[NOW], h, run.rows, count, run.k, run.end, RUNGE_KUTTA_4, free, field)
            run.counts[EVALUATIONS] += 4
            if diverged(field):
                return DIVERGED
            advance(run.rows, count, run.k, run.end)
            run.counts[PLACE] += 1
            run.clock[NOW] = end if run.counts[PLACE] == pieces else start + run.counts[PLACE] * h
            note_step(run, h)
            note_sides(run, before, run.branches, h, field)
        return FINISHED

    return march


_march = _entry(revision(kernel, field, tableau, run))
