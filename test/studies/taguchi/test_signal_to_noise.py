"""Signal-to-noise ratios against their definitions."""

from collections.abc import Callable
from math import log10

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.studies.taguchi import (
    larger_the_better,
    nominal_the_best,
    signed_nominal_the_best,
    smaller_the_better,
)

POSITIVE = st.lists(st.floats(1e-3, 1e3), min_size=2, max_size=6)
SCATTERED = POSITIVE.filter(lambda y: np.std(y) > 1e-3 * np.mean(y))
# Ratios are logarithms of sums of a few squares: a dozen roundings of 1e-16, and of 1e-13 where a variance cancels
# down to a millionth of the mean square (SCATTERED), in dB.
ROUNDING = 1e-8


@given(st.floats(1e-3, 1e3), st.integers(1, 5))
def test_equal_observations_give_their_own_level(value: float, repeats: int) -> None:
    assert float(smaller_the_better([value] * repeats)) == pytest.approx(-20 * log10(value), abs=ROUNDING)
    assert float(larger_the_better([value] * repeats)) == pytest.approx(20 * log10(value), abs=ROUNDING)


@given(POSITIVE)
def test_larger_the_better_is_smaller_the_better_of_the_inverse(y: list[float]) -> None:
    inverse = 1 / np.array(y)
    assert float(larger_the_better(y)) == pytest.approx(float(smaller_the_better(inverse)), abs=ROUNDING)


@given(SCATTERED, st.floats(0.1, 10))
def test_nominal_the_best_does_not_depend_on_the_unit(y: list[float], factor: float) -> None:
    assert float(nominal_the_best(np.array(y) * factor)) == pytest.approx(float(nominal_the_best(y)), abs=ROUNDING)


@given(SCATTERED, st.floats(-1.0, 1.0))
def test_the_signed_form_does_not_depend_on_the_level(y: list[float], share: float) -> None:
    moved = np.array(y) + share * max(y)
    # The shift is of the size of the observations, so that it costs the variance no more digits than it had lost.
    assert float(signed_nominal_the_best(moved)) == pytest.approx(float(signed_nominal_the_best(y)), abs=ROUNDING)


def test_ratios_are_those_calculated_by_hand() -> None:
    # y = 1, 2, 3: mean square 14/3, mean inverse square (1 + 1/4 + 1/9)/3 = 49/108, mean 2, variance 1.
    y = [1.0, 2.0, 3.0]
    assert float(smaller_the_better(y)) == pytest.approx(-10 * log10(14 / 3), abs=ROUNDING)
    assert float(larger_the_better(y)) == pytest.approx(-10 * log10(49 / 108), abs=ROUNDING)
    assert float(nominal_the_best(y)) == pytest.approx(10 * log10(4), abs=ROUNDING)
    assert float(signed_nominal_the_best(y)) == pytest.approx(0.0, abs=ROUNDING)


@pytest.mark.parametrize("ratio", [smaller_the_better, larger_the_better, nominal_the_best, signed_nominal_the_best])
def test_the_last_axis_is_that_of_the_observations(ratio: Callable[[object], np.ndarray]) -> None:
    y = np.array([[1.0, 2.0, 3.0], [4.0, 6.0, 5.0]])
    assert ratio(y).tolist() == [float(ratio(row)) for row in y]


@pytest.mark.parametrize(
    ("ratio", "observations", "said"),
    [
        (smaller_the_better, [], "has 0 observations, expected at least 1"),
        (smaller_the_better, 3.0, "has 0 observations, expected at least 1"),
        (smaller_the_better, [1.0, float("nan")], "not a finite number"),
        (smaller_the_better, [1.0, -2.0], "is -2, expected at least 0"),
        (smaller_the_better, [0.0, 0.0], "infinite: all observations of a run are 0"),
        (larger_the_better, [1.0, 0.0], "is 0, expected more than 0"),
        (larger_the_better, [1.0, float("inf")], "not a finite number"),
        (nominal_the_best, [1.0], "has 1 observations, expected at least 2"),
        (nominal_the_best, [2.0, 2.0], "infinite: the observations of a run do not scatter"),
        (nominal_the_best, [-1.0, 1.0], "The mean of a run is 0"),
        (signed_nominal_the_best, [1.0], "has 1 observations, expected at least 2"),
        (signed_nominal_the_best, [2.0, 2.0], "do not scatter"),
    ],
)
def test_observations_without_a_ratio_are_refused(
    ratio: Callable[[object], np.ndarray], observations: object, said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        ratio(observations)
