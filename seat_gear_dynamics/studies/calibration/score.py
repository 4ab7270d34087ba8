"""How well a candidate meets each claim, from 0 to 1, and the cost that the search makes small."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.section import LONGEST_PERIOD
from seat_gear_dynamics.studies.calibration.operating_points import OperatingPoints

Array = NDArray[np.float64]

WEIGHTS: Mapping[str, float] = {
    "C1": 3.0,
    "C2": 1.5,
    "C3": 8.0,
    "C4": 1.0,
    "C4 calm": 0.7,
    "C5": 20.0,
    "C7": 1.5,
    "C8": 0.8,
    "C9 low": 6.0,
    "C9 about": 1.5,
    "C9 high": 2.0,
    "C9 odd": 0.3,
    "C10": 1.2,
}
"""By how much of the paper a claim is: bands and the calm between them first, single points last."""
_TOLERANCE = 2e-3
"""Recurrence in units of b_c; looser than a verdict's, because the run-in is shorter."""


@dataclass(frozen=True, eq=False)
class Judged:
    """What is seen at each point, soft where a hard threshold would leave the search without a slope; shapes (n,)."""

    period: NDArray[np.int64]
    """0 where no period was found, −1 where the solution diverged."""
    chaotic: Array
    """0 to 1."""
    calm: Array
    """0 to 1."""
    section: Array
    """(n, periods, 2)"""


def judge(section: Array, growth: Array, diverged: NDArray[np.bool_], frequency: Array) -> Judged:
    """Judge the motions of n points from section (n, periods, 2) and tangent growth per period (n, periods)."""
    n = len(section)
    period = np.where(diverged, -1, 0)
    tail = min(40, section.shape[1] // 2)
    for candidate in range(1, min(LONGEST_PERIOD, section.shape[1] - tail) + 1):
        distance = np.abs(section[:, candidate:] - section[:, :-candidate])[:, -tail:].max(axis=(1, 2))
        period[(distance < _TOLERANCE) & (period == 0)] = candidate
    exponent = np.where(diverged, 0.0, growth.mean(axis=1) * np.abs(frequency) / (2 * np.pi))
    chaotic = np.clip((exponent - 0.006) / 0.014, 0, 1) * (period == 0)
    calm = 1 - np.clip((exponent - 0.002) / 0.010, 0, 1)
    calm[period > 0], calm[period < 0] = 1.0, 0.0
    assert chaotic.shape == (n,)
    return Judged(period, chaotic, calm, section)


def scores(points: OperatingPoints, seen: Judged) -> dict[str, float]:
    """Return how well each part of the claims is met, 0 to 1, by the keys of WEIGHTS."""
    chaotic, calm, period = seen.chaotic, seen.calm, seen.period
    own = points.of
    window = np.sort(np.maximum(chaotic, 0.2 * (period == 0))[own("C2")])[::-1]
    about, high = own("C9 about"), own("C9 high")
    return {
        "C1": _mean(period[own("C1")] == 1),
        "C2": float(0.6 * window[0] + 0.4 * window[:3].mean()),
        "C3": _mean(chaotic[own("C3")]),
        "C4": _three_curves(seen, int(own("C4")[0])),
        "C4 calm": _mean(calm[own("C4")]),
        "C5": _mean(calm[own("C5")]),
        "C7": _growing_stability(points, chaotic),
        "C8": float((period[own("C8")] == 4).any()),
        "C9 low": _mean(chaotic[own("C9 low")]),
        "C9 about": max(
            _mean(np.concatenate([chaotic[about[:k]], period[about[k:]] > 0])) for k in range(len(about) + 1)
        ),
        "C9 high": _mean(period[high] > 0),
        "C9 odd": _mean((period[high] == 1) | (period[high] == 3)),
        "C10": _onset_over_backlash(points, seen),
    }


def cost(found: Mapping[str, float], diverged: int, excess: float) -> float:
    """Return the weighted shortfall; diverged points and coordinates out of bounds (squared excess) cost extra."""
    short = sum(weight * (1 - found[name]) for name, weight in WEIGHTS.items())
    return short + excess + (1 + 0.1 * diverged if diverged else 0.0)


def _mean(values: NDArray[np.float64] | NDArray[np.bool_]) -> float:
    return float(np.mean(values))


def _three_curves(seen: Judged, index: int) -> float:
    """Half for a section in three pieces, one for three that are curves."""
    section, period = seen.section[index], seen.period[index]
    third = np.abs(section[3:] - section[:-3]).mean()
    step = np.abs(section[1:] - section[:-1]).mean() + 1e-12
    apart = bool(period in (3, 6, 12) or (period == 0 and third < 0.35 * step))
    curves = bool(apart and period == 0 and seen.calm[index] > 0.5)
    return 0.5 * apart + 0.5 * curves


def _growing_stability(points: OperatingPoints, chaotic: Array) -> float:
    base = np.concatenate([chaotic[points.of(claim)] for claim in ("C5", "C2", "C3")])
    levels = [_mean(base)] + [_mean(chaotic[points.of(f"C7 {xi}")]) for xi in (0.09, 0.11, 0.13)]
    steps = [np.clip((a - b) / 0.04, 0, 1) if a > 0.02 else 1.0 for a, b in pairwise(levels)]
    return float(np.mean(steps))


def _onset_over_backlash(points: OperatingPoints, seen: Judged) -> float:
    """Best over the readings of b_c: calm from a third to five sixths of a backlash that is chaotic."""
    own = points.of("C10")
    backlash, best = points.backlash[own], 0.0
    for k in range(7, len(own)):
        inside = (backlash >= backlash[k] / 3 * 0.98) & (backlash <= backlash[k] * 5 / 6 * 1.02)
        calm = _mean(seen.calm[own][inside])
        best = max(best, 0.5 * calm * calm + 0.5 * float(seen.chaotic[own][k]))
    return best
