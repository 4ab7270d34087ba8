"""How much each integrator pays for an error: the study behind the choice of one (docs/integrators.md)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, log, nan, pi

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March, OperatingPoint, System
from seat_gear_dynamics.motion.integrators import (
    EventLocating,
    FixedStep,
    Method,
    StepHalving,
    integrate_time,
    right_hand_side,
)
from seat_gear_dynamics.plotting import Plottable

Array = NDArray[np.float64]

STEPS = tuple(1.6 / 2**n for n in range(10))
TOLERANCES = tuple(10.0**-n for n in range(1, 13))
MARCH_STEPS = tuple(17.0 * 2**n for n in range(8))
"""Steps in a mesh period of P12 for the production march: a multiple of 17, to which its grid is tied."""


@dataclass(frozen=True)
class Case:
    """One motion to be integrated: whole mesh periods of P12 from rest at static deflection."""

    name: str
    system: System
    periods: int

    @property
    def end(self) -> float:
        """Length of the motion, units of τ."""
        return self.periods * 2 * pi / abs(self.system.operating_point.frequency)


@dataclass(frozen=True)
class Reference:
    """The converged end of a case."""

    state: Array
    """(24,)."""
    uncertainty: float
    """Largest difference from the end found by another method with steps of its own, b_c: errors below are noise."""
    changes: int
    """Changes of contact on the way."""


@dataclass(frozen=True)
class Measurement:
    """One run of one integrator."""

    case: str
    solver: str
    setting: float
    """Step in τ, steps in a period, or tolerance."""
    error: float
    """Largest component of the final state's error, b_c and b_c per τ."""
    evaluations: int
    """Right-hand sides, a solver's own Jacobian by differences included."""
    seconds: float
    """By the clock given, NaN where none was."""


@dataclass(frozen=True)
class WorkPrecision(Plottable, figure="work_precision:plot_work_precision", table="studies:work_precision_table"):
    """The study's result."""

    cases: tuple[Case, ...]
    references: tuple[Reference, ...]
    measurements: tuple[Measurement, ...]

    def cost(self, case: str, solver: str, error: float, *, seconds: bool = False) -> float:
        """Return the evaluations (or seconds) that `solver` needs for `error` in `case`, on a line in logarithms.

        NaN where it was not measured on both sides of `error`. A line between measurements is a rough guide where
        errors scatter, as they do across impacts.
        """
        own = [m for m in self.measurements if (m.case, m.solver) == (case, solver) and m.error > 0]
        points = sorted((m.seconds if seconds else float(m.evaluations), m.error) for m in own)
        for (cost0, error0), (cost1, error1) in pairwise(points):
            if error1 <= error < error0:
                share = log(error0 / error) / log(error0 / error1)
                return float(cost0 * (cost1 / cost0) ** share)
        return nan


Run = Callable[[], tuple[Array, int]]
"""Integrates a case; returns the final state and the right-hand sides that it took."""
Solver = Callable[[Case, float], Run]
"""Prepares a case at a setting."""


def _own(make: Callable[[float], Method]) -> Solver:
    def prepare(case: Case, setting: float) -> Run:
        method, start = make(setting), case.system.static_state()

        def run() -> tuple[Array, int]:
            found = integrate_time(case.system, (0.0, case.end), start, method=method, every_step=False)
            return found.state, found.counts.evaluations

        return run

    return prepare


def _march(case: Case, setting: float) -> Run:
    point = case.system.operating_point
    march = March(case.system.train, load=point.load, target_steps=int(setting), longest_step=inf)
    inputs, steps = Inputs(point.frequency, point.load), case.periods * march.steps_per_period

    def run() -> tuple[Array, int]:
        march.restart(point.load)
        march.advance((0.0, inputs), (case.end * (1 - 0.5 / steps), inputs))
        return march.state, 4 * steps

    return run


def _scipy(name: str) -> Solver:
    def prepare(case: Case, setting: float) -> Run:
        derivative, start = right_hand_side(case.system), case.system.static_state()

        def run() -> tuple[Array, int]:
            calls = 0

            def counted(t: float, state: ArrayLike) -> Array:
                nonlocal calls
                calls += 1
                return derivative(t, state)

            found = solve_ivp(counted, (0.0, case.end), start, method=name, rtol=setting, atol=setting)
            return np.asarray(found.y[:, -1]), calls

        return run

    return prepare


SOLVERS: dict[str, tuple[Solver, Sequence[float]]] = {
    "event-locating 5(4)": (_own(lambda x: EventLocating(tolerance=x)), TOLERANCES),
    "event-locating 4": (_own(lambda x: EventLocating(step=x, order=4)), STEPS),
    "march": (_march, MARCH_STEPS),
    "Runge-Kutta 4": (_own(FixedStep), STEPS),
    "step halving": (_own(lambda x: StepHalving(tolerance=x, smallest_step=1e-12)), TOLERANCES),
    "SciPy RK45": (_scipy("RK45"), TOLERANCES),
    "SciPy DOP853": (_scipy("DOP853"), TOLERANCES),
    "SciPy Radau": (_scipy("Radau"), TOLERANCES[:9]),
    "SciPy LSODA": (_scipy("LSODA"), TOLERANCES),
}
"""Each solver with its settings; those of SciPy on the compiled right-hand side, one tolerance for rtol and atol."""


def cases(train: GearTrain) -> tuple[Case, ...]:
    """Return three motions of `train`: always in contact, rattling, and rattling with damping in contact only.

    That the first one keeps contact and the others lose it holds for trains like the packaged one; `Reference.changes`
    says what happened.
    """
    jumping = replace(train, variant=replace(train.variant, damping_in_contact_only=True))
    return (
        Case("in contact", System(train, OperatingPoint(0.5, 3000.0)), 5),
        Case("impacts", System(train, OperatingPoint(1.6, 400.0)), 8),
        Case("impacts, damping in contact only", System(jumping, OperatingPoint(1.6, 400.0)), 8),
    )


def reference(case: Case) -> Reference:
    """Return the end of `case` by event-locating steps at the finest tolerance, against equal ones of 0.005 in τ."""
    span, start = (0.0, case.end), case.system.static_state()
    fine = integrate_time(case.system, span, start, method=EventLocating(tolerance=1e-13), every_step=False)
    even = integrate_time(case.system, span, start, method=EventLocating(step=0.005), every_step=False)
    return Reference(fine.state, float(np.abs(fine.state - even.state).max()), len(fine.changes))


def study(
    train: GearTrain,
    *,
    solvers: Sequence[str] = tuple(SOLVERS),
    clock: Callable[[], float] | None = None,
    repeats: int = 3,
    progress: Callable[[str], None] | None = None,
) -> WorkPrecision:
    """Run every named solver at every setting through every case.

    `clock` gives seconds, of the wall, or of the processor where others share the machine; the shortest of `repeats`
    runs counts, as the one that was disturbed least, after one run that compiles. Without it each runs once. What is
    made once for many runs is not in the time: the march's tables, SciPy's right-hand side. `progress` gets a line for
    each solver and case. Raises KeyError for a solver that is not in SOLVERS.
    """
    chosen = cases(train)
    references = tuple(map(reference, chosen))
    found: list[Measurement] = []
    for case, end in zip(chosen, references, strict=True):
        for name in solvers:
            if progress is not None:
                progress(f"{case.name}: {name}")
            solver, settings = SOLVERS[name]
            found += [_measured(case, end, name, solver, s, clock, repeats) for s in settings]
    return WorkPrecision(chosen, references, tuple(found))


def _measured(
    case: Case,
    end: Reference,
    name: str,
    solver: Solver,
    setting: float,
    clock: Callable[[], float] | None,
    repeats: int,
) -> Measurement:
    run, times = solver(case, setting), [nan]
    state, evaluations = run()
    if clock is not None:
        times = []
        for _ in range(repeats):
            begin = clock()
            run()
            times.append(clock() - begin)
    error = float(np.abs(state - end.state).max())
    return Measurement(case.name, name, setting, error, evaluations, min(times))
