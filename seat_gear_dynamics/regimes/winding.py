"""Weighted Birkhoff averages: how fast averages of a motion converge, and how far it turns each period."""

from math import pi

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_WINDOWS = 3  # early, middle and late half of a record
_BEND = 1.3  # turns a coordinate of unit deviation into an even and an odd observable; any number near 1 does
_CONSTANT = 1e-12  # a deviation below this share of the magnitude is rounding


def weighted_mean(values: Array) -> Array:
    """Return the weighted Birkhoff average of `values` (n, ...) over their first axis, n >= 1.

    The weight exp(−1/(t(1 − t))) dies out with all its derivatives at both ends. On a smooth torus with a sufficiently
    irrational winding number the average then converges faster than any power of 1/n (Das, Saiki, Sander & Yorke 2017,
    Nonlinearity 30, 4111-4140), where the plain mean converges as 1/n; for chaos both converge as 1/√n.
    """
    t = (np.arange(len(values)) + 0.5) / len(values)
    weight = np.exp(-1 / (t * (1 - t)))
    return np.asarray(np.tensordot(weight / weight.sum(), values, axes=1))


def windowed_means(values: Array) -> Array:
    """Return the weighted averages of `values` (n, ...), n >= 2, over its early, middle and late half: (3, ...)."""
    half = len(values) // 2
    starts = np.linspace(0, len(values) - half, _WINDOWS).round().astype(int)
    return np.stack([weighted_mean(values[start : start + half]) for start in starts])


def by_piece(section: Array, pieces: int) -> Array:
    """Return a section (n, 2) as rounds of `pieces` points, (n // pieces, pieces, 2), without the oldest n % pieces.

    Raises ValueError where there is no whole round.
    """
    if not 0 < pieces <= len(section):
        raise ValueError(f"{pieces} pieces were asked of {len(section)} section points; expected 1 to that many.")
    return section[len(section) % pieces :].reshape(-1, pieces, section.shape[1])


def wandering(section: Array, *, pieces: int = 1) -> float:
    """Return how far averages over parts of the record differ, in standard deviations of the motion.

    `section` (n, 2), n >= 4·pieces, visits `pieces` pieces in turn, each of which is averaged by itself: its
    coordinates, and a sine and a cosine of them, over the early, middle and late half of the record. Tiny on a torus
    that has been gone round a good number of times; about 1/√n for chaos and noise; and as large as what changed for a
    transient (Sander & Meiss 2020, Physica D 411, 132569, tell chaos from tori in this way). Zero for a constant.
    Measured at 400 points: below 0.001 for tori of one to three curves, above 0.01 for chaos but for one record in ten.
    Limits: a torus gone round fewer than about ten times, or near a low resonance, wanders as a transient does.
    """
    rounds = by_piece(section, pieces)
    if len(rounds) < 4:
        raise ValueError(f"{len(section)} points of {pieces} pieces were given; expected at least {4 * pieces} points.")
    deviation = rounds.std(axis=0)
    moving = deviation > _CONSTANT * np.abs(rounds).max(axis=0)
    if not moving.any():
        return 0.0
    scaled = ((rounds - rounds.mean(axis=0)) / np.where(moving, deviation, 1))[:, moving]
    observed = np.stack([scaled, np.sin(_BEND * scaled), np.cos(_BEND * scaled)])
    return float(np.sqrt(windowed_means(np.moveaxis(observed, 1, 0)).var(axis=0, ddof=1).mean()))


def winding_number(section: Array, *, pieces: int = 1) -> float:
    """Return the share of a turn that a torus makes around a piece from one visit to the next, 0 to 0.5.

    `section` (n, 2), n >= 3·pieces, visits `pieces` closed curves in turn. The angle about the middle of each curve is
    averaged with the weight of `weighted_mean`. What a section tells is the number modulo 1 and without its sign, so
    0.618 is given as 0.382. Limits: true where each curve goes once around its middle; a curve that does not (a
    crescent, a figure of eight) gives some other number, and a motion that is no torus a number without meaning.
    """
    rounds = by_piece(section, pieces)
    if len(rounds) < 3:
        raise ValueError(f"{len(section)} points of {pieces} pieces were given; expected at least {3 * pieces} points.")
    x, y = np.moveaxis(rounds - weighted_mean(rounds), 2, 0)
    turns = np.diff(np.arctan2(y, x), axis=0) / (2 * pi) % 1.0
    # Turns of one curve fill a stretch of the circle: it is cut where none of them lies, so that none wraps.
    ordered = np.sort(turns, axis=0)
    holes = np.diff(ordered, axis=0, append=ordered[:1] + 1)
    cut = np.take_along_axis(ordered, holes.argmax(axis=0)[None], axis=0)
    mean = weighted_mean(np.where(turns > cut, turns - 1, turns)) % 1.0
    return float(np.minimum(mean, 1 - mean).mean())
