"""Numbers four at a time: every lane holds what the same operations on plain numbers give, to the last bit."""

import platform
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.motion.vectors import (
    Four,
    align_stack,
    even_and_odd,
    four,
    front_and_back,
    front_twice,
    lane,
    neighbours,
    where_above,
)

Array = NDArray[np.float64]
NUMBERS = st.lists(st.floats(), min_size=4, max_size=4).map(np.array)
A, B = np.array([1.0, 2.0, 3.0, 4.0]), np.array([-5.0, -6.0, -7.0, -8.0])


@njit(error_model="numpy", inline="always")
def _taken(x: Array) -> Four:
    return four(x[0], x[1], x[2], x[3])


@njit(error_model="numpy", inline="always")
def _given(x: Four) -> Array:
    return np.array([lane(x, 0), lane(x, 1), lane(x, 2), lane(x, 3)])


@njit(error_model="numpy")
def _arithmetic(a: Array, b: Array, factor: float) -> Array:
    x, y = _taken(a), _taken(b)
    # Product and sum stand side by side, where a compiler with leave to do so would fuse them.
    return np.concatenate((_given(x + y), _given(x - y), _given(x * y), _given(factor * y), _given(x - factor * y)))


@njit(error_model="numpy")
def _shuffled(a: Array, b: Array) -> Array:
    x, y = _taken(a), _taken(b)
    kinds = (_given(front_twice(x)), _given(neighbours(x)), _given(front_and_back(x, y)), _given(even_and_odd(x, y)))
    return np.concatenate(kinds)


@njit(error_model="numpy")
def _compared(a: Array, b: Array) -> Array:
    x, y = _taken(a), _taken(b)
    return np.asarray(_given(where_above(x, y, x, y)))


@njit(error_model="numpy")
def _laid_out(a: Array) -> Array:
    align_stack()
    return np.asarray(_given(_taken(a)))


@given(NUMBERS, NUMBERS, st.floats())
@example(np.full(4, 1.0), np.full(4, 1.0 + 2.0**-27), 1.0 + 2.0**-27)  # fused, the difference is 2^-54 less
def test_arithmetic_is_that_of_plain_numbers_in_every_lane(a: Array, b: Array, factor: float) -> None:
    with np.errstate(all="ignore"):
        expected = np.concatenate([a + b, a - b, a * b, factor * b, a - factor * b])
    found = _arithmetic(a, b, factor)
    same = found.view(np.int64) == expected.view(np.int64)  # tells 0 from -0
    assert (same | (np.isnan(found) & np.isnan(expected))).all()


def test_lanes_go_where_their_names_say() -> None:
    front_twice_of, neighbours_of, halves, alternating = np.split(_shuffled(A, B), 4)
    assert front_twice_of.tolist() == [1, 2, 1, 2]
    assert neighbours_of.tolist() == [2, 1, 4, 3]
    assert halves.tolist() == [1, 2, -7, -8]
    assert alternating.tolist() == [1, -6, 3, -8]


@given(NUMBERS, NUMBERS)
def test_the_greater_is_chosen_lane_by_lane_and_nan_is_never_above(a: Array, b: Array) -> None:
    assert np.array_equal(_compared(a, b), np.where(a > b, a, b), equal_nan=True)


def test_memory_is_laid_out_by_cache_lines() -> None:
    assert _laid_out(A).tolist() == A.tolist()
    if platform.machine() != "x86_64":
        pytest.skip("the instruction looked for is that of x86-64")
    dispatcher: Any = _laid_out
    assert any("$-64, %rsp" in text for text in dispatcher.inspect_asm().values())
