"""An integration under way, in arrays that compiled code and Python share."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.motion.integrators.field import Field
from seat_gear_dynamics.motion.integrators.tableau import Tableau

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FINISHED, FULL, DIVERGED, REFUSED, CHATTERING = range(5)
"""How a compiled loop may end; FULL asks for the records to be read and the loop to be called again."""
NOW, NEXT, SMALLEST, LAST_CHANGE = range(4)
"""Columns of `clock`: τ, the next step's length, the shortest step, and the τ of the last change of contact."""
STEPS, EVALUATIONS, REJECTED, EVENTS, CLOSE, PLACE = range(6)
"""Columns of `counts`; CLOSE counts changes that followed one another closely, PLACE the steps of an even grid."""

_ROOM = 4096
_BEYOND = 1e8  # b_c, as in the production march


class Run(NamedTuple):
    """State, tangent, clock and records; R = 1 + m rows."""

    rows: Array
    """The state and m tangent vectors, (R, 24)."""
    end: Array
    """The same at the end of a step that is being tried, (R, 24)."""
    k: Array
    """Stages, (s, R, 24)."""
    clock: Array
    counts: Index
    branches: Index
    """Of each mesh, (2,)."""
    keep: bool
    """Whether every step is recorded."""
    times: Array
    states: Array
    changes: Array
    """(τ, mesh, before, after, δ′) of each change of contact, (n, 5)."""
    used: Index
    """Rows of the records of steps and of changes in use, (2,)."""


def begin(tau: float, first_step: float, state: Array, tangent: Array, tableau: Tableau, keep: bool) -> Run:
    """Return a run at `tau` in `state` (24,) with `tangent` (24, m)."""
    rows = np.ascontiguousarray(np.vstack([state, tangent.T]))
    clock = np.array([tau, first_step, np.inf, -np.inf])
    stages = np.zeros((len(tableau.nodes), *rows.shape))
    room = _ROOM if keep else 1
    return Run(
        rows,
        rows.copy(),
        stages,
        clock,
        np.zeros(6, dtype=np.int64),
        np.zeros(2, dtype=np.int64),
        keep,
        np.empty(room),
        np.empty((room, 24)),
        np.empty((_ROOM, 5)),
        np.zeros(2, dtype=np.int64),
    )


@njit(error_model="numpy")
def full(run: Run) -> bool:
    """Return whether the records may not take another step with a change of both meshes."""
    return bool((run.keep and run.used[0] >= run.times.shape[0]) or run.used[1] + 2 > run.changes.shape[0])


@njit(error_model="numpy")
def note_step(run: Run, asked: float) -> None:
    """Count a step that was made and record where it ends; `asked` is the length that counts as its own."""
    run.counts[STEPS] += 1
    run.clock[SMALLEST] = min(run.clock[SMALLEST], asked)
    if run.keep:
        n = run.used[0]
        run.times[n] = run.clock[NOW]
        for i in range(24):
            run.states[n, i] = run.rows[0, i]
        run.used[0] = n + 1


@njit(error_model="numpy")
def note_change(run: Run, tau: float, mesh: int, before: int, after: int, rate: float) -> None:
    """Count and record a change of contact."""
    n = run.used[1]
    run.changes[n, 0], run.changes[n, 1], run.changes[n, 4] = tau, mesh, rate
    run.changes[n, 2], run.changes[n, 3] = before, after
    run.used[1] = n + 1
    run.counts[EVENTS] += 1


@njit(error_model="numpy")
def diverged(field: Field) -> bool:
    """Return whether the last evaluation was beyond every bound, or no number."""
    return bool(not abs(field.mesh[0, 0]) + abs(field.mesh[1, 0]) < _BEYOND)


@njit(error_model="numpy")
def side(delta: float, half: float) -> int:
    """Return the branch that (1) puts δ on."""
    return 1 if delta > half else (-1 if delta < -half else 0)


@njit(error_model="numpy")
def note_sides(run: Run, before: Array, sides: Index, h: float, field: Field) -> None:
    """Record changes of contact over a step whose contact was free, at the point where a line through δ passes."""
    for j in range(2):
        delta, half = field.mesh[j, 0], field.half_backlash[j]
        now = side(delta, half)
        if now != sides[j]:
            passed = (sides[j] if sides[j] != 0 else now) * half
            share = min(max((passed - before[j]) / (delta - before[j]), 0.0), 1.0)
            note_change(run, run.clock[NOW] - h * (1 - share), j, sides[j], now, field.mesh[j, 1])
            sides[j] = now
