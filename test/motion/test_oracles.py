"""Laws that the equations of motion and their integration must obey, each worked out here in another way.

Beside these stand, elsewhere: the gradient and the modes of the pairs apart (test_system), energy of the production
march (test_accuracy), every variant against DOP853 (test_variants, integrators/test_integrate), propagators against
differences of motions column by column (integrators/test_propagate).
"""

from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import trapezoid
from scipy.linalg import block_diag, eigh

from seat_gear_dynamics.gears import GearTrain, Variant
from seat_gear_dynamics.motion import System, integrate
from seat_gear_dynamics.motion.integrators import (
    EventLocating,
    FixedStep,
    growths,
    integrate_time,
    propagators,
)

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
MakeTrain = Callable[..., GearTrain]
Steady = Callable[[GearTrain], GearTrain]
STEEL_SHAFT = 2.6e4  # N·m/rad: 16 mm by 20 mm
EXACT = EventLocating(tolerance=1e-13)


def masses(train: GearTrain) -> Array:
    """Return m, m, J/r² of every gear, kg, (12,)."""
    return np.array([m for g in train.gears for m in (g.mass, g.mass, g.inertia / g.base_radius**2)])


def supports(train: GearTrain) -> Array:
    """Return k_n, k_n, k_nt of every gear, N/m, (12,)."""
    stiffness = []
    for g in train.gears:
        stiffness += [g.support_clearance_factor * g.support_stiffness] * 2 + [g.torsional_stiffness]
    return np.array(stiffness)


def closing(train: GearTrain) -> Array:
    """Return ∂δ/∂q of both meshes, (2, 12)."""
    rows = []
    for mesh in train.meshes:
        s, c = sin(mesh.driver.pressure_angle), cos(mesh.driver.pressure_angle)
        rows.append([[-s, c, 1, s, -c, 1]])
    return np.asarray(block_diag(*rows), dtype=float)


def torques(train: GearTrain, load: float) -> Array:
    """Return the given torques over the base radii, N, on u1..u4, (4,): the outer ones alone where a shaft couples."""
    first, second = (force * train.model.load_scale for force in train.static_forces(load))
    inner = 0.0 if train.shaft.couples else 1.0
    return np.array([first, inner * first, inner * second, second])


def errors(system: System, tau: float) -> Array:
    """Return the mesh errors with runout, m, (2,)."""
    turns = system.operating_point.frequency * tau / (2 * pi)
    found = []
    for mesh, ratio in zip(system.train.meshes, (1.0, 17 / 40), strict=True):
        error = float(mesh.transmission_error.value(ratio * turns))
        for gear in (mesh.driver, mesh.driven):
            error += gear.eccentricity * sin(2 * pi * ratio * turns / gear.teeth + gear.eccentricity_phase)
        found.append(error)
    return np.array(found)


def potential(system: System, tau: float, q: Complex) -> complex:
    """Return the potential energy, J, of coordinates q, m; analytic but at the flanks, so that q may be complex."""
    train = system.train
    energy = 0.5 * (supports(train) @ q**2) - torques(train, system.operating_point.load) @ q[2::3]
    _, s2, s3, _ = train.gears
    energy += 0.5 * train.shaft.stiffness * (q[5] / s2.base_radius + q[8] / s3.base_radius) ** 2
    deltas = closing(train) @ q - errors(system, tau)
    for mesh, delta, ratio in zip(train.meshes, deltas, (1.0, 17 / 40), strict=True):
        stiffness = mesh.stiffness.value(ratio * system.operating_point.frequency * tau / (2 * pi))
        beyond = max(abs(delta.real) - mesh.backlash / 2, 0.0) * np.sign(delta.real) + 1j * delta.imag
        energy += 0.5 * float(stiffness) * (beyond**2 if abs(delta.real) > mesh.backlash / 2 else 0.0)
    return complex(energy)


def energy(system: System, tau: float, state: Array) -> float:
    """Return kinetic plus potential energy, J."""
    length, omega = system.train.model.displacement_scale, system.train.derived_time_scale
    kinetic = 0.5 * masses(system.train) @ (state[12:] * length * omega) ** 2
    return float(kinetic + potential(system, tau, (state[:12] * length).astype(complex)).real)


def runout(train: GearTrain) -> GearTrain:
    """Give every gear a runout of its own."""
    gears = [replace(g, eccentricity=(4 + 2 * i) * 1e-6, eccentricity_phase=0.5 * i) for i, g in enumerate(train.gears)]
    first, second = train.meshes
    meshes = replace(first, driver=gears[0], driven=gears[1]), replace(second, driver=gears[2], driven=gears[3])
    return replace(train, meshes=meshes)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("shaft", [0.0, STEEL_SHAFT])
def test_the_force_is_the_gradient_of_one_potential_to_rounding(make_train: MakeTrain, shaft: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    train = runout(make_train({"*damping_ratio": 0})).with_shaft(shaft, damping_ratio=0.0)
    system = System(train).at(frequency=rng.uniform(-2, 2), load=rng.uniform(-300, 300))
    length, omega = train.model.displacement_scale, train.derived_time_scale
    tau, q = rng.uniform(0, 50), rng.normal(0, 1.5, 12) * length
    rates = system.derivative(tau, np.concatenate([q / length, rng.normal(size=12)]))
    force = rates[12:] * length * omega**2 * masses(train)
    # A complex step has no difference to lose digits in (Squire & Trapp 1998).
    gradient = np.array([potential(system, tau, q + 1j * 1e-30 * unit).imag / 1e-30 for unit in np.eye(12)])
    assert force == pytest.approx(-gradient, abs=1e-11 * np.abs(gradient).max())


def lost_energy(train: GearTrain, load: float) -> tuple[float, int]:
    """Return the largest relative drift of the energy over 100 periods of Ω = 1 from a push, and contact changes."""
    system = System(train).at(frequency=1.0, load=load)
    start = system.static_state()
    rest = energy(system, 0.0, start)
    start[[2, 8]] += 3.0
    run = integrate_time(system, (0.0, 200 * pi), start, method=EventLocating(tolerance=1e-13))
    found = np.array([energy(system, tau, state) for tau, state in zip(run.times[::40], run.states[::40], strict=True)])
    return float(np.abs(found - found[0]).max() / (found[0] - rest)), len(run.changes)


@pytest.mark.parametrize("shaft", [0.0, STEEL_SHAFT])
def test_energy_drifts_by_less_than_1e_9_over_100_periods_of_impacts(conservative: GearTrain, shaft: float) -> None:
    drift, changes = lost_energy(conservative.with_shaft(shaft, damping_ratio=0.0), 20.0)
    assert changes > 50
    assert drift < 1e-9


def test_torsion_as_printed_does_not_keep_the_energy(conservative: GearTrain) -> None:
    drift, _ = lost_energy(replace(conservative, variant=Variant(False, False)), 20.0)
    assert drift > 0.1


def loop_work(system: System, corner: Array, sides: tuple[Array, Array]) -> float:
    """Return the work of the dimensionless force around a parallelogram of coordinates, by Gauss quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    first, second = sides
    work = 0.0
    for start, along in ((corner, first), (corner + first, second), (corner + first + second, -first)):
        work += _line_work(system, start, along, nodes, weights)
    return work + _line_work(system, corner + second, -second, nodes, weights)


def _line_work(system: System, start: Array, along: Array, nodes: Array, weights: Array) -> float:
    inertia = masses(system.train) / masses(system.train)[0]
    work = 0.0
    for part in range(50):  # the kinks of f(δ) fall into few of them
        for node, weight in zip(nodes, weights, strict=True):
            q = start + (part + (node + 1) / 2) / 50 * along
            force = inertia * system.derivative(0.0, np.concatenate([q, np.zeros(12)]))[12:]
            work += weight / 100 * float(force @ along)
    return work


def test_torsion_as_printed_has_no_potential_at_all(conservative: GearTrain) -> None:
    # Work around a closed loop of x1 and u1 through the backlash: zero for every force that is a gradient.
    corner, unit = np.zeros(12), np.eye(12)
    sides = (4.0 * unit[0], 2.0 * unit[2])
    system = System(conservative).at(frequency=0.0, load=0.0)
    printed = System(replace(conservative, variant=Variant(False, False))).at(frequency=0.0, load=0.0)
    # 50 parts of 40 nodes, a kink in one part: an error of the square of a node's spacing, 1e-3 of 1/50.
    assert abs(loop_work(system, corner, sides)) < 1e-5
    # By Green: the excess κ·(δ − f(δ)) of the line of u1, integrated over the loop's two sides along u1.
    w = closing(conservative)[0]

    def excess(delta: Array) -> Array:
        return np.asarray(np.clip(delta, -1.0, 1.0))

    u = np.linspace(0.0, 2.0, 20001)
    far, near = excess(4.0 * w[0] + u), excess(u)
    expected = (
        -float(trapezoid(far - near, u))
        * float(system.coefficients.reaction[2])
        * (masses(conservative)[2] / masses(conservative)[0])
    )
    assert loop_work(printed, corner, sides) == pytest.approx(expected, rel=1e-4)
    assert abs(expected) > 0.1


@pytest.mark.parametrize("coupled", [False, True], ids=["pairs apart", "on a shaft"])
def test_the_propagator_on_the_loaded_flank_has_the_modes_of_eigh(
    make_train: MakeTrain, steady: Steady, coupled: bool
) -> None:
    still = {"*damping_ratio": 0, "*.error_amplitude": [0], "*.error_phase": [0], "gears.*.torsional_stiffness": 0}
    train = steady(make_train(still))
    if coupled:
        train = train.with_shaft(STEEL_SHAFT, damping_ratio=0.0)
    system, duration = System(train).at(frequency=0.5, load=600.0), 7.0
    stiffness = np.diag(supports(train))
    for mesh, w in zip(train.meshes, closing(train), strict=True):
        stiffness += mesh.mean_model_stiffness * np.outer(w, w)
    twist = np.zeros(12)
    twist[[5, 8]] = 1 / train.gears[1].base_radius, 1 / train.gears[2].base_radius
    stiffness += train.shaft.stiffness * np.outer(twist, twist)
    squares, shapes = eigh(stiffness, np.diag(masses(train)))
    # At rest no error of the state would choose the step. With z = ω·h < 0.02 an error of z⁶/3600 a step is rounding.
    method = EventLocating(step=0.01)
    (stretch,) = propagators(system, system.static_state(), count=1, interval=duration, method=method)
    assert stretch.contact_share.tolist() == [1, 1]
    rigid = np.abs(squares) < 1e-9 * squares.max()
    assert rigid.sum() == (1 if coupled else 2)  # each free pair, or the whole train, turns as a body
    for square, shape, free in zip(squares, shapes.T, rigid, strict=True):
        shape = shape / np.abs(shape).max()
        omega = 0.0 if free else np.sqrt(square) / train.derived_time_scale
        swing = duration if free else np.sin(omega * duration) / omega
        moved = np.concatenate([shape, 0 * shape]), np.concatenate([0 * shape, shape])
        expected = (
            np.concatenate([cos(omega * duration) * shape, -omega * sin(omega * duration) * shape]),
            np.concatenate([swing * shape, cos(omega * duration) * shape]),
        )
        for start, end in zip(moved, expected, strict=True):
            assert stretch.propagator @ start == pytest.approx(end, abs=1e-10)  # rounding of 700 steps and of eigh


@pytest.mark.parametrize("load", [600.0, 20.0, -80.0])
def test_the_static_force_of_a_free_coupled_train_is_the_static_chain(
    make_train: MakeTrain, steady: Steady, load: float
) -> None:
    still = {"*.torsional_stiffness": 0, "*.error_amplitude": [0], "*.error_phase": [0]}
    train = steady(make_train(still)).with_shaft(STEEL_SHAFT)
    system = System(train).at(frequency=0.0, load=load)
    _, s2, s3, s4 = train.gears
    found = system.mesh_forces(0.0, system.static_state()) * system.coefficients.force_unit / train.model.load_scale
    # A least-squares balance beside a free turn of the whole train: rounding times the stiffness ratio.
    chain = [load * s3.base_radius / (s4.base_radius * s2.base_radius), load / s4.base_radius]
    assert found == pytest.approx(chain, rel=1e-6)


def mean_trace(system: System, share: Array) -> float:
    """Return −trace of M⁻¹C per unit of τ with the mesh dampers acting for `share` of the time."""
    train = system.train
    mass, omega = masses(train), train.derived_time_scale
    damping = np.zeros(12)
    for n, g in enumerate(train.gears):
        ratios = (g.support_damping_ratio, g.support_damping_ratio, g.torsional_damping_ratio)
        own = slice(3 * n, 3 * n + 3)
        damping[own] = 2 * np.array(ratios) * np.sqrt(supports(train)[own] * mass[own])
    for mesh, w, acting in zip(train.meshes, closing(train), share, strict=True):
        damping += acting * mesh.damping * w**2
    if train.shaft.couples:
        _, s2, s3, _ = train.gears
        reduced = s2.inertia * s3.inertia / (s2.inertia + s3.inertia)
        torsional = 2 * train.shaft.damping_ratio * np.sqrt(train.shaft.stiffness * reduced)
        damping[[5, 8]] += torsional / np.array([s2.base_radius, s3.base_radius]) ** 2
    return -float((damping / mass).sum()) / omega


@pytest.mark.parametrize("shaft", [0.0, STEEL_SHAFT])
@pytest.mark.parametrize("contact_only", [False, True])
def test_the_exponents_sum_to_the_mean_trace(train: GearTrain, shaft: float, contact_only: bool) -> None:
    system = System(replace(train, variant=Variant(True, contact_only)).with_shaft(shaft)).at(frequency=1.0, load=40.0)
    found = list(growths(system, system.static_state(), count=30, method=EXACT))
    share = np.mean([g.contact_share for g in found], axis=0)
    assert np.all((share > 0.02) & (share < 0.98))
    total = sum(float(g.logarithms.sum()) for g in found) / (30 * 2 * pi)
    expected = mean_trace(system, share if contact_only else np.ones(2))
    # The tangent's steps are chosen for the state: some 1e-9 of trace a step.
    assert total == pytest.approx(expected, rel=1e-8)


def test_the_jump_has_no_share_in_the_trace_but_in_the_exponents(train: GearTrain) -> None:
    # det S = 1, so the sum says nothing about S: the leading growth does, against two motions that part.
    system = System(replace(train, variant=Variant(True, True))).at(frequency=1.0, load=40.0)
    start, span = system.static_state(), (0.0, 40.0)
    direction = np.eye(24, 1)
    exact = integrate_time(system, span, start, method=EXACT, tangent=direction)
    moved = integrate_time(system, span, start + 1e-7 * direction[:, 0], method=EXACT)
    apart = np.log(np.linalg.norm(moved.state - exact.state) / 1e-7)
    assert len(exact.changes) > 10
    assert np.log(np.linalg.norm(exact.tangent)) == pytest.approx(apart, abs=1e-4)
    without = integrate_time(system, span, start, method=FixedStep(0.001), tangent=direction)
    assert abs(np.log(np.linalg.norm(without.tangent)) - apart) > 0.1


@pytest.mark.parametrize("contact_only", [False, True])
def test_the_tangent_is_the_derivative_of_the_motion_through_impacts(train: GearTrain, contact_only: bool) -> None:
    # Fréchet: what the tangent leaves over falls with the square of the difference.
    system = System(replace(train, variant=Variant(True, contact_only))).at(frequency=0.9, load=60.0)
    start, span = system.static_state(), (0.0, 25.0)
    direction = np.random.default_rng(4).normal(size=(24, 1))
    exact = integrate_time(system, span, start, method=EXACT, tangent=direction)
    assert len(exact.changes) > 5
    sizes, left = 10.0 ** -np.arange(3.5, 5.6, 0.5), []
    for size in sizes:
        moved = integrate_time(system, span, start + size * direction[:, 0], method=EXACT)
        left.append(np.linalg.norm(moved.state - exact.state - size * exact.tangent[:, 0]))
    # The next order's share at the largest difference, and integration errors at the smallest.
    assert np.polyfit(np.log(sizes), np.log(left), 1)[0] == pytest.approx(2.0, abs=0.02)


def test_an_exponent_of_the_period_map_is_the_period_times_that_of_the_flow(train: GearTrain) -> None:
    # The map's, from differences of motions over whole periods alone; the flow's, from its tangent in other pieces.
    system, period, count = System(train).at(frequency=1.0, load=40.0), 2 * pi, 10
    states = [system.static_state()]
    direction, by_map, step = np.eye(24)[0], 0.0, 1e-6
    for n in range(count):
        span = (n * period, (n + 1) * period)
        ends = [integrate_time(system, span, states[-1] + s * step * direction, method=EXACT).state for s in (-1, 1)]
        grown = (ends[1] - ends[0]) / (2 * step)
        by_map += np.log(np.linalg.norm(grown)) / count
        direction = grown / np.linalg.norm(grown)
        states.append(integrate_time(system, span, states[-1], method=EXACT).state)
    pieces = growths(system, states[0], count=23, vectors=1, interval=count * period / 23, method=EXACT)
    flow = sum(float(g.logarithms[0]) for g in pieces) / (count * period)
    # Central differences of 1e-6 leave 1e-12 of curvature and 1e-13/1e-6 of integration error.
    assert by_map == pytest.approx(period * flow, abs=1e-5)


def test_a_limit_cycle_with_its_phase_as_a_state_has_a_zero_exponent(make_train: MakeTrain) -> None:
    # Stiff, well damped shafts settle P12 in 200 periods; light enough a load that teeth part in every one.
    train = make_train({"*damping_ratio": 0.3, "gears.*.torsional_stiffness": 2e7, "meshes.*.error_amplitude": [9, 3]})
    system, period = System(train).at(frequency=0.9, load=600.0), 2 * pi / 0.9
    pair = np.r_[0:6, 12:18]
    state = integrate(system, transient=300, periods=1).state
    start = 301 * period
    (stretch,) = propagators(system, state, count=1, start=start, method=EXACT)
    assert np.count_nonzero(stretch.changes.meshes == 0) > 1
    assert stretch.state[pair] == pytest.approx(state[pair], abs=1e-5)  # as exact as the march's step makes the cycle
    # The 25th column: what a later phase at the start does to the end of as long a motion.
    step = 1e-5
    ends = [
        integrate_time(system, (start + s * step, start + period + s * step), state, method=EXACT).state
        for s in (-1, 1)
    ]
    late = (ends[1] - ends[0]) / (2 * step)  # per unit of τ, of which the phase advances 1
    along = system.derivative(start, state)
    carried = np.append((stretch.propagator @ along + late)[pair], 1.0)
    direction = np.append(along[pair], 1.0)
    assert carried == pytest.approx(direction, abs=1e-4)
    assert np.log(np.linalg.norm(carried) / np.linalg.norm(direction)) / period == pytest.approx(0, abs=1e-5)
    # All other exponents are below zero, or the cycle would not have been settled on.
    multipliers = np.linalg.eigvals(stretch.propagator[np.ix_(pair, pair)])
    assert np.abs(multipliers).max() < 0.9
