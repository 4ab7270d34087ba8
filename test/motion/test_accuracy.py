"""How exact the march is: energy, order of convergence, and an outside solver."""

from itertools import pairwise
from math import log2, pi

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March, System, integrate

Array = NDArray[np.float64]


def energy(train: GearTrain, state: Array, load: float) -> float:
    """Return kinetic plus potential energy of a steady, error-free train, J."""
    length, omega = train.model.displacement_scale, train.derived_time_scale
    q, v = state[:12] * length, state[12:] * length * omega
    total = 0.0
    for n, gear in enumerate(train.gears):
        own = slice(3 * n, 3 * n + 3)
        mass = np.array([gear.mass, gear.mass, gear.equivalent_mass])
        support = np.array([gear.support_stiffness, gear.support_stiffness, gear.torsional_stiffness])
        total += 0.5 * float(mass @ v[own] ** 2 + support @ q[own] ** 2)
    deltas, _ = System(train).deflections(0.0, state)
    for j, mesh in enumerate(train.meshes):
        beyond = max(abs(deltas[j]) * length - mesh.backlash / 2, 0.0)
        total += 0.5 * mesh.mean_model_stiffness * beyond**2
        force = train.static_forces(load)[j] * train.model.load_scale
        total -= force * float(q[6 * j + 2] + q[6 * j + 5])
    return total


def drift(train: GearTrain, load: float, disturbance: float, target_steps: int) -> tuple[float, bool]:
    """Return the relative energy drift over 100 periods after a disturbance, and whether teeth separated."""
    march = March(train, load=load, target_steps=target_steps)
    rest = energy(train, march.state, load)
    start = march.state
    start[[2, 8]] += disturbance
    march.state = start
    begin = energy(train, start, load)
    inputs = Inputs(1.0, load)
    windows = march.advance((0.0, inputs), (200 * pi, inputs))
    return abs(energy(train, march.state, load) - begin) / (begin - rest), any(w.separated > 0 for w in windows)


def test_energy_is_kept_to_1e_9_over_100_periods_in_contact(conservative: GearTrain) -> None:
    lost, separated = drift(conservative, 600.0, 0.05, 2048)
    assert not separated
    assert lost < 1e-9


def test_energy_is_kept_across_impacts_as_far_as_a_kinked_force_allows(conservative: GearTrain) -> None:
    # f(δ) has corners, across which a step's energy error falls more slowly than on smooth arcs.
    lost, separated = drift(conservative, 20.0, 3.0, 4096)
    assert separated
    assert lost < 1e-5


def errors(
    train: GearTrain, load: float, periods: int, steps: tuple[int, ...], reference: int
) -> tuple[list[float], float]:
    """Return the error of the final state for each step count, and the share of time out of contact."""
    system = System(train).at(frequency=0.9, load=load)

    def final(target: int) -> Array:
        return integrate(system, transient=0, periods=periods, target_steps=target, longest_step=10.0).state

    exact = final(reference)
    loss = integrate(system, transient=0, periods=periods, target_steps=reference).windows[0].contact_loss
    return [float(np.abs(final(n) - exact).max()) for n in steps], loss


def test_convergence_on_smooth_arcs_is_of_fourth_order(train: GearTrain) -> None:
    found, loss = errors(train, 3000.0, 6, (136, 272, 544), 2176)
    assert loss == 0
    orders = [log2(a / b) for a, b in pairwise(found)]
    assert orders == pytest.approx([4.0, 4.0], abs=0.25)


def test_convergence_across_impacts_is_faster_than_first_order(train: GearTrain) -> None:
    # Single halvings scatter, as the corner falls somewhere in a step; the order is the slope over four of them.
    steps = (68, 136, 272, 544, 1088)
    found, loss = errors(train, 60.0, 6, steps, 4352)
    assert loss > 0.1
    order = -np.polyfit(np.log2(steps), np.log2(found), 1)[0]
    assert 1.0 < order < 4.5


def compared(system: System, periods: int) -> float:
    """Return the largest difference from DOP853 after `periods`, relative to how far the state is from rest."""
    end = periods * 2 * pi / abs(system.operating_point.frequency)
    outside = solve_ivp(
        system.derivative, (0, end), system.static_state(), method="DOP853", rtol=1e-11, atol=1e-13, max_step=2.0
    )
    state = integrate(system, transient=periods - 1, periods=1, target_steps=4096).state
    moved = np.abs(outside.y[:, -1] - system.static_state()).max()
    return float(np.abs(state - outside.y[:, -1]).max() / moved)


def test_march_agrees_with_dop853_after_50_periods_at_600_newton_metres(train: GearTrain) -> None:
    assert compared(System(train).at(frequency=0.5, load=600.0), 50) < 1e-6


def test_march_agrees_with_dop853_running_backward(train: GearTrain) -> None:
    assert compared(System(train).at(frequency=-0.7, load=600.0), 4) < 1e-6


def test_march_agrees_with_dop853_across_impacts(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=100.0)
    assert integrate(system, transient=0, periods=5).windows[0].contact_loss > 0.1
    assert compared(system, 5) < 1e-4
