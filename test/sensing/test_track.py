"""Level, slope and noise of a measured quantity, told apart."""

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.sensing.track import Track


def fed(values: np.ndarray, *, rate: float = 100.0, held: bool = False) -> Track:
    track = Track(0.3, held=held)
    for n, value in enumerate(values.tolist()):
        track.add(n / rate, value)
    return track


@given(st.floats(-500, 500), st.floats(-1000, 1000))
def test_a_ramp_has_its_slope_and_no_noise(start: float, slope: float) -> None:
    track = fed(start + slope * np.arange(60) / 100)
    # Rounding of values up to 1100 is 2e-13; a slope over 0.3 s and differences magnify it some hundred times.
    assert track.slope() == pytest.approx(slope, abs=1e-9)
    assert track.noise == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("slope", [0.0, 200.0])
def test_the_noise_of_a_drive_is_its_standard_deviation_whatever_its_slope(slope: float) -> None:
    found = []
    for seed in range(60):
        noise = np.random.default_rng(seed).normal(0, 5.0, 60)
        found.append(fed(1000 + slope * np.arange(60) / 100 + noise).noise)
    # The median of 30 correlated values scatters by about 0.2 of itself, its mean over 60 runs by 0.026: four of these.
    assert np.mean(found) == pytest.approx(5.0, rel=0.11)


def test_spikes_and_a_step_are_no_noise() -> None:
    values = np.zeros(60)
    values[[40, 50]] = 50.0
    assert fed(values).noise == 0.0
    values = np.where(np.arange(60) < 50, 0.0, 100.0)
    assert fed(values).noise == 0.0


def test_a_few_samples_show_no_noise() -> None:
    assert fed(np.random.default_rng(0).normal(0, 5, 15)).noise == 0.0
    assert fed(np.random.default_rng(0).normal(0, 5, 18)).noise > 0.0


def test_a_fitted_level_is_surer_than_a_sample_by_what_theory_says() -> None:
    ends = np.array([fed(np.random.default_rng(seed).normal(100, 5.0, 60)).fitted for seed in range(400)])
    track = fed(np.random.default_rng(0).normal(100, 5.0, 60))
    # The end of a line through n samples has the standard error sigma·sqrt(1/n + (n-1)²/4/(n(n²-1)/12)); n = 15 or 16.
    n = 16
    expected = 5.0 * np.sqrt(1 / n + ((n - 1) / 2) ** 2 / (n * (n * n - 1) / 12))
    # 400 draws give a deviation to 3.5 %; jumps beyond six deviations and n = 15 add some.
    assert ends.std() == pytest.approx(expected, rel=0.15)
    assert track.error / track.noise == pytest.approx(expected / 5.0, rel=0.05)


def test_a_step_is_followed_at_once() -> None:
    values = np.random.default_rng(1).normal(0, 1.0, 60)
    values[-1] += 100.0
    track = fed(values)
    assert track.fitted == values[-1]
    track.add(0.6, 100.0)
    assert track.fitted == pytest.approx(100.0, abs=10)


def test_held_values_are_measured_where_they_change() -> None:
    measured = np.random.default_rng(2).normal(600, 5.0, 40)
    every = fed(np.repeat(measured, 4), held=True)
    assert every.noise == pytest.approx(fed(measured, rate=25.0).noise, rel=0.6)
    assert every.noise > 1.0
    assert fed(np.repeat(measured, 4)).noise == 0.0


def test_a_slope_within_its_error_is_not_believed() -> None:
    noisy = fed(np.random.default_rng(4).normal(1000, 5.0, 60))
    assert noisy.slope() != 0.0
    assert noisy.sure_slope() == 0.0
    ramp = 200 * np.arange(60) / 100
    assert fed(ramp + np.random.default_rng(4).normal(1000, 5.0, 60)).sure_slope() == pytest.approx(200, abs=45)


def beginnings(values: np.ndarray, rate: float = 100.0) -> np.ndarray:
    """Return for each sample whether a slope has begun, which is not so much as asked for 0.15 s."""
    track, found = Track(0.3), []
    for n, value in enumerate(values.tolist()):
        track.add(n / rate, value)
        found.append(track.begun() is not None and track.spans_half)
    return np.array(found)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("sign", [1, -1])
def test_a_ramp_that_begins_shows_in_half_a_tenth_of_a_second(seed: int, sign: int) -> None:
    noise, ramp = np.random.default_rng(seed).normal(0, 0.5, 120), np.maximum(np.arange(120) - 99, 0) * 2.0
    found = beginnings(1400 + sign * ramp + noise)
    assert not found[:100].any()
    assert np.argmax(found) <= 105
    assert found[105:].all(), "it goes on being seen"
    track = fed(1400 + sign * ramp + noise)
    # At its last sample the sixth of the window holds the ramp alone: 200 ± 0.5/sqrt(17.5e-4) = 12, four of these.
    assert track.begun() == pytest.approx(sign * 200, abs=48)
    assert abs(fed((1400 + sign * ramp + noise)[:108]).slope()) < 60


def test_noise_begins_nothing_that_lasts() -> None:
    # Ten minutes. The noise is itself an estimate, so five errors are exceeded some thirty times an hour, but not for
    # the four samples that outlast the debounce of 0.03 s.
    found = beginnings(np.random.default_rng(3).normal(1000, 0.5, 60_000))
    lasted = [len(list(samples)) for begun, samples in groupby(found) if begun]
    assert len(lasted) < 15
    assert max(lasted, default=0) <= 3


@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
def test_neither_a_step_nor_one_of_a_sensor_is_a_slope_that_begins(rate: float) -> None:
    noise = np.random.default_rng(4).normal(0, 0.2, 400)
    step = np.where(np.arange(400) < 200, 0.0, 20.0)
    assert not beginnings(1000 + step + noise, rate).any()
    assert not beginnings(1000 + step, rate).any()


def test_where_six_samples_reach_beyond_the_window_nothing_is_seen_to_begin() -> None:
    assert not beginnings(100.0 * np.arange(60), rate=15.0).any()


def test_a_reset_forgets() -> None:
    track = fed(np.random.default_rng(4).normal(1000, 5.0, 60))
    assert track.spans_half
    track.reset()
    assert (track.last, track.noise, track.slope(), track.spans_half) == (None, 0.0, 0.0, False)
