"""The order of each integrator on smooth arcs and across changes of contact, as docs/integrators.md tables it."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.motion.integrators import EventLocating, FixedStep, Method, StepHalving, integrate_time

Array = NDArray[np.float64]
STEPS = 0.4 / 2.0 ** np.arange(5)
SPAN = (0.0, 20.0)

# A tolerance that every difference meets takes the halving out: what is left is its state from two half steps.
BY_STEP: dict[str, Callable[[float], Method]] = {
    "fixed": FixedStep,
    "half steps": lambda h: StepHalving(step=h, tolerance=1e9),
    "extrapolated": lambda h: StepHalving(step=h, tolerance=1e9, extrapolate=True),
    "locating 4": lambda h: EventLocating(step=h, order=4),
    "locating 5": lambda h: EventLocating(step=h),
}


def starts(system: System, spread: float, count: int) -> list[Array]:
    rng = np.random.default_rng(7)
    return [system.static_state() + rng.normal(0, spread, 24) for _ in range(count)]


def orders(system: System, spread: float, count: int) -> tuple[dict[str, float], int]:
    """Return the slope of the mean logarithmic error over the logarithmic step, and the changes of contact in all.

    Where in a step a change of contact falls scatters an error; over many motions its mean has a slope.
    """
    errors, changes = {name: np.zeros(len(STEPS)) for name in BY_STEP}, 0
    for state in starts(system, spread, count):
        exact = integrate_time(system, SPAN, state, method=EventLocating(tolerance=1e-13), every_step=False)
        changes += exact.counts.events
        for name, method in BY_STEP.items():
            for n, h in enumerate(STEPS):
                found = integrate_time(system, SPAN, state, method=method(float(h)), every_step=False)
                errors[name][n] += np.log(np.abs(found.state - exact.state).max()) / count
    return {name: float(np.polyfit(np.log(STEPS), e, 1)[0]) for name, e in errors.items()}, changes


def test_every_integrator_has_its_order_on_smooth_arcs(train: GearTrain) -> None:
    found, changes = orders(System(train).at(frequency=0.9, load=3000.0), 0.02, 4)
    assert changes == 0
    # The next order's share of the error at the longest step, 0.4 with modes of up to 1.3 rad per τ.
    expected = {"fixed": 4, "half steps": 4, "extrapolated": 5, "locating 4": 4, "locating 5": 5}
    assert found == pytest.approx(expected, abs=0.2)


def test_a_kinked_force_leaves_second_order_but_to_a_locating_integrator(train: GearTrain) -> None:
    found, changes = orders(System(train).at(frequency=0.9, load=60.0), 0.5, 20)
    assert changes > 100
    # Some 200 changes at random places in their steps: their mean scatters by about a tenth of an order.
    expected = {"fixed": 2, "half steps": 2, "extrapolated": 2, "locating 4": 4, "locating 5": 5}
    assert found == pytest.approx(expected, abs=0.4)


def test_a_jump_of_the_force_leaves_first_order_but_to_a_locating_integrator(contact_damped: GearTrain) -> None:
    found, changes = orders(System(contact_damped).at(frequency=0.9, load=60.0), 0.5, 20)
    assert changes > 100
    # As above; at the two longest steps the fourth order is not reached yet, which takes 0.4 from its slope.
    expected = {"fixed": 1, "half steps": 1, "extrapolated": 1, "locating 4": 4, "locating 5": 5}
    assert found == pytest.approx(expected, abs=0.6)


def test_an_error_falls_with_the_tolerance_in_proportion(train: GearTrain) -> None:
    # Error per step is controlled with order five: the motion's error goes as tolerance^(4/5) or better.
    system, tolerances = System(train).at(frequency=0.9, load=60.0), 10.0 ** -np.arange(5, 12)
    logs = np.zeros(len(tolerances))
    for state in starts(system, 0.5, 8):
        exact = integrate_time(system, SPAN, state, method=EventLocating(tolerance=1e-13)).state
        logs += [
            np.log(np.abs(integrate_time(system, SPAN, state, method=EventLocating(tolerance=t)).state - exact).max())
            for t in tolerances
        ]
    assert np.polyfit(np.log(tolerances), logs / 8, 1)[0] == pytest.approx(0.9, abs=0.15)
