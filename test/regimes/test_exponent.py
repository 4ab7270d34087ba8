"""The largest exponent and its error, on growths that are known."""

from math import log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.regimes import largest_exponent
from seat_gear_dynamics.regimes.exponent import Exponent, weighted_exponent


@given(st.floats(-5, 5), st.floats(0.01, 100), st.integers(16, 300))
def test_steady_growth_is_the_exponent_without_error(rate: float, interval: float, points: int) -> None:
    found = largest_exponent(np.full(points, rate * interval), interval)
    assert found.value == pytest.approx(rate, rel=1e-9, abs=1e-12)
    assert found.error == pytest.approx(0, abs=1e-9)


@given(st.floats(0.1, 10))
def test_exponent_of_the_period_map_is_the_period_times_the_exponent_of_the_flow(interval: float) -> None:
    growth = np.random.default_rng(0).normal(0.3, 0.5, 400)
    per_period, per_time = largest_exponent(growth, 1.0), largest_exponent(growth, interval)
    assert per_period.value == pytest.approx(interval * per_time.value, rel=1e-9)
    assert per_period.error == pytest.approx(interval * per_time.error, rel=1e-9)


def test_the_fully_developed_logistic_map_has_the_exponent_ln_2() -> None:
    # x → 4x(1 − x), whose exponent is ln 2 exactly; computed through its conjugate tent angle, which does not collapse.
    angle = np.random.default_rng(5).uniform(size=4000)
    found = largest_exponent(np.log(np.abs(4 - 8 * np.sin(np.pi * angle / 2) ** 2)), 1.0)
    assert found.value == pytest.approx(log(2), abs=4 * found.error)
    assert 0 < found.error < 0.05


def test_the_error_is_the_scatter_of_the_mean() -> None:
    # Independent growths of deviation 1: the mean of 800 has variance 1/800, which the squared error estimates without
    # bias; over 400 records the estimate scatters by 2.7 %.
    found = [largest_exponent(np.random.default_rng(seed).normal(size=800), 1.0) for seed in range(400)]
    assert np.mean([each.error**2 for each in found]) == pytest.approx(1 / 800, rel=0.12)
    assert np.var([each.value for each in found]) == pytest.approx(1 / 800, rel=0.3)


def test_the_oldest_growths_are_left_out_where_blocks_do_not_divide_the_record() -> None:
    growth = np.concatenate([[1000.0] * 7, np.full(16, 0.5)])
    assert largest_exponent(growth, 1.0).value == pytest.approx(0.5)


def test_a_record_too_short_for_an_exponent_is_refused() -> None:
    with pytest.raises(ValueError, match=r"of 15 intervals; expected at least 16\."):
        largest_exponent(np.zeros(15), 1.0)


def test_growth_that_comes_and_goes_on_a_torus_averages_to_nothing() -> None:
    # Growth along a torus is the difference of a function of the phase from one point to the next: it adds up to
    # nothing. Block means miss that by the size of the function over their length, the weighted average does not.
    stretch = np.log(2 + np.cos(2 * np.pi * (5**0.5 - 1) / 2 * np.arange(401)))
    blocks, weighted = largest_exponent(np.diff(stretch), 1.0), weighted_exponent(np.diff(stretch), 1.0)
    assert abs(weighted.value) < 1e-6 > weighted.error
    assert blocks.error > 1e-4


@given(st.floats(-5, 5), st.floats(0.01, 100), st.integers(16, 300))
def test_steady_growth_is_the_weighted_exponent_without_error(rate: float, interval: float, points: int) -> None:
    found = weighted_exponent(np.full(points, rate * interval), interval)
    assert found.value == pytest.approx(rate, rel=1e-9, abs=1e-12)
    assert found.error == pytest.approx(0, abs=1e-9)


def test_the_weighted_exponent_of_noise_is_its_mean_within_the_scatter_of_the_weights() -> None:
    # The weights' squares make of n growths as much as n/1.96 equal ones: 0.0495, and of 400 records a 20th of that.
    found = [weighted_exponent(np.random.default_rng(seed).normal(0.3, 1, 800), 1.0).value for seed in range(400)]
    assert np.mean(found) == pytest.approx(0.3, abs=4 * 0.0495 / 20)
    assert np.std(found) == pytest.approx(0.0495, rel=0.15)


def test_a_record_too_short_for_a_weighted_exponent_is_refused() -> None:
    with pytest.raises(ValueError, match=r"of 15 intervals; expected at least 16\."):
        weighted_exponent(np.zeros(15), 1.0)


def test_above_and_within_take_the_error_into_account() -> None:
    assert Exponent(0.1, 0.03).above(0.005, errors=3)
    assert not Exponent(0.1, 0.04).above(0.005, errors=3)
    assert Exponent(-0.004, 0.001).within(0.005, errors=3)
    assert not Exponent(-0.006, 0.001).within(0.005, errors=3)
    assert not Exponent(0.0, 0.002).within(0.005, errors=3)
