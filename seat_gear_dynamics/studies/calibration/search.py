"""The search: covariance matrix adaptation from named starts, repeatable to the last candidate."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes import respond_lanes
from seat_gear_dynamics.studies.calibration.freedom import FREEDOMS, apply, read
from seat_gear_dynamics.studies.calibration.operating_points import operating_points
from seat_gear_dynamics.studies.calibration.score import cost, judge, scores

Array = NDArray[np.float64]

TRANSIENT, PERIODS = 280, 128
"""Mesh periods run in and sampled for each point; verdicts are given on 600 and 400."""
STEPS = 136
"""Steps per mesh period: half of the production march's, a relative error of the state of 1e-5 away from impacts."""
POPULATION = 16


@dataclass(frozen=True)
class Candidate:
    """One set of the open parameters and what it is worth."""

    values: tuple[float, ...]
    """In the order and units of FREEDOMS."""
    harmonics: int
    """Fourier harmonics of the mesh stiffness that the model keeps."""
    cost: float
    scores: Mapping[str, float]

    def train(self, base: GearTrain) -> GearTrain:
        """Return `base` with this set."""
        return apply(_with_harmonics(base, self.harmonics), self.values)


def evaluate(
    base: GearTrain, coordinates: Sequence[float] | Array, harmonics: int, *, threads: int | None = None
) -> Candidate:
    """Return what the set at the search's `coordinates` (those of FREEDOMS, each in its own code) is worth.

    The result does not depend on `threads`.
    """
    values = tuple(f.value(c) for f, c in zip(FREEDOMS, coordinates, strict=True))
    points = operating_points()
    found = respond_lanes(
        apply(_with_harmonics(base, harmonics), values),
        points.frequency,
        points.load,
        damping_ratio=points.damping_ratio,
        backlash=points.backlash,
        transient=TRANSIENT,
        periods=PERIODS,
        target_steps=STEPS,
        statistics=False,
        threads=threads,
    )
    met = scores(points, judge(found.section, found.growth, found.diverged, points.frequency))
    excess = sum(f.excess(c) ** 2 for f, c in zip(FREEDOMS, coordinates, strict=True))
    return Candidate(values, harmonics, cost(met, int(found.diverged.sum()), excess), met)


def search(
    base: GearTrain,
    *,
    harmonics: int,
    evaluations: int,
    seed: int,
    step: float = 1.0,
    report: Callable[[int, Candidate], None] | None = None,
) -> Candidate:
    """Return the best candidate of one run of CMA-ES (Hansen 2016, arXiv:1604.00772) that starts at `base`'s own set.

    `step` scales the first steps, whose spread each Freedom gives; `seed` makes the run repeatable. `report` is
    called with the number of evaluations so far and each candidate that is better than all before. Raises ValueError
    where `evaluations` is below a population. Limits: a local search; its result depends on start and seed, and the
    claims leave whole families of sets, so no set is the machine's. Needs the package `cma`.
    """
    if evaluations < POPULATION:
        raise ValueError(f"Asked for {evaluations} evaluations, expected at least {POPULATION}, a population.")
    import cma  # an extra: only this search needs it

    start = [f.code(max(v, f.low) if f.logarithmic else v) for f, v in zip(FREEDOMS, read(base), strict=True)]
    options = {"popsize": POPULATION, "seed": seed, "verbose": -9, "CMA_stds": [f.spread for f in FREEDOMS]}
    strategy = cma.CMAEvolutionStrategy(start, step, options)
    best = evaluate(base, start, harmonics)  # the result is never worse than the start
    done = 1
    while done < evaluations and not strategy.stop():
        asked = strategy.ask()
        candidates = [evaluate(base, coordinates, harmonics) for coordinates in asked]
        strategy.tell(asked, [c.cost for c in candidates])
        done += len(candidates)
        leader = min(candidates, key=lambda c: c.cost)
        if leader.cost < best.cost:
            best = leader
            if report is not None:
                report(done, best)
    return best


def _with_harmonics(train: GearTrain, harmonics: int) -> GearTrain:
    first, second = (replace(mesh, stiffness_harmonics=harmonics) for mesh in train.meshes)
    return replace(train, meshes=(first, second))
