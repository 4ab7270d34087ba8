"""Orthogonal arrays of strength 2, built from their algebra, and the choice of the smallest one for given factors.

Levels are counted from 0. Source of the constructions: Hedayat, Sloane & Stufken, Orthogonal Arrays (1999); of the
names and their use: Taguchi, System of Experimental Design (1987), and Phadke, Quality Engineering Using Robust Design
(1989).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

Levels = NDArray[np.int64]


@dataclass(frozen=True)
class OrthogonalArray:
    """A named array: every pair of columns holds every pair of levels equally often."""

    name: str
    """As in L18."""
    levels: Levels
    """Level of each column in each run, shape (runs, columns), counted from 0; read only."""

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.levels)

    @property
    def level_counts(self) -> tuple[int, ...]:
        """Number of levels of each column."""
        return tuple(int(n) + 1 for n in self.levels.max(axis=0))

    def assigned(self, level_counts: Sequence[int]) -> Levels:
        """Return the array's columns for factors of these numbers of levels, shape (runs, factors).

        Each factor gets the first free column of exactly its number of levels; columns left over stay empty. Raises
        ValueError where there are too few. Limit: no dummy levels, no merged columns, no column kept for an
        interaction.
        """
        free, chosen = list(self.level_counts), []
        for factor, count in enumerate(level_counts):
            if count not in free:
                raise ValueError(
                    f"{self.name} has no free column of {count} levels for factor {factor + 1} of {len(level_counts)}; "
                    f"it has {self.columns}: take a larger array, fewer factors or other numbers of levels."
                )
            chosen.append(free.index(count))
            free[chosen[-1]] = 0
        return self.levels[:, chosen]

    @property
    def columns(self) -> str:
        """What the columns are, in words."""
        counts = self.level_counts
        numbers = [(counts.count(n), n) for n in sorted(set(counts))]
        return " and ".join(f"{number} column{'s' * (number > 1)} of {n} levels" for number, n in numbers)


def is_orthogonal(levels: Levels) -> bool:
    """Return whether each pair of columns of `levels`, (runs, columns), holds each pair of its levels equally often."""
    for a, b in combinations(np.asarray(levels).T, 2):
        pairs = dict.fromkeys(product(sorted(set(a.tolist())), sorted(set(b.tolist()))), 0)
        for pair in zip(a.tolist(), b.tolist(), strict=True):
            pairs[pair] += 1
        if len(set(pairs.values())) > 1:
            return False
    return True


@cache
def orthogonal_array(name: str) -> OrthogonalArray:
    """Return the array called `name`, one of ARRAY_NAMES; raises ValueError for any other name."""
    if name not in _BUILDERS:
        raise ValueError(f"There is no array {name!r} here; choose one of {', '.join(ARRAY_NAMES)}.")
    levels = _BUILDERS[name]()
    levels.setflags(write=False)
    return OrthogonalArray(name, levels)


def smallest_array(level_counts: Sequence[int]) -> OrthogonalArray:
    """Return the array of fewest runs with a column for each factor of these numbers of levels.

    Raises ValueError without a factor, and where no array has the columns. Limits as in `OrthogonalArray.assigned`.
    """
    if not level_counts:
        raise ValueError("There are 0 factors to arrange; an array needs at least 1.")
    for name in ARRAY_NAMES:
        columns = orthogonal_array(name).level_counts
        if all(columns.count(n) >= list(level_counts).count(n) for n in set(level_counts)):
            return orthogonal_array(name)
    raise ValueError(
        f"No array from {ARRAY_NAMES[0]} to {ARRAY_NAMES[-1]} has columns for factors of {list(level_counts)} levels; "
        f"give fewer factors, or factors of equal numbers of levels."
    )


def _linear(order: int, dimension: int) -> Levels:
    """Return the array of order^dimension runs whose columns are all points of the projective space over GF(order).

    A run is a vector of GF(order)^dimension, a column a linear form on it, with 1 as its last coefficient that is not
    0: two different ones take every pair of values equally often (Rao & Hamming). `order` is a prime here, so that the
    field is arithmetic modulo `order`. Columns come as in Taguchi's tables, except for the last ones of L27.
    """
    runs = np.array(list(product(range(order), repeat=dimension)), dtype=np.int64)
    forms = [
        [*reversed(earlier), 1, *[0] * (dimension - 1 - basic)]
        for basic in range(dimension)
        for earlier in product(range(order), repeat=basic)
    ]
    return np.ascontiguousarray(runs @ np.array(forms, dtype=np.int64).T % order)


def _quadratic_characters(prime: int) -> list[int]:
    """Return for 0, 1, … prime − 1: 0 for 0, 1 for a square modulo `prime`, 2 for a number that is none."""
    squares = {x * x % prime for x in range(1, prime)}
    return [0, *(1 if x in squares else 2 for x in range(1, prime))]


def _circulant(row: Sequence[int]) -> Levels:
    return np.array([np.roll(row, shift) for shift in range(len(row))], dtype=np.int64)


def _plackett_burman_12() -> Levels:
    """Return L12: the circulant of the quadratic characters of 11, closed by a row of 0 (Plackett & Burman 1946)."""
    core = _circulant([1 if character < 2 else 0 for character in _quadratic_characters(11)])
    return np.vstack([core, np.zeros((1, 11), dtype=np.int64)])


def _difference_matrix_18() -> Levels:
    """Return L18 from a difference matrix of order 6 over GF(3).

    Any two of its columns differ by each element of GF(3) twice: the circulant of the quadratic characters of 5, with a
    border of 0. Each of its rows plus 0, 1 and 2 gives three runs and six columns; the number of the row, orthogonal to
    all six, has six levels and is split into one column of two and one of three.
    """
    difference = np.zeros((6, 6), dtype=np.int64)
    difference[1:, 1:] = _circulant(_quadratic_characters(5))
    runs = [[row // 3, row % 3, *(difference[row] + shift) % 3] for row in range(6) for shift in range(3)]
    return np.array(runs, dtype=np.int64)


_BUILDERS: dict[str, Callable[[], Levels]] = {
    "L4": lambda: _linear(2, 2),
    "L8": lambda: _linear(2, 3),
    "L9": lambda: _linear(3, 2),
    "L12": _plackett_burman_12,
    "L16": lambda: _linear(2, 4),
    "L18": _difference_matrix_18,
    "L25": lambda: _linear(5, 2),
    "L27": lambda: _linear(3, 3),
}
ARRAY_NAMES = tuple(_BUILDERS)
"""Names of the arrays, by their number of runs."""
