"""Motions that coexist at one operating point: attractors, told apart as sets and not as sequences."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.motion import System, Window
from seat_gear_dynamics.regimes.classification import Regime
from seat_gear_dynamics.regimes.points import Motion, Point, regime_of, respond

if TYPE_CHECKING:  # half a second and 28 MB that the monitor, which never asks for coexisting motions, would pay too
    from scipy.spatial import KDTree

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

TOLERANCE = 0.02
"""Distance of two sections, in units of b_c, up to which they are one motion: below it a bench cannot tell them."""
LOST = -1
"""Label of a start whose motion diverged."""


def separation(first: Array, second: Array) -> float:
    """Return how far apart two section sets of shapes (n, 2) and (m, 2) are, in their unit.

    The modified Hausdorff distance (Dubuisson & Jain 1994): the mean distance of the points of one set to the nearest
    of the other, the larger of the two ways. 0 for equal sets in any order. Unlike Hausdorff's own it does not hang on
    a single stray point, so two samples of one chaotic set come out near each other. Raises ValueError for an empty
    set.
    """
    if not len(first) or not len(second):
        raise ValueError(f"Sections of {len(first)} and {len(second)} points were compared; expected one at least.")
    return _separation(_tree(first), _tree(second))


def _tree(section: Array) -> "KDTree":
    from scipy.spatial import KDTree

    return KDTree(section)


def _separation(first: "KDTree", second: "KDTree") -> float:
    there, _ = second.query(first.data)
    back, _ = first.query(second.data)
    return float(max(there.mean(), back.mean()))


def scatter(section: Array) -> float:
    """Return how far the two halves of a record are apart: what sampling alone, or a slow transient, makes of a set.

    0 for settled periodic motion whose period divides half the record, and for fewer than two points.
    """
    half = len(section) // 2
    return separation(section[:half], section[half:]) if half else 0.0


@dataclass(frozen=True, eq=False)
class Attractor:
    """A motion that starts settle on."""

    regime: Regime
    section: Array
    """Section points of the first start that reached it, (periods, 2), units of b_c."""
    force: Window
    """Dimensionless force of P12 on it."""
    state: Array
    """A state on it at mesh phase 0, (24,): the start of a run that stays there."""

    @cached_property
    def _tree(self) -> "KDTree":
        return _tree(self.section)

    @cached_property
    def _scatter(self) -> float:
        return scatter(self.section)


def same_motion(first: Array, second: Array, *, tolerance: float = TOLERANCE) -> bool:
    """Return whether two sections, (n, 2) and (m, 2), show one motion.

    They do where their separation is within `tolerance` plus the larger scatter of the two records themselves. So
    neither sampling of a chaotic set nor a transient that is still shrinking passes for a second motion; in return two
    chaotic sets are told apart only where they are farther from each other than the halves of one of them.
    """
    return separation(first, second) <= tolerance + max(scatter(first), scatter(second))


def attractors(
    system: System,
    starts: ArrayLike,
    *,
    transient: int = 600,
    periods: int = 200,
    tolerance: float = TOLERANCE,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[tuple[Attractor, ...], Labels]:
    """Return the distinct motions of `system` that initial states lead to, and which of them each start reaches.

    `starts` has shape (n, 24), states at mesh phase 0; the labels, (n,), index the motions, LOST where a start
    diverged. Motions are numbered in the order in which starts meet them. `progress` is told (done, n). A start
    belongs to the nearest motion that `same_motion` would take for its own. Raises ValueError for starts of another
    shape. Limits: motions that no start reaches are not found; a transient longer than `transient` may count as a
    motion of its own.
    """
    states = np.array(starts, dtype=float)
    if states.ndim != 2 or states.shape[1] != 24 or not len(states):
        raise ValueError(f"The starts have shape {states.shape}, expected (n, 24): a row per initial state.")
    at = system.operating_point
    asked = (Point(at.frequency, at.load, state=state, transient=transient, periods=periods) for state in states)
    found: list[Attractor] = []
    labels = np.full(len(states), LOST, dtype=np.int64)
    for index, reached in enumerate(respond(system.train, asked, workers=workers)):
        if isinstance(reached, Motion):
            labels[index] = _match(found, reached, tolerance)
        if progress is not None:
            progress(index + 1, len(states))
    return tuple(found), labels


def _match(found: list[Attractor], reached: Motion, tolerance: float) -> int:
    """Return the index of the motion reached, which is appended to `found` if it is new."""
    index = _nearest(found, reached.section, tolerance)
    if index is None:
        found.append(Attractor(regime_of(reached), reached.section, reached.forces[0], reached.state))
        index = len(found) - 1
    return index


def _nearest(known: Sequence[Attractor], section: Array, tolerance: float) -> int | None:
    tree, own = _tree(section), scatter(section)
    distances = [_separation(each._tree, tree) for each in known]
    # A record that has not settled yet may be near several motions: it belongs to the nearest.
    for index in np.argsort(distances):
        if distances[index] <= tolerance + max(own, known[index]._scatter):
            return int(index)
    return None
