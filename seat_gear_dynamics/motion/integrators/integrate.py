"""The one call for every integrator."""

from collections.abc import Callable
from math import isfinite
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.motion.integrators import run as ways
from seat_gear_dynamics.motion.integrators.event_locating import EventLocating
from seat_gear_dynamics.motion.integrators.field import Field, field_of
from seat_gear_dynamics.motion.integrators.fixed_step import FixedStep
from seat_gear_dynamics.motion.integrators.run import Run, begin
from seat_gear_dynamics.motion.integrators.step_halving import StepHalving
from seat_gear_dynamics.motion.integrators.tableau import Tableau
from seat_gear_dynamics.motion.integrators.trajectory import ContactChanges, Counts, StepRefusedError, Trajectory
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.motion.system import System

Array = NDArray[np.float64]


class Method(Protocol):
    """What an integrator is made of."""

    @property
    def tableau(self) -> Tableau:
        """The Runge-Kutta method of its steps."""

    def first_step(self, span: float) -> float:
        """Return the length that its first step tries over `span`, units of τ."""

    def march(self, run: Run, field: Field, start: float, end: float) -> int:
        """Take `run` to `end`, of a span from `start`, or until its records are full; return how that ended."""


METHODS: dict[str, Callable[..., Method]] = {
    "runge-kutta": FixedStep,
    "step-halving": StepHalving,
    "event-locating": EventLocating,
}
"""Every integrator by name; called without arguments it has its default options."""


def integrate_time(
    system: System,
    span: tuple[float, float],
    state: ArrayLike,
    *,
    method: Method | str = "event-locating",
    tangent: ArrayLike | None = None,
    every_step: bool = True,
) -> Trajectory:
    """Integrate `system` at its operating point over `span` (τ from, to) from `state`, (24,).

    `method` is an integrator with its options, or a name of METHODS. `tangent`, (24, m), is carried along the motion
    by its linearised equations, neither normalised nor turned. Without `every_step` the trajectory has its two ends
    only, but all changes of contact. The excitation is summed from its Fourier series at every evaluation, so no step
    is tied to the mesh period; at frequency 0 it stands still.

    Raises ValueError, a sentence, for impossible arguments, DivergedError where the solution blows up and
    StepRefusedError where a method's limits are met. Limits: forward in time only (a drive may turn backward);
    constant drive, unlike `March`; phase loses digits as τ grows, 1e-16·Ω·τ of it.
    """
    start, end = _checked_span(span)
    first, directions = _checked(state, (24,), "state"), _checked_tangent(tangent)
    chosen = METHODS[_known(method)]() if isinstance(method, str) else method
    field = field_of(system)
    run = begin(start, chosen.first_step(end - start), first, directions, chosen.tableau, every_step)
    times, states, changes = [np.array([start])], [first[None]], [np.empty((0, 5))]
    code = ways.FULL
    while code == ways.FULL:
        run.used[:] = 0
        code = chosen.march(run, field, start, end)
        times.append(run.times[: run.used[0]].copy())
        states.append(run.states[: run.used[0]].copy())
        changes.append(run.changes[: run.used[1]].copy())
    if code != ways.FINISHED:
        raise _refusal(code, run, system)
    if not every_step:
        times.append(np.array([end]))
        states.append(run.rows[:1].copy())
    return _trajectory(run, np.concatenate(times), np.concatenate(states), np.concatenate(changes))


def _trajectory(run: Run, times: Array, states: Array, changes: Array) -> Trajectory:
    found = ContactChanges(
        changes[:, 0],
        changes[:, 1].astype(np.int64),
        changes[:, 2].astype(np.int64),
        changes[:, 3].astype(np.int64),
        changes[:, 4],
    )
    contact = run.branches.copy()
    for j in range(2):
        own = np.flatnonzero(found.meshes == j)
        contact[j] = found.before[own[0]] if len(own) else run.branches[j]
    steps, evaluations, rejected, events = (int(n) for n in run.counts[: ways.EVENTS + 1])
    counts = Counts(steps, evaluations, rejected, events, float(run.clock[ways.SMALLEST]))
    return Trajectory(times, states, run.rows[1:].T.copy(), contact, found, counts)


def _refusal(code: int, run: Run, system: System) -> ArithmeticError:
    """Return the error of an integration that did not finish."""
    point = system.operating_point
    where = f"at tau {run.clock[ways.NOW]:.6g} with frequency {point.frequency:.6g} and load {point.load:.6g} N·m"
    if code == ways.DIVERGED:
        return DivergedError(
            f"The motion diverged {where}: the parameters are unstable there (parametric resonance), damping is too "
            f"low, or the step is too long for the method; change them."
        )
    if code == ways.REFUSED:
        return StepRefusedError(
            f"No step down to the smallest allowed met the tolerance {where}, after "
            f"{run.counts[ways.REJECTED]} rejected ones; give a larger tolerance or a smaller smallest step."
        )
    return StepRefusedError(
        f"Contact chatters {where}: {run.counts[ways.CLOSE]} changes followed one another too closely; "
        f"raise most_close, or look whether teeth rest on a flank without load."
    )


def _known(name: str) -> str:
    if name not in METHODS:
        raise ValueError(f"The method is {name!r}, expected one of {', '.join(METHODS)}, or an integrator's options.")
    return name


def _checked_span(span: tuple[float, float]) -> tuple[float, float]:
    start, end = map(float, span)
    if not (isfinite(start) and isfinite(end) and start < end):
        raise ValueError(f"The span is from {start!r} to {end!r}, expected two finite times, the second one later.")
    return start, end


def _checked(values: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    found = np.array(values, dtype=float)
    if found.shape != shape:
        raise ValueError(f"The {name} has shape {found.shape}, expected {shape}.")
    if not np.isfinite(found).all():
        raise ValueError(f"The {name} holds {int((~np.isfinite(found)).sum())} values that are no finite numbers.")
    return found


def _checked_tangent(tangent: ArrayLike | None) -> Array:
    if tangent is None:
        return np.empty((24, 0))
    columns = np.atleast_2d(np.asarray(tangent, dtype=float)).shape[-1]
    return _checked(tangent, (24, columns), "tangent")
