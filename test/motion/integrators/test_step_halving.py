"""The paper's step control (22) against the same rule in NumPy."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.motion.integrators import StepHalving, StepRefusedError, integrate_time

Array = NDArray[np.float64]


def runge_kutta(system: System, tau: float, y: Array, h: float) -> Array:
    k1 = system.derivative(tau, y)
    k2 = system.derivative(tau + h / 2, y + h / 2 * k1)
    k3 = system.derivative(tau + h / 2, y + h / 2 * k2)
    k4 = system.derivative(tau + h, y + h * k3)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def halved(system: System, tau: float, y: Array, method: StepHalving, h: float) -> tuple[float, Array, int]:
    """Return the step, state and number of halvings that (22) gives."""
    halvings = 0
    while True:
        whole = runge_kutta(system, tau, y, h)
        halves = runge_kutta(system, tau + h / 2, runge_kutta(system, tau, y, h / 2), h / 2)
        if np.abs(halves - whole).max() < method.tolerance:
            return h, halves + (halves - whole) / 15 * method.extrapolate, halvings
        h, halvings = h / 2, halvings + 1


@pytest.mark.parametrize("extrapolate", [False, True])
def test_its_steps_are_those_of_22(variant: GearTrain, extrapolate: bool) -> None:
    system = System(variant).at(frequency=0.9, load=60.0)
    method = StepHalving(step=0.3, tolerance=1e-6, extrapolate=extrapolate)
    end = 9.0
    run = integrate_time(system, (0.0, end), system.static_state(), method=method)
    tau, y, halvings, steps = 0.0, system.static_state(), 0, []
    for at, found in zip(run.times[1:], run.states[1:], strict=True):
        h, y, more = halved(system, tau, y, method, min(0.3, end - tau))
        tau, halvings = tau + h, halvings + more
        steps.append(h)
        assert at == pytest.approx(tau, abs=1e-12)
        assert found == pytest.approx(y, rel=1e-11, abs=1e-11)  # rounding of some tens of steps
    assert run.counts.rejected == halvings > 0
    assert run.counts.steps == len(steps)
    assert run.counts.smallest_step == pytest.approx(min(steps), rel=1e-12)
    # Three evaluations make y(h), eight each pair of half steps; the whole step's first stage is there already.
    expected = 1 + 3 * len(steps) + 8 * (len(steps) + halvings) + extrapolate * len(steps)
    assert run.counts.evaluations == expected


def test_a_step_below_the_smallest_is_refused_in_a_sentence(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=60.0)
    method = StepHalving(step=0.2, tolerance=1e-12, smallest_step=0.06)
    with pytest.raises(StepRefusedError, match=r"met the tolerance at tau 0 with frequency 0\.9 .* after 2 rejected"):
        integrate_time(system, (0.0, 5.0), system.static_state(), method=method)


def test_a_jump_of_the_force_may_be_more_than_halving_can_meet(contact_damped: GearTrain) -> None:
    # Across a jump of 0.01 in the acceleration y(h) and y(h/2) differ by about 0.01·h/6: 1e-10 takes steps below 1e-7.
    system = System(contact_damped).at(frequency=0.9, load=60.0)
    with pytest.raises(StepRefusedError, match="give a larger tolerance or a smaller smallest step"):
        integrate_time(system, (0.0, 40.0), system.static_state(), method=StepHalving(tolerance=1e-10))


def test_changes_of_contact_cost_it_steps(train: GearTrain) -> None:
    # The corner of f(δ) is found by halving alone: the shortest steps are around changes of contact.
    system = System(train).at(frequency=0.9, load=60.0)
    run = integrate_time(system, (0.0, 40.0), system.static_state(), method=StepHalving(tolerance=1e-9))
    assert run.counts.events > 5
    steps = np.diff(run.times)
    shortest = run.times[:-1][steps < steps.max() / 8]
    assert len(shortest)
    nearest = np.abs(shortest[:, None] - run.changes.times).min(axis=1)
    assert nearest.max() < 0.2  # each within one first step of a change


@pytest.mark.parametrize("name", ["step", "tolerance", "smallest_step"])
def test_impossible_options_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match=f"The {name} is -1.0, expected a finite number above 0"):
        StepHalving(**{name: -1.0})  # type: ignore[arg-type]
