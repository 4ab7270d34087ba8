"""Finding the period of a stroboscopic section."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.regimes import find_period, recurrence
from seat_gear_dynamics.regimes.section import Shrinkage, shrinkage

Array = NDArray[np.float64]


def cycle(period: int, points: int, seed: int = 0) -> Array:
    """Return a section that repeats `period` points at least 0.1 apart from each other."""
    rng = np.random.default_rng(seed)
    first = rng.permutation(period) * 0.1
    one_round = np.column_stack([first, rng.uniform(-1, 1, period)])
    return np.tile(one_round, (points // period + 1, 1))[:points]


@settings(max_examples=100)
@given(st.integers(1, 16), st.integers(0, 1000), st.integers(48, 200))
def test_every_period_up_to_sixteen_is_found_and_no_multiple_of_it(period: int, seed: int, points: int) -> None:
    assert find_period(cycle(period, points, seed), tolerance=1e-3) == period


@given(st.integers(1, 16), st.integers(0, 1000))
def test_noise_below_the_tolerance_does_not_hide_a_period(period: int, seed: int) -> None:
    section = cycle(period, 96, seed)
    noisy = section + np.random.default_rng(seed).uniform(-0.45e-3, 0.45e-3, section.shape)
    assert find_period(noisy, tolerance=1e-3) == period


@given(st.integers(0, 1000))
def test_noise_above_the_tolerance_is_no_period(seed: int) -> None:
    noise = np.random.default_rng(seed).normal(0, 0.05, (96, 2))
    assert find_period(noise, tolerance=1e-3) is None


@given(st.integers(1, 16), st.integers(0, 95), st.integers(0, 1))
def test_a_single_point_astray_is_enough_to_deny_a_period(period: int, index: int, axis: int) -> None:
    section = cycle(period, 96)
    section[index, axis] += 0.05
    assert find_period(section, tolerance=1e-3) is None


def test_a_split_smaller_than_the_tolerance_counts_as_undoubled() -> None:
    section = np.zeros((96, 2))
    section[::2, 0] = 0.9e-3
    assert find_period(section, tolerance=1e-3) == 1
    assert find_period(section, tolerance=0.8e-3) == 2


@pytest.mark.parametrize("period", [17, 20, 32])
def test_periods_beyond_the_longest_are_not_looked_for(period: int) -> None:
    assert find_period(cycle(period, 200), tolerance=1e-3) is None


def test_a_period_is_believed_after_three_rounds_and_not_before() -> None:
    assert find_period(cycle(5, 15), tolerance=1e-3) == 5
    assert find_period(cycle(5, 14), tolerance=1e-3) is None
    assert find_period(np.zeros((2, 2)), tolerance=1e-3) is None
    assert find_period(np.empty((0, 2)), tolerance=1e-3) is None


@given(st.integers(1, 10), st.floats(-5, 5), st.floats(-5, 5))
def test_recurrence_does_not_depend_on_where_the_section_lies(period: int, dx: float, dy: float) -> None:
    section = np.random.default_rng(3).normal(size=(40, 2))
    moved = recurrence(section + np.array([dx, dy]), period)
    assert moved == pytest.approx(recurrence(section, period), abs=1e-12)


def test_recurrence_of_a_line_is_its_step_times_the_period() -> None:
    section = np.column_stack([0.1 * np.arange(30), np.zeros(30)])
    assert recurrence(section, 4) == pytest.approx(0.4)


@pytest.mark.parametrize("period", [0, -1, 10, 11])
def test_a_period_outside_the_record_is_refused(period: int) -> None:
    with pytest.raises(ValueError, match=rf"Period {period} was asked of 10 section points; expected 1 to 9\."):
        recurrence(np.zeros((10, 2)), period)


@pytest.mark.parametrize("period", [1, 2, 5])
def test_small_steps_of_a_slow_transient_are_no_period(period: int) -> None:
    # Each step is within the tolerance, the way of the whole record 0.3.
    section = cycle(period, 300) + 0.9e-3 * (np.arange(300) // period)[:, None]
    assert recurrence(section, period) < 1e-3
    assert find_period(section, tolerance=1e-3) is None


def test_a_way_of_twice_the_tolerance_is_where_a_drift_stops_being_a_period() -> None:
    drift = np.column_stack([np.linspace(0, 1, 200), np.zeros(200)])
    assert find_period(1.99e-3 * drift, tolerance=1e-3) == 1
    assert find_period(2.01e-3 * drift, tolerance=1e-3) is None


@pytest.mark.parametrize("period", [17, 20, 32, 50])
def test_longer_periods_are_found_when_asked_for(period: int) -> None:
    noise = np.random.default_rng(0).uniform(-0.45e-3, 0.45e-3, (200, 2))
    assert find_period(cycle(period, 200) + noise, tolerance=1e-3, longest=66) == period


@pytest.mark.parametrize("radius", [0.3, 0.1, 0.03, 0.01])
@pytest.mark.parametrize("turns", [(5**0.5 - 1) / 2, 2**0.5 - 1.33, 8 / 95 + 3e-6])
def test_a_torus_near_a_high_resonance_has_no_long_period(radius: float, turns: float) -> None:
    # It comes close to its beginning after 89 or 95 points, and closer than the tolerance where it is small.
    angle = 2 * np.pi * turns * np.arange(400)
    section = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    assert find_period(section, tolerance=1e-3, longest=133) is None


@given(st.floats(1e-4, 0.1), st.integers(1, 4), st.booleans(), st.integers(200, 400))
def test_a_geometric_transient_shrinks_at_its_rate_without_error(
    decay: float, period: int, turning: bool, points: int
) -> None:
    index = np.arange(points)
    angle = 2 * np.pi * 0.3819660113 * index * turning
    size = np.exp(-decay * index)
    section = cycle(period, points) + (size * np.array([np.cos(angle), np.sin(angle)])).T
    found = shrinkage(section, pieces=period)
    # Below exp(−20) = 2e-9 sizes meet the rounding of points of size 1. Above, they are good to 1e-7, and a line
    # through them to that over the record. Turning, a part of 25 points or more has a size that depends on the phase it
    # begins with by up to 0.05, and a line through eight of them changes by up to 0.1 over the record.
    if decay * points < 20:
        assert found.rate == pytest.approx(decay, abs=(0.1 if turning else 1e-6) / points)


def test_a_torus_keeps_its_size_and_an_unstable_spiral_grows() -> None:
    angle = 2 * np.pi * 0.3819660113 * np.arange(400)
    torus = np.column_stack([np.cos(angle), 0.4 * np.sin(angle)])
    kept = shrinkage(torus)
    assert abs(kept.rate) < 3 * kept.error < 1e-3
    assert shrinkage(torus * np.exp(0.004 * np.arange(400))[:, None]).rate == pytest.approx(-0.004, rel=0.02)


@pytest.mark.parametrize(("points", "pieces"), [(0, 1), (11, 1), (95, 8)])
def test_a_record_too_short_for_a_rate_has_an_infinite_error(points: int, pieces: int) -> None:
    assert shrinkage(np.random.default_rng(0).normal(size=(points, 2)), pieces=pieces) == Shrinkage(0.0, float("inf"))


def test_a_constant_does_not_shrink() -> None:
    assert shrinkage(np.full((100, 2), 3.0)) == Shrinkage(0.0, 0.0)
