"""How many separate pieces a section has: the closed curves of a torus, the bands of banded chaos."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

MOST_PIECES = 16
"""Most pieces looked for."""
_POINTS = 8  # least points of a piece; fewer do not show what it is
_STEPPING = 0.5  # share of points next to their own successor from which a piece counts as not yet come round
_FILLED = 0.25  # longest empty stretch of a filled curve over its extent; a Cantor set of doublings has 0.43


@dataclass(frozen=True)
class Pieces:
    """The separate pieces of a section, each visited once a round in a fixed order."""

    count: int
    """Number of pieces, at least 1."""
    closed: bool
    """True where the motion has come round on every piece, so that its points lie between those of earlier rounds."""
    gap: float
    """Longest empty stretch inside a piece over the extent of that piece, 0 to 1."""

    @property
    def filled(self) -> bool:
        """True where the points cover the pieces without large holes."""
        return self.gap <= _FILLED


def pieces(section: Array, *, most: int = MOST_PIECES) -> Pieces:
    """Return the pieces of a section: the largest number of clusters that the motion visits in turn.

    `section` (n, 2), in time order, any unit; raises ValueError for less than 16 points or other shapes. The n points
    are joined by their shortest tree (Prim 1957); leaving out its m − 1 longest edges makes m clusters (single
    linkage), which count as pieces where they are just the points whose numbers agree modulo m, so that one maps onto
    the next. A torus of the m-th iterate, the literature's quasi-period-m, has m closed curves; m-band chaos m pieces.

    Limits. Pieces closer to each other than a hole inside one of them are not told apart: the count is what this
    record resolves, and grows with it. A projection can let curves cross that are apart in the full state. An arc not
    yet closed counts as a piece and is marked so in `closed`, for which a piece must have been gone round about 4/3
    times.
    """
    if section.ndim != 2 or section.shape[1] != 2 or len(section) < 2 * _POINTS:
        raise ValueError(f"The section has shape {section.shape}; expected (n, 2) with n of at least {2 * _POINTS}.")
    first, second, length, nearest = _shortest_tree(np.ascontiguousarray(section))
    order = np.argsort(length, kind="stable")
    apart = np.abs(first - second)[order]
    n, count = len(section), 1
    if length[order[-1]] == 0:
        return Pieces(1, False, 0.0)
    for m in range(2, min(most, n // _POINTS) + 1):
        if not (apart[: n - m] % m).any():
            count = m
    stepping = np.mean(np.abs(nearest - np.arange(n)) == count)
    inside = order[: n - count]
    return Pieces(count, bool(stepping <= _STEPPING), _longest_gap(section, first[inside], length[inside], count))


def _longest_gap(section: Array, member: Index, length: Array, count: int) -> float:
    """Return the longest tree edge inside a piece over the diagonal of the box around that piece."""
    longest = np.zeros(count)
    np.maximum.at(longest, member % count, length)
    extent = np.array([np.hypot(*np.ptp(section[k::count], axis=0)) for k in range(count)])
    return float(np.divide(longest, extent, out=np.zeros(count), where=extent > 0).max())


@njit(cache=True, nogil=True, error_model="numpy")
def _shortest_tree(section: Array) -> tuple[Index, Index, Array, Index]:
    """Return the ends (n − 1,) and (n − 1,) and lengths of the edges of the shortest tree, and each nearest point (n,).

    SciPy's tree of a dense graph sorts all n²/2 edges, which takes sixty times as long at 400 points.
    """
    n = len(section)
    reach, came, joined = np.full(n, np.inf), np.zeros(n, np.int64), np.zeros(n, np.bool_)
    nearest, distance = np.zeros(n, np.int64), np.full(n, np.inf)
    first, second, length = np.empty(n - 1, np.int64), np.empty(n - 1, np.int64), np.empty(n - 1)
    current = 0
    for edge in range(n):
        joined[current] = True
        following, shortest = -1, np.inf
        for j in range(n):
            if j == current:
                continue
            square = (section[current, 0] - section[j, 0]) ** 2 + (section[current, 1] - section[j, 1]) ** 2
            if square < distance[current]:
                distance[current], nearest[current] = square, j
            if joined[j]:
                continue
            if square < reach[j]:
                reach[j], came[j] = square, current
            if reach[j] < shortest:
                shortest, following = reach[j], j
        if edge < n - 1:
            first[edge], second[edge], length[edge] = came[following], following, np.sqrt(shortest)
            current = following
    return first, second, length, nearest
