"""Lanes of one or several trains made ready: each lane's step, start and rows, grouped by what a block must share."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes.excitation import Excitation, excitation, level_of
from seat_gear_dynamics.motion.lanes.points import CheckedPoints
from seat_gear_dynamics.motion.lanes.propagator import Mechanics, propagator
from seat_gear_dynamics.motion.lanes.reduction import (
    COORDINATES,
    Reduced,
    expand_state,
    reduce_state,
    reduced,
    static_rest,
)
from seat_gear_dynamics.motion.lanes.structure import STAGES, U2, U3, Structure, structure_of, supports
from seat_gear_dynamics.motion.tables import LEVELS

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# The direction in which `motion.March` starts its tangent.
_TANGENT = np.tile(np.array([0.5, 0.3, 0.7, -0.2, 0.4, 0.6]), 4)
_EMPTY_WINDOW = {"SUM": 0.0, "SQUARES": 0.0, "LEAST": inf, "MOST": -inf, "APART": 0.0}


@dataclass(frozen=True)
class Company:
    """What the lanes of a block share."""

    structure: Structure
    excitation: Excitation
    level: int
    direction: int


@dataclass(frozen=True, eq=False)
class Entry:
    """The lanes of one train."""

    reduced: Reduced
    structure: Structure
    excitation: Excitation
    points: CheckedPoints
    level: Index
    half_step: Array
    """Half the step in τ, (n,)."""
    damping: Array
    """Mesh damping c_j, (n, 2)."""
    half_backlash: Array
    """b_j/(2·b_c), (n, 2)."""
    start: Array
    """Initial states in reduced coordinates, (n, 16)."""

    def companies(self) -> list[tuple[Company, Index]]:
        """Return the lanes of this train by what they share with others."""
        direction = np.where(self.points.frequency > 0, 1, -1)
        found = []
        for level in np.unique(self.level):
            for way in (1, -1):
                lanes = np.flatnonzero((self.level == level) & (direction == way))
                if len(lanes):
                    found.append((Company(self.structure, self.excitation, int(level), way), lanes))
        return found

    def expand(self, state: Array) -> Array:
        """Return reduced states (n, 16) of this train in the order of STATE_NAMES, (n, 24)."""
        return expand_state(state, self.reduced.line)


def entry(
    train: GearTrain, points: CheckedPoints, *, meshes: int | None, target_steps: int, longest_step: float
) -> Entry:
    """Return the lanes of `train` at `points`; raise ValueError where lanes cannot march them."""
    _check_train(train, meshes)
    structure = structure_of(train, meshes=meshes or (2 if train.shaft.couples else 1))
    r, excited = reduced(train), excitation(train, meshes=structure.meshes, target_steps=target_steps)
    level = level_of(points.frequency, excited.base[0], longest_step)
    _check_level(points.frequency, level, excited.base[0], longest_step)
    backlash = None if points.backlash is None else points.backlash / 2 / r.length_unit
    half_backlash = _of_both_meshes(backlash, r.half_backlash, len(level))
    return Entry(
        r,
        structure,
        excited,
        points,
        level,
        pi / (np.abs(points.frequency) * excited.base[0] * (1 << level)),
        r.unit_damping * _of_both_meshes(points.damping_ratio, r.damping_ratio, len(level)),
        half_backlash,
        _start(r, points, half_backlash),
    )


def _check_train(train: GearTrain, meshes: int | None) -> None:
    if not supports(train):
        raise ValueError(
            f"The train {train.name!r} has gears held differently in x and y, which lanes do not march; "
            f"use motion.integrate."
        )
    if meshes not in (1, 2, None) or (meshes == 1 and train.shaft.couples):
        raise ValueError(
            f"Asked for {meshes} meshes; expected 1 (P12) or 2, and 2 where a shaft couples them, or None."
        )


def _check_level(frequency: Array, level: Index, base: int, longest_step: float) -> None:
    if (level == LEVELS).any():
        lane = int(np.flatnonzero(level == LEVELS)[0])
        slowest = 2 * pi / (longest_step * base * (1 << (LEVELS - 1)))
        raise ValueError(
            f"The frequency of lane {lane} is {float(frequency[lane])!r}, below the slowest that lanes can march, "
            f"{slowest:.3g}; use motion.integrate, which lets the phase creep."
        )


def _of_both_meshes(given: Array | None, own: Array, lanes: int) -> Array:
    return np.tile(own, (lanes, 1)) if given is None else np.repeat(given[:, None], 2, axis=1)


def _start(r: Reduced, points: CheckedPoints, half_backlash: Array) -> Array:
    if points.state is not None:
        return reduce_state(points.state, r.line)
    return np.hstack([static_rest(r, points.load, half_backlash), np.zeros((len(points.load), COORDINATES))])


def rows(structure: Structure, members: Sequence[tuple[Entry, Index]]) -> tuple[Array, Array]:
    """Return the rows of all lanes of a company, (rows, lanes), and their half steps, (lanes,).

    `members` are entries with the lanes of theirs that belong, in the order in which the columns come.
    """
    s, count = structure, structure.coordinates
    half_step = np.concatenate([e.half_step[lanes] for e, lanes in members])
    start = np.concatenate([e.start[lanes] for e, lanes in members])
    tangent = np.concatenate([np.tile(reduce_state(_TANGENT, e.reduced.line), (len(lanes), 1)) for e, lanes in members])
    named = propagator(s, _mechanics(s, members, half_step))
    for prefix, values in (("", start), ("Z", tangent)):
        for i in range(count):
            named[f"{prefix}Q{i}"] = values[:, i]
            named[f"{prefix}V{i}"] = values[:, COORDINATES + i] * half_step
    for j in range(s.meshes):
        damping = np.concatenate([e.damping[lanes, j] for e, lanes in members]) / half_step
        named |= {structure.damping(j, stage): damping for stage in STAGES}
        named[f"UPPER{j}"] = np.concatenate([e.half_backlash[lanes, j] for e, lanes in members])
        named[f"LOWER{j}"] = -named[f"UPPER{j}"]
        named |= {f"{kind}{j}": np.full(len(half_step), value) for kind, value in _EMPTY_WINDOW.items()}
    table = np.zeros((len(s.row), len(half_step)))
    for name, index in s.row.items():
        if name in named:  # scratch rows begin at 0
            table[index] = named[name]
    return table, half_step


def _mechanics(s: Structure, members: Sequence[tuple[Entry, Index]], half_step: Array) -> Mechanics:
    """Return the coefficients of all lanes of a company in half steps."""
    counts = [len(lanes) for _, lanes in members]
    by_train = np.stack([_linear(s, e.reduced) for e, _ in members], axis=-1)
    stiffness, damping, gain, drive, far_stiffness, far_damping = np.repeat(by_train, counts, axis=-1)
    load = np.concatenate([e.points.load[lanes] for e, lanes in members])
    square = half_step * half_step
    return Mechanics(
        stiffness * square,
        damping * half_step,
        gain * square,
        drive * load * square,
        far_stiffness * square,
        far_damping * half_step,
    )


def _linear(s: Structure, r: Reduced) -> Array:
    """Return a train's rows per τ, (6, coordinates): what holds, damps, pulls and drives, and the shaft's far end."""
    n = s.coordinates
    held = np.stack([r.stiffness[:n], r.damping[:n], r.gain[:n], r.drive[:n], np.zeros(n), np.zeros(n)])
    if s.coupled:
        ends, shaft = np.array([U2, U3]), np.array([r.shaft_stiffness, r.shaft_damping])[:, None]
        held[:2, ends] += shaft * (r.shaft_gain * r.shaft_weight)
        held[4:, ends] = shaft * (r.shaft_gain * r.shaft_weight[::-1])
    return held
