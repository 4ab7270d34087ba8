"""Periods in a stroboscopic Poincaré section, and whether what it shows still shrinks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.winding import by_piece

Array = NDArray[np.float64]

LONGEST_PERIOD = 16
"""Longest period looked for by itself, in mesh periods; longer ones are believed only with their points well apart."""
_DRIFT = 2  # tolerances by which a point of a period may move in the whole record
_APART = 4  # how much farther apart the points of a long period lie than each of them moves
_EVEN = 0.7  # share of the way of even steps that a point of a long period may not cover: so a torus passes by
_BLOCKS = 8  # parts of a record whose sizes are compared
_ROUNDS = 4  # least visits to a piece within a part, for a size
_SMALLEST = 1e-12  # sizes below this share of the magnitude are rounding


@dataclass(frozen=True)
class Shrinkage:
    """How fast the size of a motion goes down, per mesh period: rate, negative where it grows, and standard error."""

    rate: float
    error: float


def recurrence(section: Array, period: int) -> float:
    """Return the largest distance between section points `period` apart, in the section's unit.

    `section` has shape (n, 2), n > period. Zero for an exactly periodic motion.
    """
    if not 0 < period < len(section):
        raise ValueError(
            f"Period {period} was asked of {len(section)} section points; expected 1 to {len(section) - 1}."
        )
    return float(np.abs(section[period:] - section[:-period]).max())


def find_period(section: Array, *, tolerance: float, longest: int = LONGEST_PERIOD) -> int | None:
    """Return the smallest period whose recurrence is within `tolerance`, or None.

    `section` has shape (n, 2) in units of b_c. A period needs three rounds of it in the record to be believed, and no
    point of it may move by more than twice the tolerance from the first round to the last: small steps of a slow
    transient or of a torus near resonance are no period. Above LONGEST_PERIOD its points must also lie well apart and
    not move evenly from round to round, or a torus near a high resonance would pass. Limits: a period-doubled motion
    whose split is below `tolerance` counts as undoubled, and a torus smaller than it as periodic.
    """
    n = len(section)
    last = np.abs(section[n - 1 : n] - section[: max(n - 1, 0)][::-1])  # row p − 1: from the point p periods before
    for period in (1 + np.flatnonzero((last[: min(longest, n // 3)] <= tolerance).all(axis=1))).tolist():
        step = recurrence(section, period)
        if step > tolerance:
            continue
        rounds = by_piece(section, period)
        # Stretched from what lies between first and last visit to the whole record, or a drift would suit some period.
        moves = float(np.ptp(rounds, axis=0).max()) * (n - 1) / (len(rounds) - 1) / period
        if moves <= _DRIFT * tolerance and (period <= LONGEST_PERIOD or _stands(rounds, moves, step)):
            return int(period)
    return None


def _stands(rounds: Array, moves: float, step: float) -> bool:
    """Return whether the points of a long period stand still and apart, from what they move in all and in a round."""
    if np.ptp(rounds, axis=0).max() > _EVEN * (len(rounds) - 1) * step:
        return False
    points = rounds.mean(axis=0)
    distances = np.abs(points[:, None] - points).max(axis=2)
    np.fill_diagonal(distances, np.inf)
    # The median, because a projected orbit may cross itself at some of its points.
    return bool(np.median(distances.min(axis=1)) >= _APART * moves)


def shrinkage(section: Array, *, pieces: int = 1) -> Shrinkage:
    """Return the rate at which the size of a motion shrinks, from a straight line through the logarithms of sizes.

    `section` (n, 2) visits `pieces` pieces in turn; the size of a part of it is the root mean square of distances from
    the middle of each piece, over up to eight equal parts. A transient shrinks geometrically towards the periodic
    motion that it ends in, by exp(−rate) a period; a torus keeps its size. The error is that of the fitted line: zero
    for a pure spiral, large where size comes and goes. A record with less than three parts of four visits to each
    piece has rate 0 with an infinite error. Limits: a motion that drifts as a whole, or approaches a torus, has
    another law; so has one at the very edge of its stability, which shrinks as a power of time.
    """
    blocks = min(_BLOCKS, len(section) // (_ROUNDS * pieces))
    if blocks < 3:
        return Shrinkage(0.0, float("inf"))
    rounds = len(section) // (blocks * pieces)
    parts = section[len(section) - blocks * rounds * pieces :].reshape(blocks, rounds, pieces, 2)
    sizes = np.sqrt(parts.var(axis=1).sum(axis=2).mean(axis=1))
    rounding = max(_SMALLEST * float(np.abs(section).max()), float(np.finfo(float).tiny))
    logs = np.log(np.maximum(sizes, rounding))
    time = (np.arange(blocks) - (blocks - 1) / 2) * rounds * pieces
    slope = float(time @ logs / (time @ time))
    residual = logs - logs.mean() - slope * time
    return Shrinkage(-slope, float(np.sqrt(residual @ residual / (blocks - 2) / (time @ time))))
