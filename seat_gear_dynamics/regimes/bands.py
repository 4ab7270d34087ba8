"""Forbidden bands from a probability of chaos along the speed, with the uncertainty of their edges."""

from dataclasses import dataclass
from itertools import pairwise
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from seat_gear_dynamics.gears import ForbiddenBand

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MapBand(ForbiddenBand):
    """A forbidden band found on a grid, with how far its edges may be off."""

    low_error: float
    """Uncertainty of `low` either way, rad/s."""
    high_error: float
    """Uncertainty of `high` either way, rad/s."""
    open_low: bool = False
    """The band begins at the map's lowest speed: where it really begins is not known."""
    open_high: bool = False
    """The band ends at the map's highest speed: where it really ends is not known."""


@dataclass(frozen=True)
class _Stretch:
    """A stretch of speeds, rad/s, and the nodes first..last of the grid that lie in it."""

    low: float
    high: float
    first: int
    last: int


def wilson_interval(share: ArrayLike, samples: int, *, confidence: float = 0.95) -> tuple[Array, Array]:
    """Return the interval (low, high) of a probability of which `samples` independent trials showed `share`.

    Wilson (1927), without continuity correction; any shape. Unlike the normal interval it stays in [0, 1] and has a
    width at shares of 0 and 1. Raises ValueError for no samples, shares outside [0, 1] or an impossible confidence.
    """
    p = np.asarray(share, dtype=float)
    if samples < 1 or not 0 < confidence < 1 or not ((p >= 0) & (p <= 1)).all():
        raise ValueError(
            f"An interval was asked of shares {share!r} in {samples} samples at confidence {confidence!r}; "
            f"expected shares from 0 to 1, at least one sample and a confidence between 0 and 1."
        )
    z = float(ndtri(0.5 + confidence / 2))
    scale = 1 + z * z / samples
    centre = (p + z * z / (2 * samples)) / scale
    half = z / scale * np.sqrt(p * (1 - p) / samples + z * z / (4 * samples * samples))
    # At shares of 0 and 1 the bounds are 0 and 1 but for rounding, which must not carry them beyond.
    low, high = np.where(p == 0, 0.0, centre - half), np.where(p == 1, 1.0, centre + half)
    return np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)


def binomial_error(share: float, samples: int) -> float:
    """Return the standard error of a share that `samples` independent trials showed; raises ValueError for none."""
    if samples < 1:
        raise ValueError(f"An error was asked of {samples} samples; expected at least 1.")
    return sqrt(share * (1 - share) / samples)


def forbidden_bands(
    speeds: Array, probability: Array, lower: Array, upper: Array, *, threshold: float, load: float
) -> tuple[MapBand, ...]:
    """Return the bands of speed in which `probability` of chaos is at least `threshold`.

    `speeds` (n,), rad/s, n >= 2, increasing; `probability` and its bounds `lower` and `upper`, (n,), NaN nowhere;
    `load` is noted in the bands. Edges lie where the probability, linear between the grid's speeds, crosses the
    threshold: halfway between a calm and a chaotic neighbour. Bands no more than one grid step apart are one: the calm
    node between them is not sure to have any width. An edge is uncertain by half a grid step, or, if that is more, by
    the way to where the bounds cross the threshold (by half the band where the lower bound stays below it).
    """
    # Bounds that rounding has put on the wrong side must not lose a band.
    outer = _stretches(speeds, np.maximum(upper, probability), threshold)
    inner = _stretches(speeds, np.minimum(lower, probability), threshold)
    return tuple(_with_errors(speeds, band, outer, inner, load) for band in _stretches(speeds, probability, threshold))


def _with_errors(speeds: Array, band: _Stretch, outer: list[_Stretch], inner: list[_Stretch], load: float) -> MapBand:
    around, within = _meeting(band, outer), _meeting(band, inner)
    half = (band.high - band.low) / 2
    low_ways = (
        _half_step(speeds, band.first),
        band.low - min(each.low for each in around),
        min(each.low for each in within) - band.low if within else half,
    )
    high_ways = (
        _half_step(speeds, band.last + 1),
        max(each.high for each in around) - band.high,
        band.high - max(each.high for each in within) if within else half,
    )
    ends = {"open_low": band.first == 0, "open_high": band.last == len(speeds) - 1}
    return MapBand(band.low, band.high, load, max(low_ways), max(high_ways), **ends)


def _meeting(band: _Stretch, others: list[_Stretch]) -> list[_Stretch]:
    """Return those of `others` that have a node in common with `band`."""
    return [each for each in others if each.first <= band.last and band.first <= each.last]


def _half_step(speeds: Array, node: int) -> float:
    """Return half the step that ends at `node`, or the nearest one at the grid's ends."""
    right = min(max(node, 1), len(speeds) - 1)
    return float(speeds[right] - speeds[right - 1]) / 2


def _stretches(speeds: Array, values: Array, threshold: float) -> list[_Stretch]:
    """Return where `values`, linear between speeds, are at least `threshold`, stretches one step apart merged."""
    found: list[_Stretch] = []
    for first, last in _runs(values >= threshold):
        low = _crossing(speeds, values, threshold, first - 1) if first else float(speeds[0])
        high = _crossing(speeds, values, threshold, last) if last < len(speeds) - 1 else float(speeds[-1])
        if found and low - found[-1].high <= _widest_step(speeds, found[-1].last, first) * (1 + 1e-9):
            low, first = found[-1].low, found.pop().first
        found.append(_Stretch(low, high, first, last))
    return found


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return (first, last) of each run of true flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(first), int(after) - 1) for first, after in zip(edges[::2], edges[1::2], strict=True)]


def _crossing(speeds: Array, values: Array, threshold: float, left: int) -> float:
    """Return the speed between nodes `left` and `left` + 1 at which `values` cross the threshold."""
    share = (threshold - values[left]) / (values[left + 1] - values[left])
    return float(speeds[left] + share * (speeds[left + 1] - speeds[left]))


def _widest_step(speeds: Array, first: int, last: int) -> float:
    return max(float(right - left) for left, right in pairwise(speeds[first : last + 1]))
