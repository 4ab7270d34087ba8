"""The integrator: order conditions, exact bounces, SciPy's Radau, convergence, and what it says when lost."""

from itertools import pairwise
from math import inf, log2, nan, pi, sqrt

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.studies.contact_verification.march import (
    ALPHA,
    COUPLING,
    DIVERGED,
    EMBEDDED,
    FINISHED,
    GAMMA,
    WEIGHTS,
    Accuracy,
    march,
    try_step,
)
from seat_gear_dynamics.studies.contact_verification.readings import Assumptions
from seat_gear_dynamics.studies.contact_verification.rigid_train import Drive, Train, accelerations, mesh_loads
from seat_gear_dynamics.studies.contact_verification.verify import rigid_train

Array = NDArray[np.float64]

DRIVE = Drive(13.8, 0.1, 300.0, 0.0, 0.0)
TIGHT = Accuracy(1e-12, 1e-7, 1e-5)


def run(bodies: Train, drive: Drive, accuracy: Accuracy, y: Array, times: Array) -> tuple[int, Array, Array]:
    samples, windows = np.zeros((len(times), 5)), np.tile([0.0, 0.0, 0.0, inf, -inf, 0.0], (2, 1))
    samples[:, 0] = times
    code = march(bodies, drive, accuracy, y, np.array([0.0, 1e-8]), samples, windows)
    return code, samples, windows


def loose(bodies: Train) -> Train:
    """Return the train with s4 taken away from s3: s2-s3 moves alone between s1's flanks, without damping."""
    apart = bodies.second._replace(half_backlash=1.0)
    return bodies._replace(second=apart, first_contact=bodies.first_contact._replace(damping=0.0))


def test_coefficients_meet_the_order_conditions_whatever_the_jacobian() -> None:
    a, beta = ALPHA.sum(axis=1), COUPLING.sum(axis=1)
    b = WEIGHTS
    # Order 3 for W-methods (Hairer & Wanner, Solving ODEs II, IV.7): every tree with each Jacobian replaced.
    conditions = {
        1.0: (b.sum(), EMBEDDED.sum()),
        1 / 2: (b @ a, EMBEDDED @ a),
        0.0: (b @ beta, EMBEDDED @ beta, b @ ALPHA @ beta, b @ COUPLING @ a, b @ COUPLING @ beta),
        1 / 3: (b @ a**2,),
        1 / 6: (b @ ALPHA @ a,),
    }
    for value, found in conditions.items():
        assert found == pytest.approx([value] * len(found), abs=1e-14)
    assert np.diag(COUPLING) == pytest.approx(GAMMA)


def test_coefficients_are_l_stable() -> None:
    # R(z) = 1 + z·bᵀ(I − z·B)⁻¹·1 with B = ALPHA + COUPLING; at the far left the method forgets.
    def stability(z: complex) -> complex:
        matrix = np.eye(4) - z * (ALPHA + COUPLING)
        return complex(1 + z * WEIGHTS @ np.linalg.solve(matrix, np.ones(4)))

    assert abs(stability(-1e9)) < 1e-7
    assert max(abs(stability(1j * w)) for w in np.logspace(-2, 4, 200)) <= 1 + 1e-12
    assert stability(-0.01) == pytest.approx(np.exp(-0.01), abs=1e-9)


def test_s2_bounces_between_undamped_flanks_with_the_exact_period(train: GearTrain) -> None:
    backlash, speed = 30e-6, 1.0
    bodies = loose(rigid_train(train, backlash, Assumptions(reading="linear", friction=False)))
    mass = bodies.middle_inertia / bodies.first.driven_radius**2
    # With s1 at rest at angle 0 two pairs are in contact on each side: half a wave on both, and free flight between.
    frequency = sqrt(2 * bodies.first_contact.stiffness / mass)
    period = 2 * backlash / speed + 2 * pi / frequency
    y = np.array([0.0, 0.0, speed / bodies.first.driven_radius, 0.0])
    at_rest = Drive(0.0, 0.0, 0.0, 0.0, 0.0)
    code, samples, windows = run(bodies, at_rest, TIGHT, y, np.linspace(0, 3 * period, 301))
    assert code == FINISHED
    # Some 1e3 steps of error 1e-12 m on 15 µm of free way; the energy likewise.
    assert abs(y[0]) * bodies.first.driven_radius < 1e-9
    assert y[2] * bodies.first.driven_radius == pytest.approx(speed, rel=1e-5)
    peak = speed * mass * frequency
    assert windows[0, 4] == pytest.approx(peak, rel=1e-3)  # the highest of the steps of 1e-5 of the peak's half wave
    assert samples[:, 1].max() <= peak * (1 + 1e-5)
    assert windows[0, 5] / windows[0, 0] == pytest.approx(1 - pi / frequency / period, abs=1e-3)


def test_an_undamped_start_up_impact_stays_below_what_the_load_can_do(train: GearTrain) -> None:
    bodies = rigid_train(train, 30e-6, Assumptions(reading="linear", friction=False))
    bodies = bodies._replace(
        first_contact=bodies.first_contact._replace(damping=0.0),
        second_contact=bodies.second_contact._replace(damping=0.0),
    )
    # Energy: ½·k·δ² of two pairs ≤ F·(b/2 + δ) + what the load gains over P34's penetration, F34²/(2·k34) at most.
    first, second = train.static_forces(300.0)
    k, k_34 = 2 * bodies.first_contact.stiffness, 2 * bodies.second_contact.stiffness
    bound = first + sqrt(first**2 + 2 * k * (first * 15e-6 + second**2 / (2 * k_34)))
    _, _, windows = run(bodies, DRIVE, TIGHT, np.zeros(4), np.array([0.0, 1e-4]))
    assert 0.7 * bound < windows[0, 4] < bound


def test_start_up_agrees_with_radau(train: GearTrain) -> None:
    bodies = rigid_train(train, 30e-6, Assumptions(reading="linear"))
    times = np.linspace(0, 1.5e-4, 16)
    outside = solve_ivp(
        lambda t, y: [y[2], y[3], *accelerations(bodies, DRIVE, t, y)],
        (0, times[-1]),
        np.zeros(4),
        method="Radau",
        t_eval=times,
        rtol=1e-9,
        atol=[1e-12, 1e-12, 1e-7, 1e-7],
        max_step=2e-7,
    )
    expected = [mesh_loads(bodies, DRIVE, t, y)[0].force for t, y in zip(times, outside.y.T, strict=True)]
    _, samples, _ = run(bodies, DRIVE, TIGHT, np.zeros(4), times)
    # Steps of error 1e-12 m on a contact of 1e9 N/m make 1e-3 N each; the largest force is 2e4 N.
    assert samples[:, 1] == pytest.approx(expected, abs=2.0)
    assert max(expected) > 1e4


def test_order_is_three_on_a_smooth_arc(train: GearTrain) -> None:
    # No tip touches or leaves in these 40 µs, with `corner` off; the error falls by 2.98 to 3.01 powers.
    bodies = rigid_train(train, 0.0, Assumptions(reading="linear", friction=False, corner=False))
    start = np.array([-2e-4, -4e-4, 0.0, 0.0])

    def final(steps: int) -> Array:
        y, result, error = start.copy(), np.empty(4), np.empty(4)
        h = 4e-5 / steps
        for n in range(steps):
            try_step(bodies, DRIVE, 0.2 + n * h, h, y, result, error)
            y[:] = result
        return y

    exact = final(4096)
    errors = [float(np.abs(final(n) - exact).max()) for n in (32, 64, 128, 256)]
    orders = [log2(a / b) for a, b in pairwise(errors)]
    assert orders == pytest.approx([3.0, 3.0, 3.0], abs=0.1)


def test_error_estimate_is_above_the_error_it_estimates(train: GearTrain) -> None:
    bodies = rigid_train(train, 0.0, Assumptions(reading="linear", friction=False, corner=False))
    start, h = np.array([-2e-4, -4e-4, 0.0, 0.0]), 1e-7
    result, error, exact, spare = (np.empty(4) for _ in range(4))
    try_step(bodies, DRIVE, 0.2, h, start, result, error)
    y = start.copy()
    for n in range(64):
        try_step(bodies, DRIVE, 0.2 + n * h / 64, h / 64, y, exact, spare)
        y[:] = exact
    assert np.abs(error).max() > np.abs(result - exact).max() > 0


def test_tighter_tolerances_converge_on_one_impact(train: GearTrain) -> None:
    bodies = rigid_train(train, 30e-6, Assumptions())

    def peak(arc: float) -> float:
        _, _, windows = run(bodies, DRIVE, Accuracy(arc, arc * 5e4, 1e-5), np.zeros(4), np.array([0.0, 1e-4]))
        return float(windows[0, 4])

    best = peak(1e-12)
    errors = [abs(peak(arc) / best - 1) for arc in (1e-8, 1e-9, 1e-10)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[1] < 2e-3  # what the default tolerance, 1e-9 m, is said to do, with room


def test_samples_fall_on_their_times_and_do_not_depend_on_being_cut(train: GearTrain) -> None:
    bodies = rigid_train(train, 10e-6, Assumptions())
    times = np.linspace(0, 2e-3, 21)
    y = np.zeros(4)
    _, whole, windows = run(bodies, DRIVE, TIGHT, y, times)
    assert np.array_equal(whole[:, 0], times)
    assert windows[:, 0] == pytest.approx([2e-3, 2e-3], rel=1e-12)
    again, clock = np.zeros(4), np.array([0.0, 1e-8])
    rows = []
    for part in (times[:11], times[11:]):
        samples = np.zeros((len(part), 5))
        samples[:, 0] = part
        march(bodies, DRIVE, TIGHT, again, clock, samples, np.zeros((2, 6)))
        rows.append(samples)
    assert np.array_equal(np.vstack(rows), whole)


@pytest.mark.parametrize("lost", [nan, 3.0])
def test_a_lost_solution_is_said_to_be(train: GearTrain, lost: float) -> None:
    bodies = rigid_train(train, 0.0, Assumptions())
    code, _, _ = run(bodies, DRIVE, TIGHT, np.array([lost, 0.0, 0.0, 0.0]), np.array([0.0, 1e-3]))
    assert code == DIVERGED
