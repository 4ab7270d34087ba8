"""Deciding the regime of a motion from its section and the growth of its tangent, with the evidence."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.exponent import largest_exponent
from seat_gear_dynamics.regimes.section import LONGEST_PERIOD, find_period, recurrence

Array = NDArray[np.float64]
Name = Literal["periodic", "quasi-periodic", "chaotic", "undecided"]

SHORTEST_RECORD = 3 * LONGEST_PERIOD
"""Section points below which nothing is decided."""
TOLERANCE = 1e-3
"""Recurrence, in units of b_c, within which a clean simulation counts as periodic."""
LEAST_CHAOS = 0.005
"""Exponents below this per unit τ are not told from zero: nearly free rotation and slow supports sit there."""
_SURE = 3.0  # standard errors


@dataclass(frozen=True)
class Regime:
    """What a motion is, and why this is said."""

    name: Name
    period: int | None
    """Period in mesh periods for periodic motion, else None."""
    lyapunov: float | None
    """Largest exponent per unit of τ; None where the record is too short for one."""
    lyapunov_error: float | None
    """Its standard error."""
    reason: str
    """The evidence in words."""

    @property
    def leans_chaotic(self) -> bool:
        """True while undecided with an exponent that is positive by one standard error: evidence building."""
        if self.name != "undecided" or self.lyapunov is None or self.lyapunov_error is None:
            return False
        return self.lyapunov - self.lyapunov_error > LEAST_CHAOS


def undecided(reason: str) -> Regime:
    """Return the regime of a motion that nothing can be said of, with the reason."""
    return Regime("undecided", None, None, None, reason)


def classify(section: Array, growth: Array, interval: float, *, tolerance: float = TOLERANCE) -> Regime:
    """Return the regime of a motion sampled once a mesh period.

    `section` (n, 2) in units of b_c; `growth` (n,) logarithmic tangent growth per period; `interval` the mesh period in
    τ. Periodic: the section recurs within `tolerance`. Chaotic: it does not, and the largest exponent is positive by
    three standard errors. Quasi-periodic: it does not, the exponent is not told from zero and the irregularity is not
    shrinking. Everything else is undecided, and says why. Limit: a transient longer than the record looks
    quasi-periodic.
    """
    n = len(section)
    if n < SHORTEST_RECORD:
        return undecided(f"{n} section points, {SHORTEST_RECORD} needed")
    if not (np.isfinite(section).all() and np.isfinite(growth).all()):
        return undecided("the record holds numbers that are not finite")
    exponent = largest_exponent(growth, interval)
    value, error = exponent.value, exponent.error
    period = find_period(section, tolerance=tolerance)
    if period is not None:
        return Regime("periodic", period, value, error, f"recurs after {period} within {tolerance:g} b_c")
    measured = f"exponent {value:.4f} ± {error:.4f}"
    if value - _SURE * error > LEAST_CHAOS:
        return Regime("chaotic", None, value, error, f"no period up to {LONGEST_PERIOD}, {measured}")
    if abs(value) <= LEAST_CHAOS and _SURE * error <= LEAST_CHAOS:
        return _near_zero(section, value, error, measured)
    return Regime("undecided", None, value, error, f"no period up to {LONGEST_PERIOD}, {measured}: more time needed")


def _near_zero(section: Array, value: float, error: float, measured: str) -> Regime:
    """Tell quasi-periodic motion from a transient that is still decaying: the latter recurs better and better."""
    half = len(section) // 2
    periods = range(1, min(LONGEST_PERIOD, half // 3) + 1)
    early = min(recurrence(section[:half], p) for p in periods)
    late = min(recurrence(section[half:], p) for p in periods)
    if late < 0.8 * early:
        return Regime(
            "undecided",
            None,
            value,
            error,
            f"still settling (recurrence {early:.2g}, then {late:.2g}), {measured}",
        )
    return Regime("quasi-periodic", None, value, error, f"no period up to {LONGEST_PERIOD}, {measured}")
