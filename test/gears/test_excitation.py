"""Fourier series over the mesh phase, and the transmission error built from harmonics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.gears import PeriodicSeries, TransmissionErrorHarmonic
from seat_gear_dynamics.gears.excitation import error_series, fourier_series

coefficients = st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=1, max_size=6)
phases = st.floats(-3.0, 3.0)


def series_of(pairs: list[tuple[float, float]], mean: float = 0.7) -> PeriodicSeries:
    return PeriodicSeries(mean, tuple(c for c, _ in pairs), tuple(s for _, s in pairs))


@given(coefficients)
def test_sampling_a_series_gives_its_coefficients_back(pairs: list[tuple[float, float]]) -> None:
    series = series_of(pairs)
    again = fourier_series(series.value(np.arange(32) / 32), len(pairs))
    assert again.mean == pytest.approx(0.7, abs=1e-12)
    assert again.cosine == pytest.approx(series.cosine, abs=1e-12)
    assert again.sine == pytest.approx(series.sine, abs=1e-12)


@given(coefficients, phases)
def test_derivative_equals_the_finite_difference(pairs: list[tuple[float, float]], phase: float) -> None:
    series, step = series_of(pairs), 1e-5
    slope = (series.value(phase + step) - series.value(phase - step)) / (2 * step)
    assert float(series.derivative(phase)) == pytest.approx(float(slope), abs=1e-3)


@given(coefficients)
def test_power_is_the_sum_of_the_harmonics_power(pairs: list[tuple[float, float]]) -> None:
    series = series_of(pairs)
    power = np.mean(series.value(np.arange(64) / 64) ** 2)
    assert power == pytest.approx(0.7**2 + sum(c**2 + s**2 for c, s in pairs) / 2, rel=1e-9)


@given(coefficients, phases, st.integers(-5, 5))
def test_series_repeats_every_period(pairs: list[tuple[float, float]], phase: float, periods: int) -> None:
    series = series_of(pairs)
    assert float(series.value(phase + periods)) == pytest.approx(float(series.value(phase)), abs=1e-9)


@given(coefficients, phases, st.floats(-3, 3))
def test_scaling_scales_value_and_derivative(pairs: list[tuple[float, float]], phase: float, factor: float) -> None:
    series = series_of(pairs)
    scaled = series.scaled(factor)
    assert float(scaled.value(phase)) == pytest.approx(factor * float(series.value(phase)), abs=1e-9)
    assert float(scaled.derivative(phase)) == pytest.approx(factor * float(series.derivative(phase)), abs=1e-9)


def test_square_wave_has_the_textbook_harmonics() -> None:
    # +1 then −1: sine coefficients 4/(πn) for odd n, none for even n and no cosine, up to the sampling's half step.
    samples = np.where((np.arange(4096) + 0.5) / 4096 < 0.5, 1.0, -1.0)
    series = fourier_series(samples, 5)
    assert series.mean == pytest.approx(0, abs=1e-12)
    assert series.sine == pytest.approx((4 / np.pi, 0, 4 / np.pi / 3, 0, 4 / np.pi / 5), abs=1e-5)
    assert series.cosine == pytest.approx(np.zeros(5), abs=1e-3)


def test_value_keeps_the_shape_of_the_phases() -> None:
    series = series_of([(1.0, 0.5)])
    assert series.value(np.zeros((3, 4))).shape == (3, 4)
    assert series.derivative(0.2).shape == ()


def test_more_harmonics_than_the_samples_carry_are_refused() -> None:
    with pytest.raises(ValueError, match="4 harmonics need more than 8 samples, found 8"):
        fourier_series(np.zeros(8), 4)


harmonics = st.lists(
    st.builds(TransmissionErrorHarmonic, st.integers(1, 6), st.floats(0, 1e-5), st.floats(-4, 4)), max_size=5
)


@settings(max_examples=60)
@given(harmonics, phases)
def test_error_is_the_sum_of_its_sines(parts: list[TransmissionErrorHarmonic], phase: float) -> None:
    expected = sum(h.amplitude * np.sin(2 * np.pi * h.order * phase + h.phase) for h in parts)
    assert float(error_series(parts).value(phase)) == pytest.approx(expected, abs=1e-18)


def test_no_harmonics_is_no_error() -> None:
    series = error_series([])
    assert float(series.value(0.3)) == 0
    assert float(series.derivative(0.3)) == 0


def test_error_has_no_mean() -> None:
    assert error_series([TransmissionErrorHarmonic(2, 1e-6, 0.5)]).mean == 0
