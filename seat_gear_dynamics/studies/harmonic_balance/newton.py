"""Newton's method for a system with one parameter: at a fixed parameter, or on a plane across the branch.

Forces with corners make the Jacobian jump; the iteration is then Newton's semismooth one, which converges as fast once
the contact pattern of the samples no longer changes.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.linear import solved

Array = NDArray[np.float64]

TOLERANCE = 1e-10
"""Largest residual that counts as solved; residuals are displacements over b_c, or forces over k̄_12·b_c."""
ITERATIONS = 15
DAMPED_ITERATIONS = 60
_HALVINGS = 8


class NoSolutionError(ArithmeticError):
    """Newton's method found no solution near its start; the text says where."""


class Problem(Protocol):
    """n equations in n unknowns and one parameter."""

    def evaluate(self, unknowns: Array, parameter: float) -> tuple[Array, Array, Array]:
        """Return (residual, Jacobian, slope by the parameter), shapes (n,), (n, n), (n,)."""
        ...


@dataclass(frozen=True)
class Plane:
    """The plane normal·(y − through) = 0 in scaled coordinates y = (unknowns/scale, parameter/parameter_scale)."""

    through: Array
    """(n + 1,), scaled."""
    normal: Array
    """(n + 1,), scaled."""
    scale: float
    parameter_scale: float

    @property
    def weights(self) -> Array:
        """What scaled coordinates are multiplied by to get plain ones, (n + 1,)."""
        weights = np.full(len(self.through), self.scale)
        weights[-1] = self.parameter_scale
        return weights


@dataclass(frozen=True)
class Solution:
    """Where a branch meets a plane."""

    unknowns: Array
    parameter: float
    tangent: Array
    """Of length 1 in scaled coordinates, (n + 1,), on the side of the plane's normal."""
    iterations: int


def solve(problem: Problem, unknowns: Array, parameter: float) -> Array:
    """Return a solution at `parameter`, (n,), started from `unknowns`; raises NoSolutionError where none is reached.

    A step that makes the residual larger is halved until it does not: a start may be far off, as the linear response
    is where teeth part.
    """
    found = np.array(unknowns, dtype=float)
    residual, jacobian, _ = problem.evaluate(found, parameter)
    for _ in range(DAMPED_ITERATIONS):
        if _small(residual):
            return found
        step, size = _linear(jacobian, residual, parameter), np.linalg.norm(residual)
        for halvings in range(_HALVINGS):
            trial = found - step / 2**halvings
            residual, jacobian, _ = problem.evaluate(trial, parameter)
            if np.linalg.norm(residual) < size:
                break
        found = trial
    raise NoSolutionError(_text(parameter))


def correct(problem: Problem, plane: Plane) -> Solution:
    """Return the solution where the branch meets `plane`, starting at the plane's own point.

    Raises NoSolutionError where the iteration does not converge.
    """
    weights, normal = plane.weights, plane.normal
    place = plane.through.copy()
    for iteration in range(ITERATIONS):
        plain = place * weights
        try:
            residual, jacobian, slope = problem.evaluate(plain[:-1], float(plain[-1]))
        except ValueError as error:  # the parameter left its possible values
            raise NoSolutionError(str(error)) from error
        matrix = _bordered(jacobian, slope, plane)
        if _small(residual):
            return Solution(plain[:-1], float(plain[-1]), _direction(matrix, float(plain[-1])), iteration)
        place = place - _linear(matrix, np.append(residual, normal @ (place - plane.through)), float(plain[-1]))
    raise NoSolutionError(_text(float(place[-1] * weights[-1])))


def tangent(problem: Problem, unknowns: Array, parameter: float, plane: Plane) -> Array:
    """Return the branch's direction of length 1 in scaled coordinates, (n + 1,), on the side of the plane's normal."""
    _, jacobian, slope = problem.evaluate(unknowns, parameter)
    return _direction(_bordered(jacobian, slope, plane), parameter)


def _bordered(jacobian: Array, slope: Array, plane: Plane) -> Array:
    return np.vstack([np.column_stack([jacobian, slope]) * plane.weights, plane.normal])


def _direction(bordered: Array, parameter: float) -> Array:
    right = np.zeros(len(bordered))
    right[-1] = 1.0
    direction = _linear(bordered, right, parameter)
    return np.asarray(direction / np.linalg.norm(direction))


def _linear(matrix: Array, right: Array, parameter: float) -> Array:
    step = solved(matrix, right)
    if step is None:
        raise NoSolutionError(_text(parameter))
    return step


def _small(residual: Array) -> bool:
    return bool(np.abs(residual).max() <= TOLERANCE)


def _text(parameter: float) -> str:
    return (
        f"No periodic motion was found near the start at parameter {parameter:.6g}; "
        f"start from a motion that was integrated there, or ask for more harmonics."
    )
