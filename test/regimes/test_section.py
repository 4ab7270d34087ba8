"""Finding the period of a stroboscopic section."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.regimes import find_period, recurrence

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
