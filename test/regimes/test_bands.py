"""Forbidden bands from probabilities along the speed, and the intervals of shares."""

from itertools import pairwise
from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.regimes.bands import MapBand, binomial_error, forbidden_bands, wilson_interval

SPEEDS = np.arange(10.0, 110.0, 10.0)


def bands(chaos: list[float], threshold: float = 0.5) -> tuple[MapBand, ...]:
    p = np.array(chaos)
    return forbidden_bands(SPEEDS[: len(p)], p, p, p, threshold=threshold, load=600.0)


# Newcombe 1998, Statistics in Medicine 17, 857-872, table I, method 3, printed to four places.
@pytest.mark.parametrize(
    ("successes", "samples", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilsons_interval_is_the_published_one(successes: int, samples: int, low: float, high: float) -> None:
    found = wilson_interval(successes / samples, samples)
    assert [float(each) for each in found] == pytest.approx([low, high], abs=5e-5)


@given(st.floats(0, 1), st.integers(1, 10_000), st.floats(0.5, 0.999))
def test_the_interval_holds_the_share_and_mirrors_with_it(share: float, samples: int, confidence: float) -> None:
    low, high = wilson_interval(share, samples, confidence=confidence)
    mirrored_low, mirrored_high = wilson_interval(1 - share, samples, confidence=confidence)
    rounding = 1e-12
    assert 0 <= low <= share + rounding
    assert share - rounding <= high <= 1
    assert float(mirrored_low) == pytest.approx(1 - float(high), abs=1e-9)
    assert float(mirrored_high) == pytest.approx(1 - float(low), abs=1e-9)


@pytest.mark.parametrize(
    ("share", "samples", "confidence"), [(0.5, 0, 0.95), (1.1, 5, 0.95), (float("nan"), 5, 0.95), (0.5, 5, 1.0)]
)
def test_impossible_shares_samples_and_confidences_are_refused(share: float, samples: int, confidence: float) -> None:
    with pytest.raises(ValueError, match="expected shares from 0 to 1, at least one sample"):
        wilson_interval(share, samples, confidence=confidence)


def test_the_binomial_error_is_that_of_a_tossed_coin() -> None:
    assert binomial_error(0.5, 100) == 0.05
    assert binomial_error(1.0, 100) == 0.0
    with pytest.raises(ValueError, match="of 0 samples"):
        binomial_error(0.5, 0)


def test_a_band_ends_halfway_between_calm_and_chaotic_speeds() -> None:
    (found,) = bands([0, 0, 1, 1, 1, 0, 0])
    assert isinstance(found, ForbiddenBand)
    assert (found.low, found.high, found.load) == (25.0, 55.0, 600.0)
    assert (found.low_error, found.high_error) == (5.0, 5.0)
    assert not found.open_low
    assert not found.open_high


def test_a_single_chaotic_speed_is_a_band_of_one_step() -> None:
    (found,) = bands([0, 0, 1, 0])
    assert (found.low, found.high) == (25.0, 35.0)


def test_bands_one_step_apart_are_one_and_two_steps_apart_are_two() -> None:
    assert [(b.low, b.high) for b in bands([0, 1, 0, 1, 0])] == [(15.0, 45.0)]
    assert [(b.low, b.high) for b in bands([0, 1, 0, 0, 1, 0])] == [(15.0, 25.0), (45.0, 55.0)]


def test_a_band_that_reaches_the_maps_end_is_open_there() -> None:
    first, last = bands([1, 0, 0, 0, 1])
    assert (first.low, first.high, first.open_low, first.open_high) == (10.0, 15.0, True, False)
    assert (last.low, last.high, last.open_low, last.open_high) == (45.0, 50.0, False, True)
    (whole,) = bands([1, 1, 1])
    assert (whole.low, whole.high, whole.open_low, whole.open_high) == (10.0, 30.0, True, True)
    assert bands([0, 0, 0]) == ()


def test_the_edge_is_where_the_probability_crosses_the_threshold() -> None:
    (found,) = bands([0.0, 0.4, 0.8, 0.8], threshold=0.5)
    assert found.low == pytest.approx(22.5)
    (found,) = bands([0.0, 0.4, 0.8, 0.8], threshold=0.2)
    assert found.low == pytest.approx(15.0)


def test_errors_reach_to_where_the_bounds_cross() -> None:
    p = np.array([0.0, 0.0, 0.4, 0.8, 1.0, 1.0])
    lower, upper = np.clip(p - 0.3, 0, 1), np.clip(p + 0.3, 0, 1)
    (found,) = forbidden_bands(SPEEDS[:6], p, lower, upper, threshold=0.5, load=1.0)
    # Linear crossings of 0.5: of p in 30-40 at 1/4, of the upper bound in 20-30 at 1/2, of the lower at 40 exactly.
    assert found.low == pytest.approx(32.5)
    assert found.low_error == pytest.approx(max(5.0, 32.5 - 25.0, 40.0 - 32.5))
    assert found.high_error == pytest.approx(5.0)


def test_a_band_that_is_nowhere_sure_is_uncertain_by_half_its_width() -> None:
    p = np.array([0.0, 0.6, 0.6, 0.6, 0.6, 0.0])
    (found,) = forbidden_bands(SPEEDS[:6], p, np.zeros(6), p, threshold=0.5, load=1.0)
    assert found.low_error == pytest.approx((found.high - found.low) / 2)


@given(st.lists(st.floats(0, 1), min_size=2, max_size=10), st.floats(0.05, 1.0))
def test_bands_hold_every_speed_at_or_above_the_threshold_and_are_apart(chaos: list[float], threshold: float) -> None:
    found = bands(chaos, threshold)
    slack = 1e-9 * SPEEDS[-1]  # rounding of interpolated edges
    for speed, p in zip(SPEEDS, chaos, strict=False):
        if p >= threshold:
            assert any(b.low - slack <= speed <= b.high + slack for b in found)
    for first, second in pairwise(found):
        assert second.low - first.high > 10.0
    assert all(b.low <= b.high and min(b.low_error, b.high_error) >= 5.0 for b in found)


@given(st.lists(st.tuples(st.floats(0.1, 10), st.floats(0, 1)), min_size=2, max_size=10), st.integers(1, 50))
def test_wider_bounds_move_no_edge_and_make_none_surer(nodes: list[tuple[float, float]], samples: int) -> None:
    steps, chaos = (np.array(each) for each in zip(*nodes, strict=True))
    speeds = np.cumsum(steps)
    exact = forbidden_bands(speeds, chaos, chaos, chaos, threshold=0.5, load=1.0)
    unsure = forbidden_bands(speeds, chaos, *wilson_interval(chaos, samples), threshold=0.5, load=1.0)
    for sure, wide in zip(exact, unsure, strict=True):
        assert (sure.low, sure.high) == (wide.low, wide.high)
        assert wide.low_error >= sure.low_error
        assert wide.high_error >= sure.high_error


def test_bands_merged_over_uneven_steps_keep_their_errors() -> None:
    # The band's two parts are less than the widest step apart, the upper bound's are not: they are not merged.
    speeds = np.array([0.0, 10.0, 11.0, 12.0, 13.0])
    p, upper = np.array([1.0, 0.45, 0.0, 1.0, 1.0]), np.array([1.0, 0.55, 0.0, 1.0, 1.0])
    (found,) = forbidden_bands(speeds, p, p, upper, threshold=0.5, load=1.0)
    assert (found.low, found.high) == (0.0, 13.0)
    assert (found.low_error, found.high_error) == (5.0, 0.5)


def test_the_error_of_a_share_shrinks_with_the_root_of_the_samples() -> None:
    assert binomial_error(0.3, 400) == pytest.approx(binomial_error(0.3, 100) / 2)
    low, high = wilson_interval(0.3, 1_000_000)
    # For many samples the interval becomes the normal one; what is left of the difference is of order 1/samples.
    assert float(high - low) / 2 == pytest.approx(1.959964 * sqrt(0.21) / 1000, rel=1e-4)
