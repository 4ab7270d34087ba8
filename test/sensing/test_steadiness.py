"""Whether a noisy quantity stands: steps at once, drifts by their means, ramps by their slope, noise never."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.sensing.steadiness import Standing


def moves(values: Sequence[float], *, rate: float = 100.0, held: bool = False, floor: float = 10.0) -> list[int]:
    """Return the samples at which a quantity with a tolerance of 5 % was found to have moved."""
    standing = Standing(0.05, floor, held=held)
    return [k for k, value in enumerate(values) if standing.moved(k / rate, value)]


def noise(seed: int, n: int, deviation: float = 5.0) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, deviation, n)


@given(level=st.floats(-1000, 1000), inside=st.floats(-0.99, 0.99))
def test_without_noise_a_quantity_moves_where_it_leaves_the_tolerance_and_not_before(
    level: float, inside: float
) -> None:
    allowed = max(0.05 * abs(level), 10.0)
    assert moves([level] * 5 + [level + inside * allowed] * 5) == []
    assert moves([level] * 5 + [level + 1.01 * allowed + 1e-9] * 5) == [5]


def test_a_step_beyond_the_noise_is_seen_with_its_first_sample() -> None:
    for seed in range(20):
        values = 150.0 + noise(seed, 200)
        values[150:] += 80.0
        assert 150 in moves(values.tolist())


def test_noise_alone_moves_next_to_nothing() -> None:
    # 40 runs of 10 s; before 16 samples no noise is known, and what is beyond the floor then counts. Each of these
    # takes 0.3 s from the record: 2 % of the time are 26 of them.
    found = [k for seed in range(40) for k in moves((150.0 + noise(seed, 1000)).tolist()) if k > 40]
    assert len(found) * 0.3 / 400 < 0.02


@pytest.mark.parametrize("deviation", [0.5, 5.0, 10.0])
def test_a_smaller_step_that_noise_hides_is_found_by_its_mean(deviation: float) -> None:
    # Means of 10 and 20 samples differ by 0.39 deviations of noise; four of these and the floor are 1.55 and 10, and
    # the mean of the last tenth of a second is above that by three of its errors once the step is 3 deviations more.
    values = 150.0 + noise(3, 300, deviation)
    values[150:] += 10.0 + 3 * deviation
    first = [k for k in moves(values.tolist()) if k >= 150]
    assert first
    assert first[0] <= 150 + 12


@pytest.mark.parametrize(("slope", "within"), [(60.0, 0.32), (200.0, 0.2)])
def test_a_ramp_is_told_by_its_slope_in_spite_of_noise(slope: float, within: float) -> None:
    # The slope of n samples at 100 a second has the standard error 5·100·sqrt(12/n³): 10 a second over 0.3 s, of which
    # 60 is six, and 30 over the least of 0.15 s, of which 200 is more than six: the fourth is reached before the end.
    values = 150.0 + noise(5, 300)
    values[150:] += slope * np.arange(150) / 100
    first = [k for k in moves(values.tolist()) if k >= 150]
    assert first
    assert (first[0] - 150) / 100 <= within + 0.15  # the window has to be filled by the ramp


def test_a_slow_drift_is_measured_from_where_the_record_began() -> None:
    # 2 N·m/s lead nowhere in half a second; from 150 N·m on 10 N·m are used up after 5 s.
    (first, *_) = moves((150.0 + 0.02 * np.arange(1000)).tolist())
    # The mean of the first 0.2 s stands for where it began: 0.1 s late, and a sample.
    assert first / 100 == pytest.approx(5.0 + 0.1, abs=0.011)


def test_coarse_steps_of_a_sensor_are_no_movement() -> None:
    # 20 r/min between two readings of a speed that lies between them, a tolerance of 1 %: half of the samples are off.
    counts = np.floor(np.arange(1001) * 57.3)
    standing = Standing(0.01, 5.0)
    speed = 20.0 * np.diff(counts)
    found = [k for k, value in enumerate(speed.tolist()) if standing.moved(k / 100, value)]
    assert [k for k in found if k > 40] == []


def test_a_value_held_between_its_measurements_counts_once() -> None:
    # A load that comes 20 times a second under a speed that comes 100 times: five equal samples are one measurement.
    # Taken for five, their mean and slope would seem surer by the square root of five, 1.8 errors for 4.
    loads = [np.repeat(150.0 + noise(seed, 200), 5).tolist() for seed in range(10)]
    once, five = (sum(k > 120 for load in loads for k in moves(load, held=held)) for held in (True, False))
    assert once * 0.3 / 88 < 0.05
    assert five > 2 * once


def test_the_first_sample_begins_and_forgetting_begins_anew() -> None:
    standing = Standing(0.05, 10.0)
    assert not standing.moved(0.0, 150.0)
    assert standing.moved(0.01, 600.0)
    standing.forget()
    assert not standing.moved(0.0, 900.0)
