"""Level, slope and noise of a measured quantity, told apart."""

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


def test_a_reset_forgets() -> None:
    track = fed(np.random.default_rng(4).normal(1000, 5.0, 60))
    assert track.spans_half
    track.reset()
    assert (track.last, track.noise, track.slope(), track.spans_half) == (None, 0.0, 0.0, False)
