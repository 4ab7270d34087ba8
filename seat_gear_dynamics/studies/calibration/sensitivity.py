"""How far each open parameter may drift, alone, before a claim that is met is lost."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.studies.calibration.freedom import FREEDOMS, read
from seat_gear_dynamics.studies.calibration.search import evaluate

MET: Mapping[str, float] = {
    "C1": 1.0,
    "C2": 0.55,
    "C3": 0.95,
    "C5": 0.92,
    "C7": 0.95,
    "C8": 1.0,
    "C9 low": 0.90,
    "C9 about": 0.82,
    "C9 high": 1.0,
    "C10": 0.95,
}
"""Score from which a claim counts as met on the points of the search; C5 allows for its two points at the edges."""
DRIFTS = (0.005, 0.01, 0.02, 0.05, 0.10, 0.20, 0.50)
"""Relative changes tried, one way and then the other; a phase drifts by as many radians."""


@dataclass(frozen=True)
class Drift:
    """How far one parameter may go."""

    name: str
    value: float
    """SI"""
    down: float
    """Largest tried drift downwards at which all met claims still are, 0 where even the least loses one."""
    up: float
    lost_down: tuple[str, ...]
    """Claims lost at the next drift downwards; empty where none was lost up to the last."""
    lost_up: tuple[str, ...]


class Drifts(list[Drift], Plottable, figure="drifts:plot_drifts", table="studies:drifts_table"):
    """One Drift for each Freedom, in their order."""


def sensitivity(
    train: GearTrain,
    *,
    drifts: Sequence[float] = DRIFTS,
    progress: Callable[[int, int], None] | None = None,
) -> Drifts:
    """Return for each Freedom how far `train` may drift in it before a claim that it meets is lost.

    One parameter at a time, from rest at static deflection, on the points of the search; `progress` is called with
    (parameters done, parameters in all). Limits: interactions of parameters are not looked at.
    """
    values, harmonics = read(train), train.meshes[0].stiffness_harmonics

    def met(index: int, drift: float) -> set[str]:
        freedom = FREEDOMS[index]
        changed = values[index] * (1 + drift) if freedom.logarithmic else values[index] + drift
        coordinates = [f.code(max(v, f.low) if f.logarithmic else v) for f, v in zip(FREEDOMS, values, strict=True)]
        coordinates[index] = freedom.code(max(changed, freedom.low) if freedom.logarithmic else changed)
        found = evaluate(train, coordinates, harmonics).scores
        return {claim for claim, least in MET.items() if found[claim] >= least - 1e-9}

    held = met(0, 0.0)

    def until_lost(index: int, sign: int) -> tuple[float, tuple[str, ...]]:
        reached = 0.0
        for drift in drifts:
            lost = held - met(index, sign * drift)
            if lost:
                return reached, tuple(sorted(lost))
            reached = drift
        return reached, ()

    found = Drifts()
    for index, freedom in enumerate(FREEDOMS):
        (down, lost_down), (up, lost_up) = until_lost(index, -1), until_lost(index, 1)
        found.append(Drift(freedom.name, values[index], down, up, lost_down, lost_up))
        if progress is not None:
            progress(index + 1, len(FREEDOMS))
    return found
