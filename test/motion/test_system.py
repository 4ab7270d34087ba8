"""The equations of motion against potentials, modes and static balances worked out here in SI units."""

from collections.abc import Callable
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import eigh

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import STATE_NAMES, Inputs, March, OperatingPoint, System, load_system

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]


def masses(train: GearTrain) -> Array:
    """Return m, m, J/r² of every gear, kg, shape (12,)."""
    return np.array([m for g in train.gears for m in (g.mass, g.mass, g.inertia / g.base_radius**2)])


def supports(train: GearTrain) -> Array:
    """Return k_n, k_n, k_nt of every gear, N/m, shape (12,)."""
    found = []
    for g in train.gears:
        support = g.support_clearance_factor * g.support_stiffness
        found += [support, support, g.torsional_stiffness]
    return np.array(found)


def closing(train: GearTrain) -> Array:
    """Return ∂δ/∂q of both meshes from the digest's δ, shape (2, 12)."""
    directions = np.zeros((2, 12))
    for j, mesh in enumerate(train.meshes):
        phi = mesh.driver.pressure_angle
        directions[j, 6 * j : 6 * j + 6] = [-sin(phi), cos(phi), 1, sin(phi), -cos(phi), 1]
    return directions


def potential(system: System, tau: float, q: Array) -> float:
    """Return the potential energy, J, of coordinates q, m, under the operating point's load."""
    train = system.train
    energy = 0.5 * float(supports(train) @ q**2)
    forces = np.array(train.static_forces(system.operating_point.load)) * train.model.load_scale
    energy -= float(forces[0] * (q[2] + q[5]) + forces[1] * (q[8] + q[11]))
    for mesh, w, ratio in zip(train.meshes, closing(train), (1.0, 17 / 40), strict=True):
        phase = ratio * system.operating_point.frequency * tau / (2 * pi)
        delta = float(w @ q) - float(mesh.transmission_error.value(phase))
        beyond = max(abs(delta) - mesh.backlash / 2, 0.0)
        energy += 0.5 * float(mesh.stiffness.value(phase)) * beyond**2
    return energy


@pytest.fixture(scope="module")
def undamped(make_train: MakeTrain) -> GearTrain:
    """Damping off, error and stiffness variation on."""
    return make_train({"*damping_ratio": 0})


@pytest.fixture(scope="module")
def calm(make_train: MakeTrain, steady: Callable[..., GearTrain]) -> GearTrain:
    """Damping on, error and stiffness variation off: nothing moves it."""
    return steady(make_train({"*.error_amplitude": [0], "*.error_phase": [0]}))


@pytest.mark.parametrize("seed", range(8))
def test_forces_are_the_negative_gradient_of_one_potential(undamped: GearTrain, seed: int) -> None:
    rng = np.random.default_rng(seed)
    system = System(undamped, OperatingPoint(rng.uniform(-2, 2), rng.uniform(-300, 300)))
    tau, q = rng.uniform(0, 50), rng.normal(0, 2e-5, 12)
    length, omega = undamped.model.displacement_scale, undamped.derived_time_scale
    state = np.concatenate([q / length, np.zeros(12)])
    # The error moves δ′ but damping is off, so acceleration is the gradient alone.
    found = system.derivative(tau, state)[12:] * length * omega**2 * masses(undamped)
    step = 1e-9
    gradient = [(potential(system, tau, q + d) - potential(system, tau, q - d)) / (2 * step) for d in np.eye(12) * step]
    assert found == pytest.approx(-np.array(gradient), abs=2e-6 * float(np.abs(gradient).max()))


def test_kinematic_half_of_the_derivative_is_the_rates(train: GearTrain) -> None:
    state = np.random.default_rng(1).normal(size=24)
    assert System(train).derivative(3.0, state)[:12].tolist() == state[12:].tolist()


def test_damping_takes_energy_and_never_gives_any(calm: GearTrain, conservative: GearTrain) -> None:
    for seed in range(20):
        state = np.random.default_rng(seed).normal(size=24)
        with_damping, without = System(calm).derivative(0, state), System(conservative).derivative(0, state)
        power = float((with_damping - without)[12:] * masses(calm) @ state[12:])
        assert power < 0


def test_force_is_zero_inside_the_backlash_and_linear_beyond_it(conservative: GearTrain) -> None:
    system = System(conservative)
    half = 1e-5 / conservative.model.displacement_scale
    ratio = conservative.meshes[1].mean_stiffness / conservative.meshes[0].mean_stiffness
    for delta, expected in ((0.0, 0.0), (half, 0.0), (-half, 0.0), (half + 0.5, 0.5), (-half - 0.5, -0.5)):
        state = np.zeros(24)
        state[[2, 8]] = delta  # u1 and u3 close their meshes one to one
        assert system.mesh_forces(0.0, state) == pytest.approx([expected, ratio * expected], abs=1e-12)


# Loads from where the supports alone carry it to far beyond the studied range, on both flanks.
LOADS = st.floats(-4, 3.5).map(lambda exponent: 10**exponent)


@settings(max_examples=40)
@given(LOADS, st.sampled_from([-1.0, 0.0, 1.0]))
def test_static_state_is_at_rest_whatever_the_load(calm: GearTrain, load: float, side: float) -> None:
    system = System(calm, OperatingPoint(0.5, side * load))
    state = system.static_state()
    rest = system.derivative(0.0, state)
    assert np.abs(rest).max() <= 1e-12 * max(1.0, float(np.abs(state).max()))


@settings(max_examples=40)
@given(LOADS, st.sampled_from([-1.0, 1.0]))
def test_static_force_is_the_static_chain_times_the_load_scale_less_what_the_torsional_supports_carry(
    calm: GearTrain, load: float, side: float
) -> None:
    system = System(calm, OperatingPoint(0.5, side * load))
    found = system.mesh_forces(0.0, system.static_state()) * system.coefficients.force_unit
    for j, mesh in enumerate(system.train.meshes):
        # Springs in series and in parallel: F = (F_static·(1/k1t + 1/k2t) − b/2)/(1/k + w·K⁻¹·w), or nothing.
        static = abs(system.train.static_forces(load)[j]) * system.train.model.load_scale
        w, k = closing(system.train)[j], supports(system.train)
        turning = 1 / mesh.driver.torsional_stiffness + 1 / mesh.driven.torsional_stiffness
        force = (static * turning - mesh.backlash / 2) / (1 / mesh.mean_stiffness + float(w**2 @ (1 / k)))
        assert side * found[j] == pytest.approx(max(force, 0.0), rel=1e-6, abs=1e-9)


def test_static_force_is_exactly_the_scaled_chain_on_free_shafts(
    make_train: MakeTrain, steady: Callable[..., GearTrain]
) -> None:
    train = steady(make_train({"*.torsional_stiffness": 0, "*.error_amplitude": [0], "*.error_phase": [0]}))
    for load in (600.0, 1e-3, -5.0):
        system = System(train, OperatingPoint(0.5, load))
        found = system.mesh_forces(0, system.static_state()) * system.coefficients.force_unit
        expected = np.array(train.static_forces(load)) * train.model.load_scale
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("mesh", [0, 1], ids=["P12", "P34"])
@pytest.mark.parametrize("mode", range(6))
def test_small_oscillations_about_the_loaded_flank_are_the_modes_of_eigh(
    conservative: GearTrain, mesh: int, mode: int
) -> None:
    own = slice(6 * mesh, 6 * mesh + 6)
    w = closing(conservative)[mesh, own]
    stiffness = np.diag(supports(conservative)[own]) + conservative.meshes[mesh].mean_stiffness * np.outer(w, w)
    squares, shapes = eigh(stiffness, np.diag(masses(conservative)[own]))
    omega = np.sqrt(squares[mode]) / conservative.derived_time_scale
    march = March(conservative, load=600.0, target_steps=1024, longest_step=0.02)
    rest = march.state
    offset = np.zeros(24)
    offset[own] = 1e-3 * shapes[:, mode] / np.abs(shapes[:, mode]).max()
    march.state = rest + offset
    march.advance((0.0, Inputs(0.0, 600.0)), (40.0, Inputs(0.0, 600.0)))
    expected = np.concatenate(
        [offset[:12] * np.cos(omega * march.tau), -omega * offset[:12] * np.sin(omega * march.tau)]
    )
    assert march.state - rest == pytest.approx(expected, abs=1e-9)


def test_p34_meshes_at_17_fortieths_of_p12(train: GearTrain) -> None:
    assert System(train).mesh_rates == (1.0, 17 / 40)
    assert System(train).at(frequency=0.8).mesh_phases(2 * pi / 0.8 * 3) == pytest.approx(
        [0, 3 * 17 / 40 % 1], abs=1e-12
    )


def test_speed_and_frequency_are_two_ways_to_one_operating_point(train: GearTrain) -> None:
    by_speed = System(train).at(speed=train.speed(1.3), load=200)
    assert by_speed.operating_point.frequency == pytest.approx(1.3, rel=1e-14)
    assert by_speed.at(load=5.0).operating_point == OperatingPoint(by_speed.operating_point.frequency, 5.0)


def test_both_speed_and_frequency_are_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match=r"Both frequency 1\.0 and speed 140\.0 were given; give one of them\."):
        System(train).at(frequency=1.0, speed=140.0)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_operating_point_that_is_no_number_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match=r"frequency is .*, expected a finite number"):
        OperatingPoint(value, 600.0)
    with pytest.raises(ValueError, match=r"load is .*, expected a finite number"):
        OperatingPoint(0.5, value)


def test_state_of_another_shape_is_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match=r"shape \(12,\), expected \(24,\)"):
        System(train).derivative(0.0, np.zeros(12))


def test_state_names_say_the_order_of_the_state() -> None:
    assert STATE_NAMES[:3] == ("x1", "y1", "u1")
    assert STATE_NAMES[11:13] == ("u4", "x1'")
    assert len(set(STATE_NAMES)) == 24


def test_system_is_loaded_at_half_frequency_and_600_newton_metres() -> None:
    assert load_system().operating_point == OperatingPoint(0.5, 600.0)
