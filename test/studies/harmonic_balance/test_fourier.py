"""Coefficients, samples and products of truncated Fourier series."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.fourier import Basis, amplitudes, evaluate, from_amplitudes

Array = NDArray[np.float64]

ROUNDING = 1e-12  # of sums of about a hundred terms of order 1


def some(size: int, seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=size)


@given(st.integers(1, 12), st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_coefficients_come_back_from_the_samples(harmonics: int, more: int, seed: int) -> None:
    basis = Basis(harmonics, 2 * harmonics + more)
    coefficients = some(basis.size, seed)
    assert np.allclose(basis.coefficients(basis.values(coefficients)), coefficients, atol=ROUNDING)


@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_amplitudes_and_coefficients_are_the_same_thing(harmonics: int, seed: int) -> None:
    coefficients = some(2 * harmonics + 1, seed)
    assert np.array_equal(from_amplitudes(amplitudes(coefficients)), coefficients)


def test_samples_are_those_of_the_series_written_out() -> None:
    basis = Basis(2, 9)
    phase = 2 * np.pi * basis.phases
    expected = 0.5 + 2 * np.cos(phase) - np.cos(2 * phase) + 3 * np.sin(phase) + 0.25 * np.sin(2 * phase)
    coefficients = np.array([0.5, 2.0, -1.0, 3.0, 0.25])
    assert np.allclose(basis.values(coefficients), expected, atol=ROUNDING)
    value, slope = evaluate(coefficients, basis.phases)
    rate = -2 * np.sin(phase) + 2 * np.sin(2 * phase) + 3 * np.cos(phase) + 0.5 * np.cos(2 * phase)
    assert np.allclose(value, expected, atol=ROUNDING)
    assert np.allclose(slope, 2 * np.pi * rate, atol=10 * ROUNDING)


@given(st.integers(1, 8), st.integers(1, 30), st.integers(0, 2**32 - 1))
def test_multiplication_is_the_product_taken_at_the_samples(harmonics: int, more: int, seed: int) -> None:
    basis = Basis(harmonics, 2 * harmonics + more)
    factor = some(basis.samples, seed)
    columns = [basis.coefficients(factor * basis.values(unit)) for unit in np.eye(basis.size)]
    assert np.allclose(basis.multiplication(factor), np.array(columns).T, atol=10 * ROUNDING)


def test_a_motion_written_with_twice_its_period_is_the_same_motion() -> None:
    short, long = Basis(3, 16), Basis(7, 32)
    coefficients = some(short.size, 1)
    doubled = long.resampled(coefficients, 2)
    phase = np.linspace(0, 1, 11)
    assert np.allclose(evaluate(doubled, phase)[0], evaluate(coefficients, 2 * phase)[0], atol=ROUNDING)


def test_what_a_smaller_basis_has_no_room_for_is_cut() -> None:
    cut = Basis(1, 8).resampled(np.array([1.0, 2.0, 3.0, 4.0, 5.0]))
    assert np.array_equal(cut, [1.0, 2.0, 4.0])


@pytest.mark.parametrize(("harmonics", "samples"), [(0, 8), (4, 8), (-1, 8)])
def test_a_basis_without_room_for_its_harmonics_is_refused(harmonics: int, samples: int) -> None:
    with pytest.raises(ValueError, match="expected at least 1 harmonic and more than"):
        Basis(harmonics, samples)
