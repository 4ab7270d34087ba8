"""Excitation tabulated at the half steps of the march: stiffness, error and its slope for both meshes on every grid.

The step is locked to the mesh period, so that an excitation is the same table each period. Both meshes stay on their
grids because a P12 period is divided into a multiple of z3/gcd(z2, z3) steps: 40 periods of P12 are 17 of P34.
Slow drives need more steps a period to keep the step short in time: level l divides the period 2^l times finer.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import gcd, lcm

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain, PeriodicSeries

Array = NDArray[np.float64]

LEVELS = 7
"""Grids per mesh period: base, 2·base, … 64·base steps; below that frequency the mesh phase creeps."""
TARGET_STEPS = 256
"""Steps per P12 period aimed at on the coarsest grid."""


@dataclass(frozen=True)
class Tables:
    """Half-step tables of one train, (stiffness/k̄_12, e/b_c, de/dp/b_c) in the last axis."""

    first: Array
    """P12, all levels one after the other, shape (2·base·(2^LEVELS − 1), 3)."""
    second: Array
    """P34 likewise, shape (2·base2·(2^LEVELS − 1), 3)."""
    base: int
    """Steps per P12 period on level 0."""
    base_second: int
    """Steps per P34 period on level 0, when both advance together."""
    hunting: int
    """P12 periods after which all four gears are back where they were: the same teeth touch, at the same runout."""

    @property
    def cycle(self) -> int:
        """Finest steps in a hunting cycle."""
        return self.hunting * (self.base << (LEVELS - 1))


def tables(train: GearTrain, *, target_steps: int = TARGET_STEPS) -> Tables:
    """Return the tables of `train` with at least `target_steps` steps per P12 period on the coarsest grid."""
    s1, s2, s3, s4 = train.gears
    p, q = s3.teeth // gcd(s2.teeth, s3.teeth), s2.teeth // gcd(s2.teeth, s3.teeth)
    base = p * -(-target_steps // p)
    base_second = base * q // p
    mean, length = train.meshes[0].mean_model_stiffness, train.model.displacement_scale
    first, second = (
        _mesh_table(mesh.stiffness, mesh.transmission_error, steps, mean, length)
        for mesh, steps in zip(train.meshes, (base, base_second), strict=True)
    )
    turn_of_s4 = s2.teeth * s4.teeth // gcd(s2.teeth * s4.teeth, s3.teeth)  # in whole P12 periods
    hunting = lcm(s1.teeth, s2.teeth, turn_of_s4)
    return Tables(first, second, base, base_second, hunting)


@lru_cache(maxsize=32)
def _mesh_table(
    stiffness: PeriodicSeries, error: PeriodicSeries, steps: int, mean_stiffness: float, length_unit: float
) -> Array:
    """Return one mesh's table, all levels one after the other; kept, as sweeps ask for the same one at every point."""
    phase = np.concatenate([np.arange(2 * steps * 2**level) / (2 * steps * 2**level) for level in range(LEVELS)])
    columns = (
        stiffness.value(phase) / mean_stiffness,
        error.value(phase) / length_unit,
        error.derivative(phase) / length_unit,
    )
    table = np.ascontiguousarray(np.column_stack(columns))
    table.setflags(write=False)
    return table
