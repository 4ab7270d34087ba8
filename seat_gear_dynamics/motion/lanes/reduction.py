"""A train along its lines of action: coefficients, states and static rest in the reduced coordinates of `structure`."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.coefficients import coefficients
from seat_gear_dynamics.motion.lanes.structure import PER_MESH, U2, U3

Array = NDArray[np.float64]

COORDINATES = 8
"""Reduced coordinates of a whole train."""
_MESH = np.arange(COORDINATES) // PER_MESH
_TORSIONAL = np.arange(COORDINATES) % 2 == 1


@dataclass(frozen=True)
class Reduced:
    """Mass-normalised dimensionless coefficients of one train, (8,) per coordinate, (2,) per mesh.

    They are those of `Coefficients`, with x and y of each gear taken together into p.
    """

    stiffness: Array
    """Support stiffness over mass; without the shaft."""
    damping: Array
    """Support damping over mass."""
    gain: Array
    """The acceleration that a unit of mesh force takes away."""
    drive: Array
    """Acceleration by the given torques per N·m of T4."""
    unit_damping: Array
    """Mesh damping c_j at a damping ratio of 1."""
    damping_ratio: Array
    """The train's own xi of each mesh."""
    half_backlash: Array
    """b_j/(2·b_c)."""
    mean_stiffness: Array
    """Mean mesh stiffness over that of P12."""
    shaft_weight: Array
    """w_s of u2 and u3, shape (2,); 0 without a shaft."""
    shaft_gain: Array
    """w_s over mass of u2 and u3, shape (2,)."""
    shaft_stiffness: float
    shaft_damping: float
    backlash_in_torsion: bool
    length_unit: float
    """b_c, m."""
    line: Array
    """How x and y of each gear make up its p: unit vectors, shape (4, 2)."""


def reduced(train: GearTrain) -> Reduced:
    """Return the reduced coefficients of `train`; `structure.supports` says whether they are all there is."""
    c = coefficients(train)
    unit = coefficients(train.with_mesh(0, damping_ratio=1.0).with_mesh(1, damping_ratio=1.0)).mesh_damping
    line = c.direction.reshape(4, 3)[:, :2]
    means = np.array([m.mean_model_stiffness for m in train.meshes])
    return Reduced(
        stiffness=_of_support(c.stiffness),
        damping=_of_support(c.damping),
        gain=_along(c.reaction, line),
        drive=_along(c.drive, line),
        unit_damping=unit,
        damping_ratio=np.array([m.damping_ratio for m in train.meshes]),
        half_backlash=c.half_backlash,
        mean_stiffness=means / means[0],
        shaft_weight=c.shaft_direction[[5, 8]],
        shaft_gain=c.shaft_reaction[[5, 8]],
        shaft_stiffness=c.shaft_stiffness,
        shaft_damping=c.shaft_damping,
        backlash_in_torsion=c.backlash_in_torsion,
        length_unit=c.length_unit,
        line=line,
    )


def reduce_state(state: Array, line: Array) -> Array:
    """Return states (n, 24) in reduced coordinates, (n, 16): p1, u1, … u4, then their rates.

    Motion across the line of action is dropped: it dies away by itself and touches nothing else.
    """
    by_gear = state.reshape(-1, 2, 4, 3)
    with np.errstate(invalid="ignore"):  # an infinite state is a diverged one, and told as such
        p = by_gear[..., 0] * line[:, 0] + by_gear[..., 1] * line[:, 1]
    return np.stack([p, by_gear[..., 2]], axis=-1).reshape(-1, 2 * COORDINATES)


def expand_state(state: Array, line: Array) -> Array:
    """Return reduced states (n, 16) in the order of STATE_NAMES, (n, 24), at rest across the line of action."""
    by_gear = state.reshape(-1, 2, 4, 2)
    p, u = by_gear[..., 0], by_gear[..., 1]
    return np.stack([p * line[:, 0], p * line[:, 1], u], axis=-1).reshape(-1, 24)


def static_rest(r: Reduced, load: Array, half_backlash: Array) -> Array:
    """Return the coordinates at rest, (n, 8), under loads (n,) with half backlashes (n, 2), in dimensionless form.

    The same rest as `motion.coefficients.static_state`, of which each lane is one case: the balance is linear in load
    and backlash for each choice of loaded flanks, so it is solved once per choice and not once per lane.
    """
    rest = np.zeros((len(load), COORDINATES))
    settled = np.zeros(len(load), dtype=bool)
    side = np.sign(load)
    for touching in product((True, False), repeat=2):
        by_load, by_backlash = _balance(r, np.array(touching))
        q = load[:, None] * by_load + side[:, None] * (
            half_backlash[:, :1] * by_backlash[0] + half_backlash[:, 1:] * by_backlash[1]
        )
        closing = _closing(q) * np.where(side == 0, 1.0, side)[:, None]
        slack = 1e-9 * (1 + np.abs(closing))
        fits = np.where(touching, closing >= half_backlash - slack, np.abs(closing) <= half_backlash + slack).all(
            axis=1
        )
        rest[~settled] = q[~settled]
        settled |= fits
    return rest


def _balance(r: Reduced, touching: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the coordinates that balance a load of 1 N·m, (8,), and a half backlash of 1 in each mesh, (2, 8)."""
    # The printed torsional lines have no dead zone: they are sprung at any δ, and feel no backlash.
    without_dead_zone = _TORSIONAL & (not r.backlash_in_torsion)
    pull = r.mean_stiffness[_MESH] * r.gain
    sprung = pull * (touching[_MESH] | without_dead_zone)
    matrix = np.diag(r.stiffness) + sprung[:, None] * (_MESH[:, None] == _MESH)
    shaft = np.array([U2, U3])
    matrix[np.ix_(shaft, shaft)] += r.shaft_stiffness * np.outer(r.shaft_gain, r.shaft_weight)
    offset = pull * (touching[_MESH] & ~without_dead_zone)
    right = np.column_stack([r.drive, *(offset * (j == _MESH) for j in range(2))])
    solved = np.linalg.lstsq(matrix, right, rcond=None)[0].T
    return solved[0], solved[1:]


def _closing(q: Array) -> Array:
    return np.stack([((q[:, i] + q[:, i + 1]) + (q[:, i + 2] + q[:, i + 3])) for i in (0, PER_MESH)], axis=-1)


def _of_support(row: Array) -> Array:
    return row.reshape(4, 3)[:, [0, 2]].ravel()


def _along(row: Array, line: Array) -> Array:
    """Return a row over x, y, u as one over p, u: x and y projected on the line of action."""
    by_gear = row.reshape(4, 3)
    return np.column_stack([(by_gear[:, :2] * line).sum(axis=1), by_gear[:, 2]]).ravel()
