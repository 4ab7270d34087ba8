"""Pseudo-arclength continuation: a branch of solutions followed through its folds.

Keller 1977, and Seydel, "Practical Bifurcation and Stability Analysis" (3rd ed. 2010): predict along the
tangent, correct on the plane across it. The arc is measured in scaled coordinates, so that unknowns and parameter
weigh alike; the step follows how hard the correction was and how far the tangent turned.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.newton import NoSolutionError, Plane, Problem, correct, solve, tangent

Array = NDArray[np.float64]

_EASY, _HARD = 3, 7  # Newton iterations after which the next step may grow, or must shrink
_GROWTH, _CUT = 1.3, 0.5
_STRAY = 0.4  # of the step: further from the tangent's end lies another branch
_TURN = 0.94  # cosine of the largest angle, 20 degrees, between the tangents of neighbours


@dataclass(frozen=True)
class Point:
    """One solution on a branch."""

    unknowns: Array
    parameter: float
    tangent: Array
    """Direction of the branch in scaled coordinates, (n + 1,); the last entry is the parameter's."""


@dataclass(frozen=True)
class Arc:
    """How arc is measured and stepped: scales of the unknowns and of the parameter, and the step in scaled arc."""

    scale: float
    parameter_scale: float
    first: float = 0.02
    shortest: float = 1e-6
    longest: float = 1.0

    def plane(self, unknowns: Array, parameter: float, normal: Array) -> Plane:
        """Return the plane through a solution with a scaled normal."""
        return Plane(self.scaled(unknowns, parameter), normal, self.scale, self.parameter_scale)

    def scaled(self, unknowns: Array, parameter: float) -> Array:
        """Return scaled coordinates, (n + 1,)."""
        return np.append(unknowns / self.scale, parameter / self.parameter_scale)


def start(problem: Problem, unknowns: Array, parameter: float, arc: Arc, *, upward: bool = True) -> Point:
    """Return the solution near `unknowns` at `parameter`, set off towards higher parameters or lower ones.

    Raises NoSolutionError where there is none near, or where the branch stands upright there (a fold).
    """
    found = solve(problem, unknowns, parameter)
    along = np.zeros(len(found) + 1)
    along[-1] = 1.0 if upward else -1.0
    return Point(found, parameter, tangent(problem, found, parameter, arc.plane(found, parameter, along)))


def follow(problem: Problem, first: Point, low: float, high: float, arc: Arc) -> Iterator[Point]:
    """Yield the points after `first` along its tangent until the parameter leaves [low, high].

    Endless where it never does. The last point lies on the bound that was passed. Raises NoSolutionError
    where steps of the shortest length find nothing more.
    """
    point, step = first, arc.first
    while True:
        point, step = _advance(problem, point, step, arc)
        if low <= point.parameter <= high:
            yield point
            continue
        bound = low if point.parameter < low else high
        last = between(problem, point, point, arc, bound)
        if last is not None:
            yield last
        return


def _advance(problem: Problem, point: Point, step: float, arc: Arc) -> tuple[Point, float]:
    """Return the next point and the step to try after it."""
    while True:
        try:
            following, iterations = step_along(problem, point, step, arc)
            smooth = _smooth(point, following, step, arc)
        except NoSolutionError:
            if step <= arc.shortest:
                raise
            step = max(step * _CUT, arc.shortest)
            continue
        if not smooth and step > arc.shortest:
            step = max(step * _CUT, arc.shortest)
            continue
        if iterations <= _EASY:
            return following, min(step * _GROWTH, arc.longest)
        return following, max(step * _CUT, arc.shortest) if iterations >= _HARD else step


def _smooth(point: Point, following: Point, step: float, arc: Arc) -> bool:
    """Return whether a step stayed on its branch: near where the tangent led, and with little turn."""
    led = arc.scaled(point.unknowns, point.parameter) + step * point.tangent
    strayed = np.linalg.norm(arc.scaled(following.unknowns, following.parameter) - led)
    return bool(strayed < _STRAY * step and following.tangent @ point.tangent > _TURN)


def step_along(problem: Problem, point: Point, step: float, arc: Arc, guess: Array | None = None) -> tuple[Point, int]:
    """Return the solution on the plane `step` of scaled arc ahead across the tangent, and the iterations it took.

    `guess` is a scaled point on that plane to start from, by default the tangent's end.
    """
    ahead = arc.scaled(point.unknowns, point.parameter) + step * point.tangent if guess is None else guess
    plane = Plane(ahead, point.tangent, arc.scale, arc.parameter_scale)
    found = correct(problem, plane)
    return Point(found.unknowns, found.parameter, found.tangent), found.iterations


def between(problem: Problem, near: Point, direction: Point, arc: Arc, bound: float) -> Point | None:
    """Return the solution at the parameter `bound`, started at `near`; None where Newton's method finds none."""
    try:
        unknowns = solve(problem, near.unknowns, bound)
        plane = arc.plane(unknowns, bound, direction.tangent)
        return Point(unknowns, bound, tangent(problem, unknowns, bound, plane))
    except NoSolutionError:
        return None
