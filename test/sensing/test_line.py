"""Lines and means through the last samples, and noise from second differences, against NumPy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import linregress

from seat_gear_dynamics.sensing.differences import Differences
from seat_gear_dynamics.sensing.line import Samples

VALUES = st.lists(st.floats(-1e4, 1e4), min_size=3, max_size=400)


def filled(values: list[float], window: float = 0.3, rate: float = 100.0, *, held: bool = False) -> Samples:
    samples = Samples(window, held=held)
    for k, value in enumerate(values):
        samples.add(k / rate, value)
    return samples


@given(VALUES, st.integers(3, 40))
def test_a_line_is_least_squares_over_the_window_or_a_part_of_it(values: list[float], last: int) -> None:
    samples, n = filled(values), min(len(values), 31, last)
    time, kept = np.arange(len(values))[-n:] / 100, np.array(values)[-n:]
    line = samples.line(float(time[0]))
    slope, level = np.polyfit(time - time.mean(), kept, 1)
    # Rounding of sums of up to 31 numbers of 1e4: 1e-10; over the least spread of times, 0.01 s, a hundred times more.
    assert line.samples == n
    assert line.mean == pytest.approx(level, abs=1e-8)
    assert line.slope == pytest.approx(slope, abs=1e-6)
    assert line.square == pytest.approx(((time - time.mean()) ** 2).sum(), rel=1e-9)
    assert line.after == pytest.approx(time[-1] - time.mean(), rel=1e-9)


@given(st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=40), st.integers(6, 20))
def test_a_rise_has_the_slope_and_the_standard_error_of_a_regression(values: list[float], last: int) -> None:
    n = min(len(values), last)
    time, kept = np.arange(len(values))[-n:] / 100, np.array(values)[-n:]
    rise = filled(values, window=1.0).rise(float(time[0]), 6)
    assert rise is not None
    found = None if np.ptp(kept) == 0 else linregress(time, kept)
    # Rounding as of a line, and of a square root where all samples lie on it: sqrt(1e-13) · 1e3 over 0.04 s.
    assert rise.slope == pytest.approx(found.slope if found else 0.0, abs=1e-6)
    assert rise.error == pytest.approx(found.stderr if found else 0.0, rel=1e-6, abs=1e-2)
    assert rise.square == pytest.approx(((time - time.mean()) ** 2).sum(), rel=1e-9)
    whole = abs(kept[-1] - kept[0])
    assert rise.largest == (pytest.approx(np.abs(np.diff(kept)).max() / whole) if whole else np.inf)


def test_a_rise_takes_so_many_samples_at_least_and_is_none_without_them() -> None:
    values = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]
    assert filled(values[:5]).rise(0.0, 6) is None
    six, three = filled(values).rise(0.055, 6), filled(values).rise(0.035, 3)
    assert six is not None
    assert three is not None
    assert six.slope == pytest.approx(linregress(np.arange(6) / 100, values[1:]).slope)
    assert three.slope == pytest.approx(100.0)
    assert three.largest == pytest.approx(1 / 2)


@given(st.floats(-1e4, 1e4))
def test_a_steady_value_has_no_slope_without_any_rounding(value: float) -> None:
    assert filled([value] * 50).line().slope == 0.0


def test_samples_older_than_the_window_are_forgotten_and_room_grows() -> None:
    samples = filled(list(range(5000)), window=1.0, rate=2000.0)
    assert len(samples) == 2001
    assert samples.first == pytest.approx(4999 / 2000 - 1.0)
    assert samples.line().slope == pytest.approx(2000.0)


def test_none_and_equal_times_give_no_slope() -> None:
    samples = Samples(1.0)
    assert samples.line() == (0, 0.0, 0.0, 0.0, 0.0)
    assert samples.mean(0.0) == (0.0, 0)
    samples.add(0.0, 1.0)
    samples.add(0.0, 3.0)
    assert samples.line()[:3] == (2, 2.0, 0.0)


def test_a_mean_knows_how_many_measurements_it_is_of() -> None:
    values = [1.0, 1.0, 3.0, 3.0, 3.0]
    for held, measurements in ((False, 5), (True, 2)):
        mean, count = filled(values, held=held).mean()
        assert mean == pytest.approx(2.2)
        assert count == measurements
    assert filled(values, held=True).mean(0.035) == (3.0, 1)


@given(st.lists(st.floats(-1e3, 1e3), min_size=16, max_size=80), st.integers(0, 2**31))
def test_noise_is_the_median_of_second_differences(values: list[float], seed: int) -> None:
    steps = np.random.default_rng(seed).uniform(0.005, 0.03, len(values))
    time, found = np.cumsum(steps), Differences()
    for t, value in zip(time.tolist(), values, strict=True):
        found.add(t, value)
    t, x = time[-32:], np.array(values)[-32:]
    after = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
    off = np.abs(x[1:-1] - ((1 - after) * x[:-2] + after * x[2:])) / np.sqrt(1 + (1 - after) ** 2 + after**2)
    assert found.robust() == float(np.median(off)) / 0.6744897501960817  # the same operations in the same order
    assert found.average() == pytest.approx(float(off.mean()) / np.sqrt(2 / np.pi), rel=1e-12, abs=1e-12)


def test_the_average_is_the_deviation_of_white_noise_and_sees_a_coarse_sensor() -> None:
    found = []
    for seed in range(60):
        each = Differences()
        for k, value in enumerate(np.random.default_rng(seed).normal(0, 5.0, 60).tolist()):
            each.add(k / 100, value)
        found.append(each.average())
    # The mean of 30 correlated values scatters by about a sixth of itself, over 60 runs by 0.02: four of these.
    assert np.mean(found) == pytest.approx(5.0, rel=0.09)
    coarse = Differences()
    for k in range(60):
        coarse.add(k / 100, 20.0 * (k % 8 == 0))
    assert coarse.robust() == 0.0
    assert coarse.average() > 2.0


def test_old_samples_say_nothing_of_the_noise() -> None:
    found = Differences()
    for k in range(32):
        found.add(k / 100, float(k % 2))
    assert found.average() > 0
    found.add(10.0, 0.0)
    assert (found.robust(), found.average()) == (0.0, 0.0)
