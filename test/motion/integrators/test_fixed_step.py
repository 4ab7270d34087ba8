"""The fixed step against the same Runge-Kutta step in NumPy on the public right-hand side."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System, integrate
from seat_gear_dynamics.motion.integrators import EventLocating, FixedStep, integrate_time

Array = NDArray[np.float64]


def runge_kutta(system: System, tau: float, y: Array, h: float) -> Array:
    """(20)-(21) with the factor 1/6."""
    k1 = system.derivative(tau, y)
    k2 = system.derivative(tau + h / 2, y + h / 2 * k1)
    k3 = system.derivative(tau + h / 2, y + h / 2 * k2)
    k4 = system.derivative(tau + h, y + h * k3)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def test_its_steps_are_those_of_20_and_21(variant: GearTrain) -> None:
    system = System(variant).at(frequency=0.9, load=60.0)
    run = integrate_time(system, (2.0, 4.9), system.static_state(), method=FixedStep(0.1))
    assert run.times == pytest.approx(2.0 + 0.1 * np.arange(30), abs=1e-12)
    y = system.static_state()
    for tau, found in zip(run.times[:-1], run.states[1:], strict=True):
        y = runge_kutta(system, float(tau), y, 0.1)
        assert found == pytest.approx(y, rel=1e-11, abs=1e-11)  # rounding of some tens of steps


def test_it_is_the_production_march_where_its_step_is_the_marchs(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=100.0)
    march = integrate(system, transient=0, periods=5, target_steps=272, longest_step=10.0)
    period = march.period
    found = integrate_time(system, (0.0, 5 * period), system.static_state(), method=FixedStep(period / 272))
    assert found.counts.steps == 5 * 272
    assert found.state == pytest.approx(march.state, rel=1e-10, abs=1e-10)  # series and table differ by rounding


def test_a_span_is_divided_into_equal_steps_no_longer_than_asked(train: GearTrain) -> None:
    system = System(train)
    run = integrate_time(system, (0.0, 1.0), system.static_state(), method=FixedStep(0.3))
    assert run.times == pytest.approx([0, 0.25, 0.5, 0.75, 1.0], abs=1e-15)
    assert (run.counts.steps, run.counts.evaluations, run.counts.rejected) == (4, 17, 0)
    assert run.counts.smallest_step == 0.25


def test_changes_of_contact_are_seen_to_within_the_square_of_a_step(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=100.0)
    seen = integrate_time(system, (0.0, 30.0), system.static_state(), method=FixedStep(0.01)).changes
    located = integrate_time(system, (0.0, 30.0), system.static_state(), method=EventLocating(tolerance=1e-11)).changes
    assert len(located) > 4
    assert seen.meshes.tolist() == located.meshes.tolist()
    assert seen.after.tolist() == located.after.tolist()
    # A line through δ is off by h²·δ″/8 over δ′, both of the order of 1, and the motion itself by less.
    assert seen.times == pytest.approx(located.times, abs=1e-3)


@pytest.mark.parametrize("step", [0.0, -0.1, float("nan"), float("inf")])
def test_an_impossible_step_is_refused(step: float) -> None:
    with pytest.raises(ValueError, match="expected a finite number above 0"):
        FixedStep(step)
