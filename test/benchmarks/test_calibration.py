"""The calibration loop: that it does all its steps, and what they come to."""

from math import asin, sin, sqrt

import pytest

from benchmarks.calibration import GROWTH, START, calibration_run, calibration_seconds, logistic


@pytest.mark.parametrize("count", [0, 1, 2, 999, 1000, 10_001])
def test_every_step_is_made_as_it_stands(count: int) -> None:
    # To the bit: a loop that was folded, reordered or fused rounds otherwise, which 10 000 chaotic steps would show.
    x = START
    for _ in range(count):
        x = GROWTH * x * (1.0 - x)
    assert logistic(START, GROWTH, count) == x


def test_it_is_the_logistic_map() -> None:
    # At growth 4 the map is sin² of a doubled angle (Ulam & von Neumann 1947); 8 doublings magnify rounding 256-fold.
    start = 0.3
    assert logistic(start, 4.0, 8) == pytest.approx(sin(2**8 * asin(sqrt(start))) ** 2, abs=256 * 1e-15)


def test_the_orbit_comes_to_no_rest() -> None:
    orbit = {logistic(START, GROWTH, count) for count in range(2000)}
    assert len(orbit) == 2000
    assert all(0.0 < x < 1.0 for x in orbit)


def test_a_run_says_how_much_it_did() -> None:
    assert calibration_run(1000) == 1000.0


def test_seconds_are_of_the_whole_unit() -> None:
    assert 0.0 < calibration_seconds(steps=1000, repeats=1) < float("inf")
