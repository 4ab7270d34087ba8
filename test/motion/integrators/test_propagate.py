"""Propagators and growths: against differences of motions, and the laws that they obey."""

from itertools import islice
from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.motion.integrators import (
    EventLocating,
    contact_jump,
    growths,
    integrate_time,
    propagators,
)

Array = NDArray[np.float64]


def rattling(train: GearTrain) -> System:
    return System(train).at(frequency=0.9, load=60.0)


@pytest.mark.parametrize(("before", "after", "gained"), [(0, 1, 1), (1, 0, -1), (0, -1, 1), (-1, 0, -1), (1, -1, 0)])
@pytest.mark.parametrize("mesh", [0, 1])
def test_the_jump_is_the_general_formula_at_the_flank(
    contact_damped: GearTrain, mesh: int, before: int, after: int, gained: int
) -> None:
    # S = I + (f⁺ − f⁻)·nᵀ/(nᵀf⁻ + h_t) with f on both sides of the flank from the public right-hand side.
    system, tau = rattling(contact_damped), 3.0
    flank = before or after
    state = np.random.default_rng(2).normal(0, 0.4, 24)
    own = np.where(np.arange(12) // 6 == mesh, system.coefficients.direction, 0.0)
    delta, rate = system.deflections(tau, state)
    state[:12] += own / (own @ own) * (flank - delta[mesh])
    inside, outside = state.copy(), state.copy()
    # 1e-12 to either side: more than rounding, and of no weight in f.
    inside[:12] -= flank * 1e-12 * own / (own @ own)
    outside[:12] += flank * 1e-12 * own / (own @ own)
    jump = system.derivative(tau, outside) - system.derivative(tau, inside)
    normal = np.concatenate([own, np.zeros(12)])
    expected = np.eye(24) + gained * np.outer(jump, normal) / rate[mesh]
    assert contact_jump(system, mesh, before, after) == pytest.approx(expected, abs=1e-9)


def test_there_is_no_jump_where_damping_acts_always(train: GearTrain) -> None:
    assert np.array_equal(contact_jump(rattling(train), 0, 0, 1), np.eye(24))


def test_propagators_are_differences_of_motions_over_a_period_of_impacts(variant: GearTrain) -> None:
    system, method = rattling(variant), EventLocating(tolerance=1e-13)
    start, period = system.static_state(), 2 * pi / 0.9
    (stretch,) = propagators(system, start, count=1, method=method)
    if variant.variant.backlash_in_torsion:
        assert len(stretch.changes) >= 2
    step = 1e-5  # central differences err by step² and by 1e-12/step of the integration
    for i in range(24):
        ends = []
        for sign in (1, -1):
            moved = start + sign * step * np.eye(24)[i]
            ends.append(integrate_time(system, (0.0, period), moved, method=method).state)
        assert stretch.propagator[:, i] == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=1e-6)


def test_propagators_follow_one_another(contact_damped: GearTrain) -> None:
    system, method = rattling(contact_damped), EventLocating(tolerance=1e-12)
    pieces = list(propagators(system, system.static_state(), count=4, interval=2.5, method=method))
    (whole,) = propagators(system, system.static_state(), count=1, interval=10.0, method=method)
    product = np.linalg.multi_dot([p.propagator for p in reversed(pieces)])
    assert pieces[-1].tau == whole.tau == 10.0
    assert pieces[-1].state == pytest.approx(whole.state, abs=1e-9)
    assert product == pytest.approx(whole.propagator, abs=1e-8)


def test_growths_are_the_singular_growth_of_the_propagator_in_all(contact_damped: GearTrain) -> None:
    # The sum over a full frame is log|det| of the propagator, and the first one the growth of the first direction.
    system = rattling(contact_damped)
    start = system.static_state()
    pairs = zip(propagators(system, start, count=5), growths(system, start, count=5), strict=True)
    for stretch, grown in pairs:
        assert grown.logarithms.sum() == pytest.approx(np.linalg.slogdet(stretch.propagator)[1], abs=1e-6)
        assert grown.contact_share == pytest.approx(stretch.contact_share, abs=1e-6)
        assert grown.tau == stretch.tau


def test_fewer_vectors_are_the_leading_ones(train: GearTrain) -> None:
    system = rattling(train)
    few = list(growths(system, system.static_state(), count=3, vectors=2))
    many = list(growths(system, system.static_state(), count=3))
    for a, b in zip(few, many, strict=True):
        assert a.logarithms == pytest.approx(b.logarithms[:2], abs=1e-9)  # the same arithmetic but for QR's rounding


def test_intervals_may_start_anywhere_in_the_mesh_period(train: GearTrain) -> None:
    system = rattling(train)
    (stretch,) = propagators(system, system.static_state(), count=1, start=1.7, interval=3.0)
    run = integrate_time(system, (1.7, 4.7), system.static_state())
    assert stretch.tau == pytest.approx(4.7)
    assert stretch.state == pytest.approx(run.state, abs=1e-12)


def test_impossible_requests_are_refused(train: GearTrain) -> None:
    still = System(train).at(frequency=0.0)
    with pytest.raises(ValueError, match="The frequency is 0, where there is no mesh period; give an interval"):
        next(propagators(still, still.static_state(), count=1))
    assert len(list(islice(propagators(still, still.static_state(), count=2, interval=1.0), 5))) == 2
    with pytest.raises(ValueError, match="Asked for the growth of 25 vectors, expected 1 to 24"):
        next(growths(rattling(train), np.zeros(24), count=1, vectors=25))
