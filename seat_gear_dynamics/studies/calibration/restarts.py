"""Many runs of the search, each from a set among the best so far."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.studies.calibration.freedom import FREEDOMS
from seat_gear_dynamics.studies.calibration.search import Candidate, evaluate, search
from seat_gear_dynamics.studies.calibration.starts import STARTS

Array = NDArray[np.float64]

HARMONICS = (3, 4, 5, 6, 8)
"""Numbers of stiffness harmonics tried."""
_POOL = 8  # sets that a run may start from
_APART = 0.15  # of coordinates, from which two sets count as different
_KEEP_HARMONICS = 0.8  # share of runs that keep their start's number of harmonics


def restarts(
    base: GearTrain,
    *,
    runs: int,
    evaluations: int,
    seed: int,
    starts: Sequence[tuple[int, Sequence[float]]] = tuple(STARTS.values()),
    report: Callable[[int, Candidate], None] | None = None,
) -> list[Candidate]:
    """Return the best candidate of each of `runs` runs of `evaluations` each, and the starts, best first.

    Each run draws its start from the best sets so far, disturbs it, and draws the size of its first steps; `seed` makes
    the whole repeatable. `report` is called with the number of the run and its best. Raises ValueError where there is
    no start, and as `search`.
    """
    if not starts:
        raise ValueError("There is no set to start from; give at least one.")
    found = [evaluate(base, _coordinates(values), harmonics) for harmonics, values in starts]
    for run in range(runs):
        random = np.random.default_rng([seed, run])
        pool = distinct(found)
        start = pool[min(int(random.exponential(1.5)), len(pool) - 1)]
        spread = np.array([f.spread for f in FREEDOMS]) * random.choice([0.0, 0.15, 0.4])
        disturbed = _coordinates(start.values) + spread * random.standard_normal(len(FREEDOMS))
        harmonics = start.harmonics if random.random() < _KEEP_HARMONICS else int(random.choice(HARMONICS))
        best = search(
            evaluate(base, disturbed, start.harmonics).train(base),
            harmonics=harmonics,
            evaluations=evaluations,
            seed=seed * 100_000 + run + 1,
            step=float(random.choice([0.15, 0.3, 0.6])),
        )
        found.append(best)
        if report is not None:
            report(run, best)
    return sorted(found, key=lambda c: c.cost)


def distinct(candidates: Sequence[Candidate], most: int = _POOL) -> list[Candidate]:
    """Return the best `most` candidates that differ from each other in at least one coordinate, best first."""
    kept: list[Candidate] = []
    for candidate in sorted(candidates, key=lambda c: c.cost):
        own = _coordinates(candidate.values)
        if all(np.abs(own - _coordinates(other.values)).max() > _APART for other in kept):
            kept.append(candidate)
        if len(kept) == most:
            break
    return kept


def _coordinates(values: Sequence[float]) -> Array:
    return np.array([f.code(max(v, f.low) if f.logarithmic else v) for f, v in zip(FREEDOMS, values, strict=True)])
