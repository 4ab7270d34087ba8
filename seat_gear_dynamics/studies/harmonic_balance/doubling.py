"""The motion of twice the period that is born where a multiplier passes -1."""

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.balance import Balance, balance
from seat_gear_dynamics.studies.harmonic_balance.branch import Bifurcation
from seat_gear_dynamics.studies.harmonic_balance.continuation import Arc, Point, step_along
from seat_gear_dynamics.studies.harmonic_balance.newton import NoSolutionError

Array = NDArray[np.float64]

_STEPS = (0.01, 0.03, 0.1, 0.3)  # scaled arc off the branch that bifurcates; the first that converges is taken


def doubled(balanced: Balance) -> Balance:
    """Return the same balance for motions of twice the period, with the same harmonics of the mesh frequency."""
    return balance(
        balanced.pair,
        balanced.conditions,
        harmonics=balanced.basis.harmonics // balanced.subharmonics,
        subharmonics=2 * balanced.subharmonics,
        parameter=balanced.parameter,
    )


def branch_off(bifurcation: Bifurcation, arc: Arc) -> tuple[Balance, Point]:
    """Return the balance and a first point of the branch born at a period doubling, its tangent leading away.

    The old motion, written with twice the period, makes a Jacobian that is singular in the odd harmonics alone; the
    null vector there is the way off. The same branch shifted by one old period is the same motion. Raises ValueError
    for another bifurcation and NoSolutionError where no step off the old branch converges.
    """
    if bifurcation.kind != "period doubling":
        raise ValueError(f"The bifurcation is a {bifurcation.kind}, expected a period doubling.")
    target = doubled(bifurcation.motion.orbit.balance)
    unknowns = target.basis.resampled(bifurcation.motion.orbit.coefficients, 2)
    _, jacobian, _ = target.evaluate(unknowns, bifurcation.parameter)
    odd = _odd(target.basis.harmonics)
    direction = np.zeros(target.basis.size + 1)
    direction[:-1][odd] = np.linalg.svd(jacobian[np.ix_(odd, odd)])[2][-1]
    origin = Point(unknowns, bifurcation.parameter, direction)
    for step in _STEPS:
        try:
            point, _ = step_along(target, origin, step, arc)
        except NoSolutionError:
            continue
        if np.linalg.norm(point.unknowns[odd]) > 0.5 * step * arc.scale:
            return target, point
    raise NoSolutionError(
        f"No motion of {target.subharmonics} mesh periods was found beside the period doubling at "
        f"{bifurcation.parameter:.6g}; ask for more harmonics, or start from an integrated motion."
    )


def _odd(harmonics: int) -> NDArray[np.int64]:
    """Return where the coefficients of odd harmonics stand."""
    orders = np.concatenate([np.arange(harmonics + 1), np.arange(1, harmonics + 1)])
    return np.flatnonzero(orders % 2 == 1)
