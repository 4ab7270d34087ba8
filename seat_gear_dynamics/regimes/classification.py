"""Deciding the regime of a motion from its section and the growth of its tangent, with the evidence."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.exponent import Exponent, largest_exponent, weighted_exponent
from seat_gear_dynamics.regimes.pieces import MOST_PIECES, Pieces, pieces
from seat_gear_dynamics.regimes.section import LONGEST_PERIOD, find_period, shrinkage
from seat_gear_dynamics.regimes.winding import by_piece, wandering, winding_number
from seat_gear_dynamics.regimes.zero_one import SHORTEST_SERIES, ZeroOne, zero_one

Array = NDArray[np.float64]
Name = Literal["periodic", "quasi-periodic", "chaotic", "undecided"]

SHORTEST_RECORD = 3 * LONGEST_PERIOD
"""Section points below which nothing is decided."""
SHORTEST_TORUS = SHORTEST_SERIES
"""Section points below which nothing is called quasi-periodic."""
TOLERANCE = 1e-3
"""Recurrence, in units of b_c, within which a clean simulation counts as periodic."""
LEAST_CHAOS = 0.005
"""Exponents below this per unit τ are not told from zero: nearly free rotation and slow supports sit there."""
STEADY = 0.003
"""Standard deviations within which averages over parts of a record agree on a torus; `wandering` has the measure."""
_SURE = 3.0  # standard errors
_BEYOND_DOUBT = 6.0  # standard errors from which an exponent needs no second witness
_LEAST_SHRINKAGE = 0.05  # share over a record within which the size of a torus may seem to change for want of turns
_CLEAR = 50.0  # standard errors beyond which a change of size is believed however small
_CLEAR_SHRINKAGE = 0.001  # the share that counts then
_SEED = 20090129  # of the 0-1 test's frequencies: a fixed one keeps every judgement the same


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
    pieces: int | None = None
    """Closed curves of a torus, bands of chaos, as far as this record resolves them; None for other motion."""
    winding: float | None = None
    """Share of a turn that a torus makes around a curve from one visit to the next, 0 to 0.5; else None."""
    zero_one: float | None = None
    """K of the 0-1 test; None where it was not needed or the record is too short for it."""

    @property
    def leans_chaotic(self) -> bool:
        """True while undecided with an exponent that is positive by one standard error: evidence building."""
        if self.name != "undecided" or self.lyapunov is None or self.lyapunov_error is None:
            return False
        return self.lyapunov - self.lyapunov_error > LEAST_CHAOS

    @property
    def label(self) -> str:
        """The regime in the literature's short form: period-2, quasi-period-3, 4-band chaos, chaos, undecided."""
        if self.name == "periodic":
            return f"period-{self.period}"
        if self.name == "quasi-periodic":
            return f"quasi-period-{self.pieces}"
        if self.name == "chaotic":
            return f"{self.pieces}-band chaos" if self.pieces and self.pieces > 1 else "chaos"
        return self.name


def warm_up() -> None:
    """Judge a small torus, which compiles all that a judgement may need: a running drive then never waits for it."""
    angle = np.pi * (5**0.5 - 1) * np.arange(SHORTEST_TORUS)
    classify(np.column_stack([np.cos(angle), np.sin(angle)]), np.zeros(SHORTEST_TORUS), 1.0)


def undecided(reason: str) -> Regime:
    """Return the regime of a motion that nothing can be said of, with the reason."""
    return Regime("undecided", None, None, None, reason)


def classify(section: Array, growth: Array, interval: float, *, tolerance: float = TOLERANCE) -> Regime:
    """Return the regime of a motion sampled once a mesh period.

    `section` (n, 2) in units of b_c; `growth` (n,) logarithmic tangent growth per period; `interval` the mesh period in
    τ. A record that leaves doubt is judged by its later half, where that shows periodic or quasi-periodic motion.

    - Periodic: the section recurs within `tolerance`, and the exponent does not contradict.
    - Chaotic: it does not recur, and the largest exponent is positive by three standard errors. Between three and six
      of them the averages of the section must not agree as a torus's do.
    - Quasi-periodic: it does not recur; the exponent is not told from zero; the size of the motion does not shrink;
      its points fill closed curves (`pieces`); averages over parts of the record agree (`wandering`); the 0-1 test,
      where the record is long enough for it, does not say chaos.
    - Undecided: everything else, with the numbers that speak against the rest.

    Limits. Chaos with an exponent below LEAST_CHAOS stays undecided. A transient that shrinks by less than about 2 % in
    the record and is no plain spiral may pass for a torus. A torus needs about ten turns around its curves,
    and noise on it below about a hundredth of its size. A locked motion whose period is longer than a third of the
    record passes for a torus. Chaos and tori that are smaller than `tolerance` pass for periodic.
    """
    n = len(section)
    if n < SHORTEST_RECORD:
        return undecided(f"{n} section points, {SHORTEST_RECORD} needed")
    if not (np.isfinite(section).all() and np.isfinite(growth).all()):
        return undecided("the record holds numbers that are not finite")
    whole, half = _judge(section, growth, interval, tolerance), n // 2
    if half < SHORTEST_RECORD or whole.name in ("periodic", "quasi-periodic") or whole.leans_chaotic:
        return whole
    if whole.name == "chaotic":
        return _unless_over(whole, section[-max(SHORTEST_RECORD, n // 4) :], tolerance)
    late = _judge(section[-half:], growth[-half:], interval, tolerance)
    # Half a record may be too short for the 0-1 test to object to a torus; what it said of the whole then stands.
    objects = late.name == "quasi-periodic" and ZeroOne(whole.zero_one, None, n).verdict == "chaotic"
    if late.name not in ("periodic", "quasi-periodic") or objects:
        return whole
    return replace(late, reason=f"the last {half} of {n} points: {late.reason}")


def _judge(section: Array, growth: Array, interval: float, tolerance: float) -> Regime:
    """Return the regime that the record as a whole shows."""
    exponent = largest_exponent(growth, interval)
    measured = f"exponent {exponent.value:.4f} ± {exponent.error:.4f}"
    longest = max(LONGEST_PERIOD, len(section) // 3)
    period = find_period(section, tolerance=tolerance, longest=longest)
    if period is not None:
        return _periodic(period, exponent, tolerance, measured)
    irregular = f"no period up to {longest}, {measured}"
    found = pieces(section)
    if exponent.above(LEAST_CHAOS, errors=_SURE):
        return _chaotic(section, exponent, found, tolerance, irregular)
    settling = _settling(section, found.count)
    if settling is not None:
        return _doubtful(exponent, f"{settling}, {measured}")
    # A torus's growth comes and goes with its phase, which its weighted average sees through.
    weighted = weighted_exponent(growth, interval)
    if exponent.within(LEAST_CHAOS, errors=_SURE) or weighted.within(LEAST_CHAOS, errors=_SURE):
        return _neutral(section, exponent, found, tolerance, irregular)
    return _doubtful(exponent, f"{irregular}: more time needed")


def _doubtful(exponent: Exponent, reason: str, test: ZeroOne | None = None) -> Regime:
    value = None if test is None else test.value
    return Regime("undecided", None, exponent.value, exponent.error, reason, zero_one=value)


def _periodic(period: int, exponent: Exponent, tolerance: float, measured: str) -> Regime:
    recurs = f"recurs after {period} within {tolerance:g} b_c"
    if exponent.above(LEAST_CHAOS, errors=_SURE):
        return _doubtful(exponent, f"{recurs}, but {measured}: an unstable motion not yet left, or finer chaos")
    return Regime("periodic", period, exponent.value, exponent.error, recurs)


def _chaotic(section: Array, exponent: Exponent, found: Pieces, tolerance: float, irregular: str) -> Regime:
    if not exponent.above(LEAST_CHAOS, errors=_BEYOND_DOUBT):
        wanders = wandering(section, pieces=found.count)
        if wanders <= _steady(section, found.count, tolerance):
            return _doubtful(exponent, f"{irregular}, but averages agree to {wanders:.1g} as on a torus")
    bands = f", {found.count} bands" if found.count > 1 else ""
    return Regime("chaotic", None, exponent.value, exponent.error, irregular + bands, pieces=found.count)


def _unless_over(whole: Regime, late: Array, tolerance: float) -> Regime:
    """Return the chaotic regime unless its end recurs: then the chaos may be over, or only pausing."""
    period = find_period(late, tolerance=tolerance)
    if period is None:
        return whole
    reason = f"{whole.reason}, but the last {len(late)} points recur after {period}: a transient, or intermittency"
    return replace(whole, name="undecided", reason=reason, pieces=None)


def _settling(section: Array, count: int) -> str | None:
    """Return in words how the size of the motion changes, or None where it keeps."""
    shrinks = shrinkage(section, pieces=count)
    errors = abs(shrinks.rate) / shrinks.error if shrinks.error else np.inf
    share = abs(shrinks.rate) * len(section)
    if errors <= _SURE or share <= (_CLEAR_SHRINKAGE if errors > _CLEAR else _LEAST_SHRINKAGE):
        return None
    percent = f"by {100 * abs(shrinks.rate):.2g} ± {100 * shrinks.error:.1g} % a period"
    return f"still settling, shrinks {percent}" if shrinks.rate > 0 else f"grows {percent}, or turns too slowly to tell"


def _neutral(section: Array, exponent: Exponent, found: Pieces, tolerance: float, irregular: str) -> Regime:
    """Tell a torus from weak chaos, noise and slow transients where the exponent is not told from zero."""
    wanders, steady = wandering(section, pieces=found.count), _steady(section, found.count, tolerance)
    test = zero_one(_residual(section, found.count), np.random.default_rng(_SEED))
    against = _against_torus(len(section), found, wanders, steady, test)
    if against is not None:
        return _doubtful(exponent, f"{irregular}; {against}", test)
    winding = winding_number(section, pieces=found.count)
    curves = "1 closed curve" if found.count == 1 else f"{found.count} closed curves"
    reason = f"{irregular}; {curves}, winding number {winding:.4f}, averages agree to {wanders:.1g}{_said(test)}"
    return Regime(
        "quasi-periodic", None, exponent.value, exponent.error, reason, found.count, winding, zero_one=test.value
    )


def _against_torus(n: int, found: Pieces, wanders: float, steady: float, test: ZeroOne) -> str | None:
    """Return in words what speaks against a torus, or None."""
    if n < SHORTEST_TORUS:
        return f"{n} section points, {SHORTEST_TORUS} needed to tell a torus"
    if not found.closed:
        return f"{found.count} arcs that have not come round: more time needed"
    if found.count == MOST_PIECES or not found.filled:
        return (
            f"{found.count} pieces with holes of {100 * found.gap:.0f} % of their extent: a cascade, or too few points"
        )
    if wanders > steady:
        cause = "weak chaos or noise" if test.verdict == "chaotic" else "a slow transient or torus, weak chaos or noise"
        return f"averages differ by {wanders:.2g}, {steady:.1g} allowed{_said(test)}: {cause}"
    if test.verdict == "chaotic":
        return f"averages agree to {wanders:.1g} as on a torus{_said(test)} as for chaos: more time needed"
    return None


def _said(test: ZeroOne) -> str:
    return "" if test.value is None else f", 0-1 test {test.value:.2f}"


def _residual(section: Array, count: int) -> Array:
    """Return the livelier coordinate with the mean of each piece taken out, which would hide what the pieces do."""
    rounds = by_piece(section, count)
    scatter = (rounds - rounds.mean(axis=0)).reshape(-1, 2)
    return np.asarray(scatter[:, int(np.argmax(scatter.var(axis=0)))])


def _steady(section: Array, count: int, tolerance: float) -> float:
    """Return the wandering allowed to a torus: STEADY, and up to as much again for noise within the tolerance."""
    size = float(by_piece(section, count).std(axis=0).max())
    noise = tolerance / (size * float(np.sqrt(len(section)))) if size else 0.0
    return STEADY + min(noise, STEADY)
