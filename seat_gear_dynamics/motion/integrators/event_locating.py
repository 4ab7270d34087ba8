"""Steps that end where contact changes: each runs on held branches, so that its order survives impacts.

A step is made as if contact could not change, then searched for the first change (`contact_events`), made again up to
it (`landing`), and the next step begins on the other branch (Hairer, Nørsett & Wanner 1993, II.6; di Bernardo et al.
2008, 2.4, event-driven simulation).
"""

from dataclasses import dataclass
from math import ceil, pi
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.motion import kernel
from seat_gear_dynamics.motion.integrators import contact_events, field, landing, run, tableau
from seat_gear_dynamics.motion.integrators.checks import positive
from seat_gear_dynamics.motion.integrators.contact_events import far, first_change, look, resolution, settle
from seat_gear_dynamics.motion.integrators.field import FREE, Field, rates
from seat_gear_dynamics.motion.integrators.landing import change, land
from seat_gear_dynamics.motion.integrators.run import (
    CHATTERING,
    CLOSE,
    DIVERGED,
    EVALUATIONS,
    FINISHED,
    FULL,
    LAST_CHANGE,
    NEXT,
    NOW,
    PLACE,
    REFUSED,
    REJECTED,
    STEPS,
    Run,
    diverged,
    full,
    note_step,
)
from seat_gear_dynamics.motion.integrators.tableau import (
    DORMAND_PRINCE,
    RUNGE_KUTTA_4,
    Tableau,
    advance,
    scaled_error,
    step,
)
from seat_gear_dynamics.motion.revision import revision

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_FINEST = 1e-14  # tolerance: some 64 times the rounding of a component of size 1


@dataclass(frozen=True)
class EventLocating:
    """Dormand & Prince's 5(4) pair under a tolerance, or equal steps of order 4 or 5, cut at changes of contact.

    With `step` None the error that the pair estimates in a step is kept below `tolerance`·(1 + |component|) in every
    component, and no step is longer than `longest_step`. With `step` a grid of equal steps, at most that long, is kept
    and `tolerance` not looked at; `order` 4 then takes (20)-(21). A tangent is carried through changes of contact with
    its jump, in either reading of the damping; it has no part in the choice of the step.

    Handles both flanks of both meshes, several changes in a step, changes of both meshes at once, and grazing: what
    touches by less than rounding is no change. Limits: looks at eight parts of a step and the extrema between
    (`contact_events`), so that `longest_step` has to be short beside the excitation's period; by default, None, it is
    an eighth of the mesh period of P12 and at most 1. StepRefusedError where the tolerance takes steps below
    `smallest_step`, or where more than `most_close` changes follow one another within `closest` each.
    Source: Dormand & Prince 1980; Hairer, Nørsett & Wanner 1993, II.4 and II.6.
    """

    tolerance: float = 1e-9
    step: float | None = None
    order: int = 5
    longest_step: float | None = None
    smallest_step: float = 1e-10
    closest: float = 1e-9
    most_close: int = 32

    def __post_init__(self) -> None:
        for name in ("tolerance", "step", "longest_step", "smallest_step", "closest"):
            if getattr(self, name) is not None:
                positive(name, getattr(self, name))
        if self.tolerance < _FINEST:
            raise ValueError(f"The tolerance is {self.tolerance!r}, below what rounding allows, {_FINEST!r}; raise it.")
        if self.order not in (4, 5) or (self.order == 4 and self.step is None):
            raise ValueError(
                f"The order is {self.order!r} with step {self.step!r}, expected 5, or 4 with a step: "
                f"(20)-(21) has no estimate of its own error."
            )

    @property
    def tableau(self) -> Tableau:
        """The Runge-Kutta method of its steps."""
        return DORMAND_PRINCE if self.order == 5 else RUNGE_KUTTA_4

    def first_step(self, span: float) -> float:
        """Return the length that its first step tries over `span`."""
        return min(span, 0.05) if self.step is None else span / self._pieces(span)

    def march(self, run: Run, field: Field, start: float, end: float) -> int:
        """Take `run` from where it is to `end`, of a span from `start`; return how that ended."""
        turning = abs(field.excitation.frequency) / (2 * pi)
        longest = self.longest_step or min(1.0, 1 / (8 * turning) if turning else 1.0)
        tolerance, pieces = (self.tolerance, 0) if self.step is None else (0.0, self._pieces(end - start))
        limits = map(float, (tolerance, longest, self.smallest_step, self.closest))
        return int(_march(run, field, self.tableau, start, end, pieces, *limits, self.most_close))

    def _pieces(self, span: float) -> int:
        return ceil(span / (self.step or span) * (1 - 1e-12))


@njit(error_model="numpy")
def _evaluate(run: Run, field: Field, branches: Index) -> None:
    """Evaluate the first stage at where the run is."""
    rates(run.clock[NOW], run.rows, run.k[0], run.rows.shape[0], branches, field)
    run.counts[EVALUATIONS] += 1


@njit(error_model="numpy")
def _goal(run: Run, start: float, end: float, pieces: int, longest: float) -> float:
    """Return the τ that the next step is to reach: of the grid, or as far as the last error allows."""
    if pieces:
        place = run.counts[PLACE] + 1
        return end if place >= pieces else start + place * ((end - start) / pieces)
    h = min(run.clock[NEXT], longest)
    return end if h >= (end - run.clock[NOW]) * (1 - 1e-9) else run.clock[NOW] + h


@njit(error_model="numpy")
def _passes(run: Run, tableau: Tableau, tolerance: float, h: float) -> bool:
    """Judge a step by its error and choose the next one's length (Hairer, Nørsett & Wanner 1993, II.4)."""
    error = scaled_error(h, run.rows, run.k, run.end, tableau, tolerance)
    wanted = h * (min(5.0, max(0.2, 0.9 * error ** (-1.0 / tableau.order))) if error > 0.0 else 5.0)
    # A step that was short for another reason says little about how long one may be.
    run.clock[NEXT] = wanted if wanted < h else max(run.clock[NEXT], wanted)
    run.counts[REJECTED] += error > 1.0
    return bool(error <= 1.0)


@njit(error_model="numpy")
def _accept(run: Run, field: Field, tableau: Tableau, h: float, now: float) -> None:
    """Carry the tangent over a step that was made with the state alone, and go to its end."""
    if run.rows.shape[0] > 1:
        step(run.clock[NOW], h, run.rows, run.rows.shape[0], run.k, run.end, tableau, run.branches, field)
    advance(run.rows, run.rows.shape[0], run.k, run.end)
    run.clock[NOW] = now


@njit(error_model="numpy")
def _chatters(run: Run, closest: float, most_close: int) -> bool:
    """Note the time of a change; return whether too many have followed one another too closely."""
    close = run.clock[NOW] - run.clock[LAST_CHANGE] < closest
    run.counts[CLOSE] = run.counts[CLOSE] + 1 if close else 0
    run.clock[LAST_CHANGE] = run.clock[NOW]
    return bool(run.counts[CLOSE] > most_close)


def _entry(revision: int) -> Any:
    @njit(cache=True, error_model="numpy", nogil=True)
    def march(
        run: Run,
        field: Field,
        tableau: Tableau,
        start: float,
        end: float,
        pieces: int,
        tolerance: float,
        longest: float,
        smallest: float,
        closest: float,
        most_close: int,
    ) -> int:
        _ = revision
        here, there = np.empty((2, 2)), np.empty((2, 2))
        if run.counts[STEPS] == 0:
            _evaluate(run, field, np.full(2, FREE))
            settle(run.branches, resolution(run.rows, field), field)
            _evaluate(run, field, run.branches)
        look(run.branches, field, here)
        while run.clock[NOW] < end:
            if full(run):
                return FULL
            now = run.clock[NOW]
            goal = _goal(run, start, end, pieces, longest)
            h = goal - now
            if tolerance > 0.0 and goal < end and h < smallest:
                return REFUSED
            step(now, h, run.rows, 1, run.k, run.end, tableau, run.branches, field)
            run.counts[EVALUATIONS] += tableau.nodes.shape[0] - 1
            if diverged(field):
                return DIVERGED
            if tolerance > 0.0 and not _passes(run, tableau, tolerance, h):
                continue
            mesh, target, before, share = -1, 0, 0.0, 1.0
            look(run.branches, field, there)
            if not far(h, here, there, run.branches, field):
                mesh, target, before, share = first_change(now, h, run.rows, run.k, tableau, run.branches, field)
            if mesh < 0:
                _accept(run, field, tableau, h, goal)
                run.counts[PLACE] += 1
            else:
                length, landed = land(run, field, tableau, h, mesh, target, before, share)
                _accept(run, field, tableau, length, now + length)
                if landed:
                    change(run, field, mesh, target)
                    _evaluate(run, field, run.branches)
                    if _chatters(run, closest, most_close):
                        return CHATTERING
            look(run.branches, field, here)
            note_step(run, h)
        return FINISHED

    return march


_march = _entry(revision(kernel, field, tableau, run, contact_events, landing))
