"""The excitation that the lanes of a block share: tables at half steps of one grid, in the direction of motion.

As in `motion.tables` the step is locked to the mesh period. Counted in steps an excitation does not depend on the
frequency, so lanes of any frequency share it as long as they divide the period alike and turn the same way.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import gcd, pi

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain, PeriodicSeries
from seat_gear_dynamics.motion.coefficients import coefficients
from seat_gear_dynamics.motion.march import LONGEST_STEP
from seat_gear_dynamics.motion.tables import LEVELS, TARGET_STEPS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Excitation:
    """What excites a train, as values that compare equal where lanes may share a table."""

    stiffness: tuple[PeriodicSeries, ...]
    """κ_j over the phase of each mesh, over the mean of P12."""
    error: tuple[PeriodicSeries, ...]
    """e_j over b_c."""
    eccentricity: tuple[float, ...]
    """Of each gear, over b_c; empty where no gear has any."""
    eccentricity_phase: tuple[float, ...]
    """At mesh phase 0, rad."""
    shaft_turns: tuple[float, ...]
    """Revolutions of each gear in a mesh period of P12."""
    base: tuple[int, ...]
    """Steps per period of each mesh on level 0."""


@dataclass(frozen=True)
class Grid:
    """An excitation on one level in one direction, as the kernel wants it."""

    tables: tuple[Array, Array]
    """κ, e and the slope of e per half step, for the half steps of each mesh period, shape (2·n_j, 3) or (0, 3)."""
    base: int
    """Steps in a part."""
    parts: int
    """Parts in a mesh period of P12; 2^level."""
    runout: Array
    """Amplitude over b_c, phase in rad, angle per part in rad and per half step in rad of each gear, shape (g, 4)."""
    turning: Array
    """cos and sin of the angle that each gear turns by in the half steps of a part, shape (2·base + 1, 2·g)."""

    @property
    def steps(self) -> int:
        """Steps in a mesh period of P12."""
        return self.base * self.parts


def excitation(train: GearTrain, *, meshes: int, target_steps: int) -> Excitation:
    """Return the excitation of the first `meshes` meshes of `train`; `target_steps` as in `motion.tables.tables`."""
    c, mean = coefficients(train), train.meshes[0].mean_model_stiffness
    used = train.meshes[:meshes]
    gears = 2 * meshes if c.eccentricity[: 2 * meshes].any() else 0
    return Excitation(
        tuple(m.stiffness.scaled(1 / mean) for m in used),
        tuple(m.transmission_error.scaled(1 / c.length_unit) for m in used),
        tuple(c.eccentricity[:gears].tolist()),
        tuple(c.eccentricity_phase[:gears].tolist()),
        tuple(c.shaft_turns[:gears].tolist()),
        base_steps(train, target_steps)[:meshes],
    )


def base_steps(train: GearTrain, target_steps: int) -> tuple[int, int]:
    """Return the steps per period of P12 and of P34 on level 0, when both advance together."""
    _, s2, s3, _ = train.gears
    common = gcd(s2.teeth, s3.teeth)
    p, q = s3.teeth // common, s2.teeth // common
    base = p * -(-target_steps // p)
    return base, base * q // p


def in_reach(
    train: GearTrain, frequency: Array, *, target_steps: int = TARGET_STEPS, longest_step: float = LONGEST_STEP
) -> NDArray[np.bool_]:
    """Return at which of the frequencies (n,) lanes can march `train`: those that a grid has short enough steps for."""
    return np.asarray(level_of(frequency, base_steps(train, target_steps)[0], longest_step) < LEVELS)


def level_of(frequency: Array, base: int, longest_step: float) -> NDArray[np.int64]:
    """Return the coarsest level, (n,), whose step at each frequency (n,) is short enough; LEVELS where none is."""
    scale = longest_step * np.abs(frequency) * base
    levels = np.full(frequency.shape, LEVELS, dtype=np.int64)
    for level in reversed(range(LEVELS)):
        levels[2 * pi <= scale * (1 << level)] = level
    return levels


@lru_cache(maxsize=32)  # a sweep asks for the same few grids again and again, a finest one takes a tenth of a second
def grid(excited: Excitation, level: int, direction: int) -> Grid:
    """Return `excited` with 2^level·base steps to a mesh period of P12, passed through in `direction` 1 or -1."""
    parts = 1 << level
    tables = [
        _table(kappa, error, base * parts, direction)
        for kappa, error, base in zip(excited.stiffness, excited.error, excited.base, strict=True)
    ]
    base = excited.base[0]
    per_part = 2 * pi * direction * np.array(excited.shaft_turns) / parts
    angles = np.arange(2 * base + 1)[:, None] * (per_part / (2 * base))
    amplitude, phase = np.array(excited.eccentricity), np.array(excited.eccentricity_phase)
    return Grid(
        (tables[0], tables[1] if len(tables) > 1 else np.zeros((0, 3))),
        base,
        parts,
        np.column_stack([amplitude, phase, per_part, per_part / (2 * base)]),
        np.ascontiguousarray(np.hstack([np.cos(angles), np.sin(angles)])),
    )


def _table(kappa: PeriodicSeries, error: PeriodicSeries, steps: int, direction: int) -> Array:
    phase = direction * np.arange(2 * steps) % (2 * steps) / (2 * steps)
    slope = error.derivative(phase) * (direction / (2 * steps))
    return np.ascontiguousarray(np.column_stack([kappa.value(phase), error.value(phase), slope]))
