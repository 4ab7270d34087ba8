"""One step of the compiled march against the same Runge-Kutta step in NumPy on the public right-hand side."""

from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March, System
from seat_gear_dynamics.motion.march import DivergedError

Array = NDArray[np.float64]


def runge_kutta_step(system: System, tau: float, state: Array, h: float) -> Array:
    k1 = system.derivative(tau, state)
    k2 = system.derivative(tau + h / 2, state + h / 2 * k1)
    k3 = system.derivative(tau + h / 2, state + h / 2 * k2)
    k4 = system.derivative(tau + h, state + h * k3)
    return state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def step_length(march: March, frequency: float, longest: float) -> float:
    """Return the step at a steady frequency: the first halving of the period's grid that is short enough."""
    h = 2 * pi / abs(frequency) / march.steps_per_period
    while h > longest:
        h /= 2
    return h


@pytest.mark.parametrize("frequency", [1.7, 0.9, 0.41, 0.1, 0.02, -0.05, -0.6, -2.3])
@pytest.mark.parametrize("seed", range(4))
def test_a_step_at_any_table_phase_is_the_numpy_step_to_rounding(train: GearTrain, frequency: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    load, longest = float(rng.uniform(-100, 600)), 0.1
    march = March(train, load=load, longest_step=longest)
    inputs, h = Inputs(frequency, load), step_length(march, frequency, longest)
    before = int(rng.integers(0, 3000))  # through a good part of the 40 periods that both meshes take to repeat
    march.advance((0.0, inputs), ((before - 0.5) * h, inputs))
    assert march.tau == pytest.approx(before * h, rel=1e-12, abs=1e-12)
    state = rng.normal(size=24)  # in and out of the backlash of ±1
    march.state = state
    march.advance((march.tau, inputs), (march.tau + h / 2, inputs))
    expected = runge_kutta_step(System(train).at(frequency=frequency, load=load), before * h, state, h)
    assert (march.state - state) / h == pytest.approx((expected - state) / h, rel=1e-10, abs=1e-12 * 50)


@pytest.mark.parametrize("seed", range(4))
def test_a_creeping_step_is_the_numpy_step_at_a_held_phase(train: GearTrain, seed: int) -> None:
    state = np.random.default_rng(seed).normal(size=24)
    march = March(train, load=50.0)
    march.state = state
    march.advance((0.0, Inputs(0.0, 50.0)), (0.05, Inputs(0.0, 50.0)))
    expected = runge_kutta_step(System(train).at(frequency=0.0, load=50.0), 0.0, state, 0.1)
    assert march.tau == 0.1
    assert march.state == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_mesh_values_are_those_of_the_public_right_hand_side(train: GearTrain) -> None:
    system = System(train).at(frequency=0.7, load=40.0)
    march = March(train, load=40.0)
    inputs = Inputs(0.7, 40.0)
    march.advance((0.0, inputs), (100.0, inputs))
    delta, rate = system.deflections(march.tau, march.state)
    found = march.meshes(0.7)
    assert found[:, 0] == pytest.approx(delta, rel=1e-9, abs=1e-9)
    assert found[:, 1] == pytest.approx(rate, rel=1e-9, abs=1e-9)
    assert found[:, 2] == pytest.approx(system.mesh_forces(march.tau, march.state), rel=1e-9, abs=1e-9)
    assert found[:, 3].tolist() == [float(abs(d) > 1) for d in delta]


@pytest.mark.parametrize("start", [1e9, float("nan"), float("inf")])
def test_a_motion_out_of_bounds_is_refused_in_one_sentence_with_a_remedy(train: GearTrain, start: float) -> None:
    march = March(train, load=600.0)
    march.state = np.full(24, start)
    with pytest.raises(DivergedError) as caught:
        march.advance((0.0, Inputs(0.5, 600.0)), (10.0, Inputs(0.5, 600.0)))
    message = str(caught.value)
    assert message.startswith("The motion diverged at tau 0 with frequency 0.5 and load 600 N·m: ")
    assert message.endswith("restart, or change them.")
    assert "\n" not in message


def test_restart_after_divergence_gives_a_fresh_motion(train: GearTrain) -> None:
    march, fresh, inputs = March(train, load=600.0), March(train, load=600.0), Inputs(0.5, 600.0)
    march.state = np.full(24, float("nan"))
    with pytest.raises(DivergedError):
        march.advance((0.0, inputs), (10.0, inputs))
    march.restart(600.0)
    for each in (march, fresh):
        each.advance((0.0, inputs), (20.0, inputs))
    assert march.state.tolist() == fresh.state.tolist()


def test_reading_or_setting_the_state_shares_no_memory_with_the_march(train: GearTrain) -> None:
    march, own = March(train, load=600.0), np.zeros(24)
    march.state = own
    own[0] = 7.0
    march.state[1] = 7.0
    assert march.state.tolist() == [0.0] * 24
