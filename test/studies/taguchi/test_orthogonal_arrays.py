"""Orthogonal arrays: their law, the published tables, and the choice of the smallest one."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.studies.taguchi import ARRAY_NAMES, is_orthogonal, orthogonal_array, smallest_array

# Runs and columns as in the table of arrays by Yang & El-Haik, Design for Six Sigma (2003), Table 13.5.
SIZES = {
    "L4": (4, (2,) * 3),
    "L8": (8, (2,) * 7),
    "L9": (9, (3,) * 4),
    "L12": (12, (2,) * 11),
    "L16": (16, (2,) * 15),
    "L18": (18, (2, *(3,) * 7)),
    "L25": (25, (5,) * 6),
    "L27": (27, (3,) * 13),
}


def test_every_array_of_the_table_is_there() -> None:
    assert tuple(SIZES) == ARRAY_NAMES


@pytest.mark.parametrize("name", ARRAY_NAMES)
def test_runs_and_columns_are_those_of_the_table(name: str) -> None:
    array = orthogonal_array(name)
    assert (array.runs, array.level_counts) == SIZES[name]


@pytest.mark.parametrize("name", ARRAY_NAMES)
def test_every_level_of_a_column_occurs_equally_often(name: str) -> None:
    array = orthogonal_array(name)
    for column, count in zip(array.levels.T, array.level_counts, strict=True):
        assert np.bincount(column).tolist() == [array.runs // count] * count


@pytest.mark.parametrize("name", ARRAY_NAMES)
def test_every_pair_of_columns_holds_every_pair_of_levels_equally_often(name: str) -> None:
    # By counting in a table, independent of is_orthogonal.
    array = orthogonal_array(name)
    for i, j in product(range(len(array.level_counts)), repeat=2):
        if i < j:
            table = np.zeros((array.level_counts[i], array.level_counts[j]), dtype=int)
            np.add.at(table, (array.levels[:, i], array.levels[:, j]), 1)
            assert set(table.ravel().tolist()) == {array.runs // table.size}
    assert is_orthogonal(array.levels)


def test_two_level_arrays_are_hadamard_matrices() -> None:
    for name in ("L4", "L8", "L12", "L16"):
        levels = orthogonal_array(name).levels
        signs = np.column_stack([np.ones(len(levels), dtype=int), 1 - 2 * levels])
        assert (signs.T @ signs).tolist() == (len(levels) * np.eye(len(levels), dtype=int)).tolist()


def test_l8_and_l9_are_the_published_tables() -> None:
    # Yang & El-Haik (2003): L8 in Example 13.11, L9 in Table 13.4.
    eight = ["1111111", "1112222", "1221122", "1222211", "2121212", "2122121", "2211221", "2212112"]
    nine = ["1111", "1222", "1333", "2123", "2231", "2312", "3132", "3213", "3321"]
    for name, rows in (("L8", eight), ("L9", nine)):
        assert orthogonal_array(name).levels.tolist() == [[int(level) - 1 for level in row] for row in rows]


def test_an_array_is_not_orthogonal_once_a_run_or_a_level_is_another() -> None:
    levels = orthogonal_array("L9").levels
    assert not is_orthogonal(levels[1:])
    changed = levels.copy()
    changed[0, 0] = 1
    assert not is_orthogonal(changed)


def test_a_shared_array_cannot_be_written_to() -> None:
    with pytest.raises(ValueError, match="read-only"):
        orthogonal_array("L4").levels[0, 0] = 1


@pytest.mark.parametrize(
    ("counts", "name"),
    [
        ([2], "L4"),
        ([2] * 4, "L8"),
        ([3] * 4, "L9"),
        ([2] * 8, "L12"),
        ([2] * 12, "L16"),
        ([2, 3], "L18"),
        ([3] * 5, "L18"),
        ([3] * 7, "L18"),
        ([5] * 6, "L25"),
        ([3] * 8, "L27"),
    ],
)
def test_the_smallest_array_that_fits_is_chosen(counts: list[int], name: str) -> None:
    assert smallest_array(counts).name == name


@given(st.lists(st.sampled_from([2, 3]), min_size=1, max_size=8).filter(lambda counts: counts.count(2) < 2))
def test_chosen_columns_fit_the_factors_and_leave_no_smaller_array(counts: list[int]) -> None:
    array = smallest_array(counts)
    columns = array.assigned(counts)
    assert columns.shape == (array.runs, len(counts))
    assert (columns.max(axis=0) + 1).tolist() == counts
    assert is_orthogonal(columns)
    # The law: an array of strength 2 has at least 1 + Σ (levels − 1) runs (Rao's bound).
    assert array.runs >= 1 + sum(count - 1 for count in counts)
    for smaller in ARRAY_NAMES[: ARRAY_NAMES.index(array.name)]:
        with pytest.raises(ValueError, match="has no free column"):
            orthogonal_array(smaller).assigned(counts)


@pytest.mark.parametrize(("counts", "said"), [([], "0 factors"), ([2, 2, 3], "No array"), ([4], "No array")])
def test_factors_that_fit_no_array_are_refused(counts: list[int], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        smallest_array(counts)


def test_an_unknown_array_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(ValueError, match="no array 'L10' here; choose one of L4, L8"):
        orthogonal_array("L10")


def test_too_many_factors_for_a_given_array_are_refused() -> None:
    with pytest.raises(ValueError, match="L9 has no free column of 3 levels for factor 5 of 5; it has 4 columns of 3"):
        orthogonal_array("L9").assigned([3] * 5)
