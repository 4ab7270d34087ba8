"""How sure a fit is: intervals, what cannot be told apart, and what the record does not say at all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

from seat_gear_dynamics.studies.identification.fit import Problem, Solution

Array = NDArray[np.float64]

WIDEST = float(np.log(2.0))
"""A parameter whose 95 % interval would reach beyond a factor of two either way is not identified."""
LEVEL = 0.95
REPLICATES = 1000


@dataclass(frozen=True, eq=False)
class Confidence:
    """What the linearised fit says of the free parameters; coordinates are natural logarithms."""

    half_width: Array
    """Of the 95 % intervals by the Jacobian, (p,); inf where the record says nothing."""
    bootstrap: Array
    """2.5 and 97.5 % points of the block bootstrap, relative to the solution, (p, 2)."""
    identified: NDArray[np.bool_]
    """(p,)"""
    correlation: Array
    """Of the estimates, (p, p); NaN with a parameter that nothing depends on."""
    singular_values: Array
    """Of the whitened Jacobian, descending, (p,): standard deviations that a unit of a logarithm moves the record."""
    weakest: Array
    """Direction in the coordinates that the record sees least, of length 1, (p,)."""
    scale: float
    """Standard deviation of the whitened residuals: 1 where model and stated errors agree with the record."""

    @property
    def condition(self) -> float:
        """Largest over smallest singular value."""
        least = float(self.singular_values[-1])
        return float(self.singular_values[0]) / least if least > 0 else float("inf")


def confidence(solution: Solution, problem: Problem, dwell: Array, *, seed: int) -> Confidence:
    """Return how sure `solution` is; `dwell` (m,) says to which dwell each observable belongs.

    The intervals are Student's with s²(JᵀJ)⁻¹, s² from the residuals (Seber & Wild 1989, ch. 5) but 1 at least: a
    calibration error that all samples share does not scatter, so small residuals do not show that errors are less than
    stated. The bootstrap draws whole dwells with replacement and moves the solution by one Gauss-Newton step each
    (one-step bootstrap; Shao & Tu 1995, sec. 8.4), REPLICATES times from `seed`: it shows how much dwells differ. A
    parameter is not identified where either interval passes WIDEST, where it would rest on one dwell alone, or where
    the solution stands at a bound. Limits: both are linear in the logarithms about one solution, and know nothing of
    what the model leaves out; drawing from fewer than some eight dwells gives rough intervals.
    """
    jacobian, residual = solution.jacobian, solution.residual
    count, free = jacobian.shape
    _, singular, directions = np.linalg.svd(jacobian, full_matrices=False)
    freedom = max(count - free, 1)
    scale = float(np.sqrt(residual @ residual / freedom))
    used = max(scale, 1.0)
    covariance = _inverse(jacobian) * used**2
    deviation = np.sqrt(np.diag(covariance))
    half = np.where(np.isfinite(deviation), deviation * t.ppf((1 + LEVEL) / 2, freedom), np.inf)
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(deviation, deviation)
    at_bound = (solution.x < problem.low + 1e-3) | (solution.x > problem.high - 1e-3)
    replicates = _replicates(jacobian, residual, dwell, seed)
    bootstrap = np.quantile(replicates, ((1 - LEVEL) / 2, (1 + LEVEL) / 2), axis=0).T
    return Confidence(
        half,
        bootstrap,
        (half < WIDEST) & (np.abs(bootstrap).max(axis=1) < WIDEST) & ~at_bound & _survives(jacobian, dwell, used),
        correlation,
        singular,
        directions[-1],
        scale,
    )


def partners(found: Confidence, names: Sequence[str], index: int) -> list[str]:
    """Return the parameters that the record confuses with `index`: in its weakest direction, or correlated by 0.9."""
    shared = np.abs(found.weakest) > 0.3
    row = np.abs(found.correlation[index])
    together = (shared & shared[index]) | (np.isfinite(row) & (row > 0.9))
    return [name for k, name in enumerate(names) if together[k] and k != index]


def _survives(jacobian: Array, dwell: Array, scale: float) -> NDArray[np.bool_]:
    """Return whether each parameter's standard error stays below WIDEST whichever one dwell is taken away, (p,)."""
    found = np.ones(jacobian.shape[1], dtype=bool)
    for taken in np.unique(dwell):
        deviation = scale * np.sqrt(np.diag(_inverse(jacobian[dwell != taken])))
        found &= np.nan_to_num(deviation, nan=np.inf) < WIDEST
    return found


def _inverse(jacobian: Array) -> Array:
    """Return (JᵀJ)⁻¹, with inf and NaN for parameters that nothing depends on."""
    free = jacobian.shape[1]
    inverse = np.full((free, free), np.nan)
    felt = np.linalg.norm(jacobian, axis=0) > 1e-9
    inverse[np.diag_indices(free)] = np.inf
    if felt.any():
        inverse[np.ix_(felt, felt)] = np.linalg.pinv(jacobian[:, felt].T @ jacobian[:, felt], rcond=1e-14)
    return inverse


def _replicates(jacobian: Array, residual: Array, dwell: Array, seed: int) -> Array:
    """Return how far each draw of dwells moves the solution, (REPLICATES, p)."""
    dwells = np.unique(dwell)
    squares = np.array([jacobian[dwell == d].T @ jacobian[dwell == d] for d in dwells])
    slopes = np.array([jacobian[dwell == d].T @ residual[dwell == d] for d in dwells])
    drawn = np.random.default_rng(seed).multinomial(len(dwells), np.full(len(dwells), 1 / len(dwells)), REPLICATES)
    left, right = np.tensordot(drawn, squares, 1), np.tensordot(drawn, slopes, 1)
    # A draw may lack a parameter's only dwell: the smallest step that explains the rest.
    return np.array([-np.linalg.lstsq(a, b, rcond=1e-12)[0] for a, b in zip(left, right, strict=True)])
