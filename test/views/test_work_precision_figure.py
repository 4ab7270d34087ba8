"""The work-precision study and its diagram."""

from itertools import count
from math import isnan, nan
from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import OperatingPoint, System
from seat_gear_dynamics.studies.work_precision import (
    SOLVERS,
    Case,
    Measurement,
    Reference,
    WorkPrecision,
    reference,
    study,
)
from seat_gear_dynamics.views.figures.style import save
from seat_gear_dynamics.views.figures.work_precision import work_precision_figure


def made(train: GearTrain, *, timed: bool = True) -> WorkPrecision:
    """Return a study of an imagined solver of order four, and of one that never gets better."""
    cases = tuple(Case(name, System(train, OperatingPoint(0.5, 600.0)), 3) for name in ("smooth", "impacts"))
    measurements = []
    for case in cases:
        for n in (100, 1000, 10000):
            seconds = n * 1e-6 if timed else nan
            measurements.append(Measurement(case.name, "fourth", 1 / n, (100 / n) ** 4, n, seconds))
            measurements.append(Measurement(case.name, "stuck", 1 / n, 1e-2, n, seconds))
    return WorkPrecision(
        cases, (Reference(np.zeros(24), 1e-13, 0), Reference(np.zeros(24), 1e-10, 7)), tuple(measurements)
    )


def test_cost_lies_on_a_line_in_logarithms(train: GearTrain) -> None:
    found = made(train)
    assert found.cost("smooth", "fourth", 1e-2) == pytest.approx(100 * 100**0.25, rel=1e-12)
    assert found.cost("smooth", "fourth", 1e-6, seconds=True) == pytest.approx(1e-4 * 1e6**0.25, rel=1e-12)


@pytest.mark.parametrize(("solver", "error"), [("fourth", 10.0), ("fourth", 1e-12), ("stuck", 1e-3), ("none", 1e-3)])
def test_a_cost_that_was_not_measured_is_no_number(train: GearTrain, solver: str, error: float) -> None:
    assert isnan(made(train).cost("smooth", solver, error))


def test_errors_fall_with_cost_and_a_locating_integrator_goes_lowest_across_impacts(train: GearTrain) -> None:
    solvers = ("event-locating 5(4)", "Runge-Kutta 4", "step halving")
    found = study(train, solvers=solvers)
    assert all(isnan(m.seconds) for m in found.measurements)
    assert [end.changes > 0 for end in found.references] == [False, True, True]
    for case, end in zip(found.cases, found.references, strict=True):
        assert end.uncertainty < 1e-9
        best = {}
        for name in solvers:
            own = [m for m in found.measurements if (m.case, m.solver) == (case.name, name)]
            assert [m.setting for m in own] == list(SOLVERS[name][1])
            assert own[-1].error < own[0].error
            best[name] = min(m.error for m in own)
        if end.changes:
            assert min(best, key=lambda name: best[name]) == "event-locating 5(4)"


def test_solvers_from_outside_reach_the_reference(train: GearTrain) -> None:
    case = Case("short", System(train, OperatingPoint(0.9, 60.0)), 1)
    end = reference(case)
    assert end.changes > 0
    for name in ("SciPy RK45", "SciPy DOP853", "SciPy Radau", "SciPy LSODA"):
        state, evaluations = SOLVERS[name][0](case, 1e-8)()
        # Their tolerance is one of a step, and the corners of f(δ) are not theirs to know of.
        assert state == pytest.approx(end.state, abs=1e-4)
        assert evaluations > 50
    state, evaluations = SOLVERS["march"][0](case, 272)()
    assert state == pytest.approx(end.state, abs=1e-3)  # second order: (2π/0.9/272)² with factors of the order of 1
    assert evaluations == 4 * 272


def test_the_shortest_of_the_repeated_runs_counts(train: GearTrain) -> None:
    ticks = count()  # a clock that goes on by one at every look: each run lasts one
    found = study(train, solvers=("Runge-Kutta 4",), clock=lambda: float(next(ticks)), repeats=2)
    assert {m.seconds for m in found.measurements} == {1.0}
    assert next(ticks) == len(found.measurements) * 2 * 2


def test_an_unknown_solver_is_refused(train: GearTrain) -> None:
    with pytest.raises(KeyError, match="Euler"):
        study(train, solvers=("Euler",))


@pytest.mark.parametrize("timed", [True, False])
def test_the_diagram_has_an_axis_for_each_case_and_cost(train: GearTrain, timed: bool, tmp_path: Path) -> None:
    found = made(train, timed=timed)
    figure = work_precision_figure(found)
    assert len(figure.axes) == (4 if timed else 2)
    assert figure.axes[0].get_ylabel() == "error of the final state, b_c"
    labels = {axes.get_xlabel() for axes in figure.axes}
    assert labels == {"evaluations of the right-hand side"} | ({"time, ms"} if timed else set())
    line = figure.axes[0].get_lines()[0]
    assert line.get_label() == "fourth"
    assert line.get_xdata().tolist() == [100, 1000, 10000]
    path = tmp_path / "diagram.png"
    save(figure, path)
    assert path.read_bytes().startswith(b"\x89PNG")
