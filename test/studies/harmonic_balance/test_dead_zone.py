"""The sampled dead zone against its describing function, and how fast its sums converge."""

from math import asin, log2, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.studies.harmonic_balance.dead_zone import dead_zone
from seat_gear_dynamics.studies.harmonic_balance.fourier import Basis


def describing_function(amplitude: float, half: float) -> float:
    """Return the fundamental of f(A cos θ) over A (Gelb & Vander Velde 1968, "Multiple-Input Describing Functions")."""
    share = half / amplitude
    return 1 - 2 / pi * (asin(share) + share * sqrt(1 - share**2))


def fundamental(amplitude: float, half: float, samples: int, shift: float = 0.0) -> float:
    basis = Basis(1, samples)
    beyond, _ = dead_zone(amplitude * np.cos(2 * np.pi * (basis.phases - shift)), half)
    return float(np.hypot(*basis.coefficients(beyond)[1:])) / amplitude


@pytest.mark.parametrize("amplitude", [1.2, 2.0, 10.0])
def test_fundamental_is_the_describing_function(amplitude: float) -> None:
    # 1024 samples: the third power of the cell, 2e-7 of the period's 2π, times the slopes' change of order 1.
    assert fundamental(amplitude, 1.0, 1024, 0.123) == pytest.approx(describing_function(amplitude, 1.0), abs=1e-6)


def test_sums_converge_with_the_third_power_of_the_cell() -> None:
    def worst(samples: int) -> float:
        shifts = np.linspace(0, 1 / samples, 23)
        exact = describing_function(2.0, 1.0)
        return max(abs(fundamental(2.0, 1.0, samples, float(s)) - exact) for s in shifts)

    # Plain sampling is of second order; a little less than 3 is found where the worst shift changes between grids.
    assert log2(worst(64) / worst(1024)) / 4 > 2.7


def test_sums_have_no_jump_of_slope_where_a_corner_passes_a_sample() -> None:
    # The corner lies on a sample at shift 0; plain sampling changes the slope of the sum there by 1 of 64 samples.
    phases, step = np.arange(64) / 64, 1e-6
    level = float(2 * np.cos(2 * np.pi * 5 / 64))

    def total(lift: float) -> float:
        return float(dead_zone(2 * np.cos(2 * np.pi * phases) + lift, level)[0].sum())

    before, after = (total(0.0) - total(-step)) / step, (total(step) - total(0.0)) / step
    assert after - before == pytest.approx(0.0, abs=0.05)


@given(st.floats(0.1, 3.0), st.floats(-2.0, 2.0), st.floats(0.0, 2.0))
def test_slope_is_the_derivative_of_the_sum(amplitude: float, mean: float, half: float) -> None:
    delta = mean + amplitude * np.cos(2 * np.pi * (np.arange(256) + 0.3) / 256)
    lift = 1e-7
    higher, lower = (dead_zone(delta + s * lift, half)[0].sum() for s in (1, -1))
    # Of 256 samples; tangency of δ and b within a cell is the worst case and costs about one of them.
    assert dead_zone(delta, half)[1].sum() == pytest.approx((higher - lower) / (2 * lift), abs=2.0)


@given(st.floats(0.1, 3.0), st.floats(-2.0, 2.0))
def test_without_backlash_nothing_is_taken_off(amplitude: float, mean: float) -> None:
    delta = mean + amplitude * np.cos(2 * np.pi * (np.arange(64) + 0.3) / 64)
    beyond, contact = dead_zone(delta, 0.0)
    assert np.allclose(beyond, delta, atol=1e-12)
    assert np.allclose(contact, 1.0, atol=1e-12)


def test_a_motion_within_the_backlash_meets_no_force() -> None:
    beyond, contact = dead_zone(0.9 * np.cos(2 * np.pi * np.arange(32) / 32), 1.0)
    assert not beyond.any()
    assert not contact.any()
