"""The 0-1 test on series whose kind is known, against its formula written plainly."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.zero_one import ZeroOne, zero_one

Array = NDArray[np.float64]
GOLDEN = (5**0.5 - 1) / 2


def seeded(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def logistic(points: int, r: float) -> Array:
    x, series = 0.3123, []
    for n in range(points + 1000):
        x = r * x * (1 - x)
        if n >= 1000:
            series.append(x)
    return np.array(series)


def turning(points: int, turns: float) -> Array:
    return np.asarray(np.cos(2 * pi * turns * np.arange(points)))


def plainly(series: Array, c: float) -> float:
    """K of one c as Gottwald & Melbourne 2009 write it down, sum by sum."""
    n, longest = len(series), len(series) // 10
    p = [sum(series[j] * cos((j + 1) * c) for j in range(m)) for m in range(1, n + 1)]
    q = [sum(series[j] * sin((j + 1) * c) for j in range(m)) for m in range(1, n + 1)]
    displacement = []
    for m in range(1, longest + 1):
        squares = [(p[j + m] - p[j]) ** 2 + (q[j + m] - q[j]) ** 2 for j in range(n - longest)]
        oscillation = np.mean(series) ** 2 * (1 - cos(m * c)) / (1 - cos(c))
        displacement.append(sum(squares) / (n - longest) - oscillation)
    return float(np.corrcoef(np.arange(1, longest + 1), displacement)[0, 1])


@pytest.mark.parametrize("series", [logistic(120, 3.97), logistic(120, 3.5), turning(120, GOLDEN) + 0.3])
def test_value_is_the_median_of_the_published_formula(series: Array) -> None:
    each = [plainly(series, c) for c in seeded(4).uniform(pi / 5, 4 * pi / 5, 5)]
    found = zero_one(series, seeded(4), frequencies=5)
    # Sums of 120 terms in another order: rounding only.
    assert found.value == pytest.approx(np.median(each), abs=1e-9)
    assert found.spread == pytest.approx(np.subtract(*np.quantile(each, [0.75, 0.25])), abs=1e-9)


def test_a_resonant_cosine_walks_straight_on_and_gives_the_correlation_of_squares_with_steps() -> None:
    # With c its own frequency the walk is j/2 along and bounded across: the displacement is m²/4 plus a bounded part,
    # which for 2000 points and m up to 200 is a share of 1e-4 of it.
    c = seeded(3).uniform(pi / 5, 4 * pi / 5, 1)[0]
    steps = np.arange(1, 201)
    expected = np.corrcoef(steps, steps**2)[0, 1]
    found = zero_one(np.cos(c * np.arange(2000)), seeded(3), frequencies=1)
    assert found.value == pytest.approx(expected, abs=1e-3)
    assert found.spread == 0


@pytest.mark.parametrize(("r", "verdict", "near"), [(3.55, "regular", 0.0), (3.97, "chaotic", 1.0)])
def test_logistic_map_has_the_values_of_the_literature(r: float, verdict: str, near: float) -> None:
    # Gottwald & Melbourne take r = 3.55 for a regular and 3.97 for a chaotic motion. K leaves 0 and 1 by the scatter of
    # correlations over n/10 = 200 steps, 1/√200 = 0.07 at most.
    found = zero_one(logistic(2000, r), seeded())
    assert found.value == pytest.approx(near, abs=0.07)
    assert (found.verdict, found.samples) == (verdict, 2000)


@pytest.mark.parametrize("turns", [GOLDEN, 2**0.5 - 1, 0.05, 0.31831])
def test_quasi_periodic_motion_is_regular(turns: float) -> None:
    assert zero_one(turning(1000, turns) + 0.5 * turning(1000, 2 * turns), seeded()).verdict == "regular"


def test_noise_is_as_irregular_as_chaos() -> None:
    assert zero_one(seeded(9).normal(size=1000), seeded()).verdict == "chaotic"


@pytest.mark.parametrize("value", [0.0, 1.0, -3.7e5])
def test_a_constant_is_regular_without_spread(value: float) -> None:
    assert zero_one(np.full(400, value), seeded()) == ZeroOne(0.0, 0.0, 400)


@settings(max_examples=20)
@given(st.floats(1e-6, 1e6), st.booleans())
def test_the_unit_of_the_series_does_not_matter(scale: float, mirrored: bool) -> None:
    series = logistic(400, 3.7)
    expected = zero_one(series, seeded()).value
    assert zero_one(series * (-scale if mirrored else scale), seeded()).value == pytest.approx(expected, abs=1e-9)


def test_equal_generators_give_equal_results_and_others_differ_within_the_spread() -> None:
    series = logistic(400, 3.6)
    first, again, other = (zero_one(series, seeded(seed)) for seed in (1, 1, 2))
    assert first == again
    assert first.value != other.value
    assert first.spread is not None
    assert first.value == pytest.approx(other.value, abs=first.spread)


def test_an_oversampled_series_looks_regular_which_is_why_a_section_is_asked_for() -> None:
    chaos = logistic(100, 3.97)
    smooth = np.interp(np.arange(0, 99, 0.05), np.arange(100), chaos)
    assert zero_one(chaos, seeded()).value == pytest.approx(1, abs=0.1)
    found = zero_one(smooth, seeded()).value
    assert found is not None
    assert found < 0.5


@pytest.mark.parametrize("points", [0, 1, 99])
def test_a_series_too_short_has_no_value_and_is_undecided(points: int) -> None:
    found = zero_one(np.arange(float(points)), seeded())
    assert found == ZeroOne(None, None, points)
    assert found.verdict == "undecided"


def test_a_series_of_a_few_hundred_points_has_a_value_but_no_verdict() -> None:
    found = zero_one(logistic(299, 3.97), seeded())
    assert found.value == pytest.approx(1, abs=0.1)
    assert found.verdict == "undecided"
    assert zero_one(logistic(300, 3.97), seeded()).verdict == "chaotic"


@pytest.mark.parametrize(
    ("value", "verdict"),
    [(-0.3, "regular"), (0.2, "regular"), (0.21, "undecided"), (0.79, "undecided"), (0.8, "chaotic")],
)
def test_between_regular_and_chaotic_it_is_undecided(value: float, verdict: str) -> None:
    assert ZeroOne(value, 0.0, 1000).verdict == verdict


@pytest.mark.parametrize("series", [np.full(200, np.nan), np.array([np.inf] * 200), np.zeros((200, 2))])
def test_series_that_are_no_finite_row_are_refused(series: Array) -> None:
    with pytest.raises(ValueError, match="expected one dimension of finite values"):
        zero_one(series, seeded())


def test_a_test_without_frequencies_is_refused() -> None:
    with pytest.raises(ValueError, match="with 0 frequencies; expected at least 1"):
        zero_one(logistic(200, 3.9), seeded(), frequencies=0)


def test_golden_value() -> None:
    # Logistic map in its two bands, 400 points, 100 frequencies of seed 0.
    found = zero_one(logistic(400, 3.6), seeded())
    assert found.value == pytest.approx(0.5068781424, abs=1e-9)
    assert found.spread == pytest.approx(0.4694854022, abs=1e-9)
