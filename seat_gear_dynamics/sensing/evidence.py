"""Evidence of danger on one scale, log-odds, and what all of it together says."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from math import exp, isfinite, log
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes import Regime
from seat_gear_dynamics.regimes.classification import LEAST_CHAOS

Array = NDArray[np.float64]
Kind = Literal["band", "approach", "probability", "motion"]

WARN_FROM = -1.0
"""Log-odds above which evidence warns: 27 %."""
ERROR_FROM = 4.5
"""Log-odds from which evidence of the motion is an error: 99 %."""
PRIOR = -2.0
"""Log-odds of chaos where no map says more: 12 %, less than the share of the studied speeds that are forbidden."""
SCATTER_POINTS = 64
"""Section points that the scatter is measured on."""
_MOST = 5.0  # standard errors that count: more of them make a moment surer, but no moment lasts
_SURE = 3.0  # standard errors that the classification asks of chaos
_UNDECIDED_MOST = 2.5  # likewise while the classification does not vouch for the motion
_PRIOR_MOST = 3.0  # log-odds either way that a map's probability counts before the motion is seen
_SECTION = {"chaotic": 1.0, "undecided": 0.0, "quasi-periodic": -2.0, "periodic": -3.0}
_LASTING_MOST = 3  # records
_TEST = 0.5  # log-odds of the 0-1 test either way: below 300 points it is a hint
_TEST_BOUNDS = (0.2, 0.8)
_SCATTER = 0.5  # log-odds of the section's scatter either way
_SCATTER_BOUNDS = (0.05, 0.3)  # b_c: noise on a period, and chaos
_LONGEST = 16  # mesh periods after which points are looked for again
_ROUNDING = 1e-9


class Level(IntEnum):
    """Levels with the numbers of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Evidence:
    """One sign of danger: what it supports by itself, how likely it makes danger, and why."""

    kind: Kind
    level: Level
    probability: float
    text: str


@dataclass(frozen=True)
class Motion:
    """What the running model says about chaos, in log-odds."""

    odds: float
    """Sum of all that counts."""
    level: Level
    parts: tuple[tuple[str, float], ...]
    """(what, log-odds) of the prior and of each piece of evidence."""

    @property
    def seen(self) -> bool:
        """Whether anything but the prior counted."""
        return len(self.parts) > 1

    @property
    def probability(self) -> float:
        """Of chaos."""
        return probability_of(self.odds)

    @property
    def words(self) -> str:
        """The parts in words, as in `prior -2.0, exponent +6.0, section +1.0`."""
        return ", ".join(f"{name} {weight:+.1f}" for name, weight in self.parts)


def weigh(
    regime: Regime, prior: float | None = None, scatter: float | None = None, *, lasting: int = 0, settled: bool = True
) -> Motion:
    """Return the log-odds that the motion is chaotic, from a judgement of it and what was likely before.

    `prior` is a map's probability of chaos (None: PRIOR is used); `scatter` that of the section, see `scatter_of`;
    `lasting` the number of further records, without a point in common, that have shown chaos without a break. Added
    are: the exponent's distance from LEAST_CHAOS in its standard errors, at most 5, and 2.5 while the regime is
    undecided; +1 where the classification finds chaos, -2 for a torus, -3 for a period; +1 for each lasting record, at
    most 3; half a unit each for the 0-1 test and the scatter, the latter only where it agrees with the exponent's sign.

    What it takes: the classification asks three errors. It judges 25 times a second, some 7000 times an hour without
    common points, and the error of an exponent from 48 to 192 points may be half as large again as it says; for less
    than one mistake an hour an exponent alone would have to have 5.5 of them (3.6 of a normal distribution). But one
    record tells of half a second: beside a band calm motion may have chaotic spells, after a change of drive or by the
    noise that the model is driven with, and they are as sure as any chaos. So without a map no record is an ERROR
    alone: chaos of 4.5 errors has to last for half a second, one of 3.5 for a second. Where a map gives no chaos it
    takes half a second more, where it gives chaos there is no wait. Chaos that falls short, and one that leans
    (one error), is a WARN. A model that is not `settled` since it began at rest
    has a transient that the machine has not: nothing but the prior counts. Limit: the pieces are not independent, all
    come of one run of one model; that is why each is bounded.
    """
    parts = [("prior", PRIOR if prior is None else min(max(_log_odds(prior), -_PRIOR_MOST), _PRIOR_MOST))]
    if not settled:
        return Motion(parts[0][1], Level.OK, tuple(parts))
    exponent = _exponent(regime)
    if exponent is not None:
        parts.append(("exponent", exponent))
    if _SECTION[regime.name]:
        parts.append(("section", _SECTION[regime.name]))
    if regime.zero_one is not None and regime.name == "undecided":
        parts.append(("0-1 test", _TEST * _side(regime.zero_one, _TEST_BOUNDS)))
    if scatter is not None and regime.name == "undecided" and exponent is not None:
        side = _side(scatter, _SCATTER_BOUNDS)
        if side * (exponent - 1) > 0:
            parts.append(("scatter", _SCATTER * side))
    if lasting and regime.name == "chaotic":
        parts.append(("lasting", float(min(lasting, _LASTING_MOST))))
    odds = sum(weight for _, weight in parts)
    return Motion(odds, _level(odds, seen=len(parts) > 1), tuple(parts))


def scatter_of(section: Array) -> float | None:
    """Return how far section points lie from those 1 to 16 mesh periods before, at the best of these, in b_c.

    `section` (n, 2 or more): δ/b_c, rate, …; the last 64 are looked at. The median over points of the larger
    coordinate's distance: near 0 for a period, of the section's size for chaos and tori. None below 32 points.
    """
    points = section[-SCATTER_POINTS:, :2]
    if len(points) < 2 * _LONGEST:
        return None
    distances = (np.abs(points[period:] - points[:-period]).max(axis=1) for period in range(1, _LONGEST + 1))
    return min(_median(each) for each in distances)


def _median(values: Array) -> float:
    """Return what np.median does, at a fifth of its cost: this runs for every judgement of a running drive."""
    middle = len(values) // 2
    halves = np.partition(values, (middle - 1, middle))
    return float(halves[middle]) if len(values) % 2 else float(halves[middle - 1] + halves[middle]) / 2


def probability_of(odds: float) -> float:
    """Return the probability of log-odds."""
    return 1 / (1 + exp(-min(max(odds, -40.0), 40.0)))


def together(evidence: Sequence[Evidence]) -> float:
    """Return the probability that the drive is in danger: of its place or of its motion, which are two things.

    Signs of one danger tell of the same fact, so of each danger the strongest counts; the two are taken as independent.
    """
    calm = 1.0
    for kinds in (("band", "approach"), ("probability", "motion")):
        calm *= 1 - max((each.probability for each in evidence if each.kind in kinds), default=0.0)
    return 1 - calm


def warns(probability: float) -> bool:
    """Return whether a probability of danger is enough to warn."""
    return _log_odds(probability) > WARN_FROM


def closeness(share: float) -> float:
    """Return the probability that stands for being near: `share` 0 is at a band, 1 at the limit from which to warn."""
    return probability_of(ERROR_FROM + (WARN_FROM - ERROR_FROM) * max(share, 0.0))


def _exponent(regime: Regime) -> float | None:
    if regime.lyapunov is None or regime.lyapunov_error is None:
        return _SURE if regime.name == "chaotic" else None
    above = regime.lyapunov - LEAST_CHAOS
    errors = above / regime.lyapunov_error if regime.lyapunov_error else _MOST * float(np.sign(above))
    if not isfinite(errors):
        return None
    most = _UNDECIDED_MOST if regime.name == "undecided" else _MOST
    return max(-_MOST, min(errors, most))


def _level(odds: float, *, seen: bool) -> Level:
    if not seen:
        return Level.OK
    if odds >= ERROR_FROM - _ROUNDING:
        return Level.ERROR
    return Level.WARN if odds > WARN_FROM + _ROUNDING else Level.OK


def _side(value: float, bounds: tuple[float, float]) -> float:
    """Return -1 below the bounds, +1 above, 0 between."""
    return float(value >= bounds[1]) - float(value <= bounds[0])


def _log_odds(probability: float) -> float:
    bounded = min(max(probability, 1e-12), 1 - 1e-12)
    return log(bounded / (1 - bounded))
