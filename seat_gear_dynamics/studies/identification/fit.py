"""Weighted nonlinear least squares from several starts; the model is a function that answers many sets at once."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc

Array = NDArray[np.float64]
Predict = Callable[[Array], Array]
"""Coordinates (k, p) → what the model says, (k, m); NaN where it has no answer."""

STEP = 2e-3
"""Of a central difference in a logarithm: beyond the march's rounding, below the curvature of a resonance."""
SOFT = 4.0
"""Whitened residuals beyond this count by their absolute value: a dwell on another branch does not carry the fit."""
_NO_ANSWER = 50.0  # whitened residual of what the model has no answer to
_EVALUATIONS = 30
_ENOUGH = 1e-5  # relative change of cost or logarithms at which a search ends: a hundredth of a per mille


@dataclass(frozen=True, eq=False)
class Problem:
    """What was measured, how sure it is, and where the parameters may lie."""

    measured: Array
    """(m,)"""
    whitener: Array
    """W with WᵀW the inverse of the covariance of `measured`, (m, m)."""
    low: Array
    """Bounds of the coordinates, (p,)."""
    high: Array

    def residual(self, said: Array) -> Array:
        """Return the whitened residuals (..., m) of what a model says, (..., m)."""
        missing = ~np.isfinite(said)
        apart = np.where(missing, 0.0, said - self.measured) @ self.whitener.T
        return np.where(missing, _NO_ANSWER, apart)


@dataclass(frozen=True, eq=False)
class Solution:
    """The best of all starts."""

    x: Array
    """Coordinates, (p,)."""
    cost: float
    """Half the sum of the softened squares."""
    jacobian: Array
    """Of the whitened residuals, (m, p), not softened."""
    residual: Array
    """Whitened, (m,)."""
    agreeing: int
    """Searches that ended within one unit of the best cost, this one included."""
    searches: int


def solve(
    predict: Predict,
    problem: Problem,
    start: Array,
    *,
    reach: Array,
    seed: int,
    candidates: int = 32,
    searches: int = 3,
    progress: Callable[[int, int], None] | None = None,
) -> Solution:
    """Return the best of `searches` runs of the trust-region reflective method (Branch, Coleman & Li 1999; SciPy).

    It runs from `start` (p,) and from the best of `candidates` points of a Latin hypercube (McKay et al. 1979) that
    lie within `reach` (p,) of it; `seed` makes that repeatable. Residuals are softened by SOFT. `progress` is told
    (steps done, in all at most): a search that ends early leaps ahead. Raises ValueError where there are fewer
    observables than parameters, and where the model has no answer at the start. Limit: a local method; a resonance
    that lies out of reach of every start is not found.
    """
    if len(problem.measured) < len(start):
        raise ValueError(
            f"There are {len(problem.measured)} observables for {len(start)} free parameters; give more dwells."
        )
    tell, most = progress or (lambda done, total: None), _EVALUATIONS * (1 + max(0, min(searches - 1, candidates)))
    tell(0, most)
    firsts = _starts(predict, problem, start, reach, seed, candidates, searches)
    ends = []
    for k, first in enumerate(firsts):
        begin = k * _EVALUATIONS
        ends.append(_search(predict, problem, first, lambda step, begin=begin: tell(begin + step, most)))  # type: ignore[misc]
        tell(begin + _EVALUATIONS, most)
    x, cost = min(ends, key=lambda end: end[1])
    agreeing = sum(own <= cost + 1.0 for _, own in ends)
    return Solution(
        x, cost, jacobian(predict, problem, x), problem.residual(predict(x[None])[0]), agreeing, len(firsts)
    )


def jacobian(predict: Predict, problem: Problem, x: Array) -> Array:
    """Return the Jacobian of the whitened residuals at `x` (p,), (m, p), by central differences within the bounds."""
    steps = STEP * np.eye(len(x))
    ahead, behind = np.minimum(x + steps, problem.high), np.maximum(x - steps, problem.low)
    said = problem.residual(predict(np.concatenate([ahead, behind])))
    width = np.diag(ahead - behind)[:, None]
    return np.asarray(((said[: len(x)] - said[len(x) :]) / width).T)


def _starts(
    predict: Predict, problem: Problem, start: Array, reach: Array, seed: int, candidates: int, searches: int
) -> Sequence[Array]:
    if not np.isfinite(predict(start[None])).any():
        raise ValueError("The model diverges in every dwell at the start; set parameters nearer to the bench.")
    first = np.clip(start, problem.low, problem.high)
    if searches < 2 or candidates < 1:
        return [first]
    drawn = qmc.LatinHypercube(len(start), seed=np.random.default_rng(seed)).random(candidates)
    points = np.clip(start + reach * (2 * drawn - 1), problem.low, problem.high)
    costs = _soft(problem.residual(predict(points))).sum(axis=-1)
    return [first, *points[np.argsort(costs)[: searches - 1]]]


def _search(predict: Predict, problem: Problem, first: Array, tell: Callable[[int], None]) -> tuple[Array, float]:
    # SciPy wants a start inside the bounds.
    inside = np.clip(first, problem.low + 1e-6, problem.high - 1e-6)
    step = count()

    def slopes(x: Array) -> Array:
        tell(next(step))
        return jacobian(predict, problem, x)

    found = least_squares(
        lambda x: problem.residual(predict(x[None])[0]),
        inside,
        jac=slopes,
        bounds=(problem.low, problem.high),
        loss="soft_l1",
        f_scale=SOFT,
        max_nfev=_EVALUATIONS,
        ftol=_ENOUGH,
        xtol=_ENOUGH,
        gtol=None,
    )
    return np.asarray(found.x, dtype=float), float(found.cost)


def _soft(residual: Array) -> Array:
    return np.asarray(SOFT**2 * (np.sqrt(1 + (residual / SOFT) ** 2) - 1))
