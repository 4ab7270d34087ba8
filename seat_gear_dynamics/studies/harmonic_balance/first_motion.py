"""A first motion to start a branch from, found without knowing anything of it."""

from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion import System
from seat_gear_dynamics.studies.harmonic_balance.balance import Balance
from seat_gear_dynamics.studies.harmonic_balance.continuation import Arc, follow, start
from seat_gear_dynamics.studies.harmonic_balance.integration import coefficients, settle
from seat_gear_dynamics.studies.harmonic_balance.newton import NoSolutionError, solve

Array = NDArray[np.float64]

_PERIODS = 600
_POINTS = 500


def first_motion(system: System, problem: Balance, value: float) -> Array:
    """Return the coefficients, (m,), of a motion at `value` of the parameter, stable or not.

    Newton's method from teeth in contact; where that fails, the motion without backlash, which is linear, followed
    while the backlash opens; where its branch turns back before, the motion that integration from rest settles on.
    Which motion it is, of several, is left open. Raises NoSolutionError where all three fail, and
    `motion.march.DivergedError` where the motion blows up.
    """
    for attempt in (_from_contact, _from_no_backlash):
        try:
            return attempt(problem, value)
        except NoSolutionError:
            continue
    recorded = settle(system_at(system, problem, value), periods=problem.subharmonics, transient=_PERIODS)
    return solve(problem, coefficients(recorded, problem), value)


def system_at(system: System, problem: Balance, value: float) -> System:
    """Return the system under the problem's conditions with its parameter at `value`."""
    at = problem.at(value)
    train = system.train.with_mesh(0, damping_ratio=at.damping_ratio, backlash=at.backlash)
    return System(train).at(frequency=at.frequency, load=at.load)


def _in_contact(problem: Balance, value: float) -> Array:
    """Return a deflection that stays on the loaded flank, from where Newton's first step is the linear motion."""
    at = problem.at(value)
    still = np.zeros(problem.basis.size)
    still[0] = (np.sign(at.load) or 1.0) * (2 * problem.pair.half_backlash(at) + 1.0)
    return still


def _from_contact(problem: Balance, value: float) -> Array:
    return solve(problem, _in_contact(problem, value), value)


def _from_no_backlash(problem: Balance, value: float) -> Array:
    """Return the motion reached by opening the backlash; raises NoSolutionError where its branch does not get there."""
    at = problem.at(value)
    opening = replace(problem, conditions=at, parameter="backlash")
    if not at.backlash:
        raise NoSolutionError("The motion has no backlash to open; give one, or start from an integrated motion.")
    arc = Arc(0.2, at.backlash / 10)
    linear = start(opening, _in_contact(opening, 0.0), 0.0, arc)
    last = [linear, *islice(follow(opening, linear, 0.0, at.backlash, arc), _POINTS)][-1]
    if last.parameter != at.backlash:
        raise NoSolutionError(
            f"The motion without backlash ends at a backlash of {last.parameter:.3g} m; expected it to reach "
            f"{at.backlash:.3g} m: start from an integrated motion."
        )
    return last.unknowns
