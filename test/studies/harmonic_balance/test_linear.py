"""Elimination against LAPACK, and what it says of matrices that cannot be solved."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.linear import solved

Array = NDArray[np.float64]


@given(st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_solution_is_lapacks(size: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    matrix, right = random.normal(size=(size, size)), random.normal(size=size)
    found = solved(matrix, right)
    assert found is not None
    # Both are exact to rounding times the condition number.
    tolerance = 1e-13 * np.linalg.cond(matrix) * np.linalg.norm(found)
    assert np.abs(found - np.linalg.solve(matrix, right)).max() < tolerance


def test_arguments_are_left_as_they_were() -> None:
    matrix, right = np.array([[0.0, 2.0], [1.0, 1.0]]), np.array([2.0, 3.0])
    assert solved(matrix, right) == pytest.approx([2.0, 1.0])
    assert np.array_equal(matrix, [[0.0, 2.0], [1.0, 1.0]])
    assert np.array_equal(right, [2.0, 3.0])


@pytest.mark.parametrize("matrix", [np.zeros((2, 2)), np.ones((2, 2)), np.full((2, 2), np.nan)])
def test_singular_systems_have_no_solution(matrix: Array) -> None:
    assert solved(matrix, np.array([1.0, 2.0])) is None
