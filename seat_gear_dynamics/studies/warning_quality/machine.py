"""A machine that is not the model: drawn within tolerances, with a chaos of its own that the model has to foresee."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.points import Diverged, Point, regime_of, respond
from seat_gear_dynamics.regimes.tolerance import Tolerances, draw
from seat_gear_dynamics.studies.warning_quality.run import Record
from seat_gear_dynamics.studies.warning_quality.score import SETTLED, THINNED
from seat_gear_dynamics.studies.warning_quality.truth import Drive, is_steady, rounded

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_STREAM = 0x6D616368  # keeps the machine's draw apart from the bench's noise of the same seed
_SLOWEST = 10 * RPM  # rad/s; slower than this no machine is asked
_SETTLED_MOTION = 1.0  # s of a dwell after which the model's record holds nothing of the way to it


def drawn_machine(train: GearTrain, seed: int) -> GearTrain:
    """Return a machine within the default tolerances of `train`, the same for the same seed."""
    return draw(train, Tolerances(), np.random.default_rng([seed, _STREAM]))


def machine_motions(
    machine: GearTrain, points: Iterable[Drive], *, transient: int = 1000, periods: int = 300
) -> dict[Drive, bool]:
    """Return whether `machine` is chaotic at each steady point (rad/s, N·m), from rest; undecided ones are left out."""
    asked = [(v, w) for v, w in points if abs(v) > _SLOWEST]
    run = (Point(machine.frequency(v), w, transient=transient, periods=periods) for v, w in asked)
    found: dict[Drive, bool] = {}
    for point, answer in zip(asked, respond(machine, run, workers=1), strict=True):
        regime = regime_of(answer)
        if isinstance(answer, Diverged) or regime.name != "undecided":
            found[point] = isinstance(answer, Diverged) or regime.name == "chaotic"
    return found


def machine_samples(record: Record, chaos: dict[Drive, bool]) -> tuple[Array, Flags]:
    """Return (scores (m, 4), whether the machine is chaotic) of the steady samples of a run."""
    scenario = record.scenario
    step = scenario.sample_time
    still = is_steady(record.speed, record.load, step)
    long = still & np.concatenate([np.zeros(round(_SETTLED_MOTION / step), dtype=bool), still])[: len(still)]
    places = [rounded(v, w) for v, w in zip(record.speed.tolist(), record.load.tolist(), strict=True)]
    told = np.array([place in chaos for place in places])
    kept = np.flatnonzero(long & told & (record.time >= SETTLED) & np.isfinite(record.scores[:, 0]))[::THINNED]
    return record.scores[kept], np.array([chaos[places[k]] for k in kept.tolist()], dtype=bool)
