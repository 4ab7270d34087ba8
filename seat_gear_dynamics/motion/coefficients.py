"""The dimensionless coefficients of (16)-(19): what the equations need of a gear train, as arrays.

The twelve coordinates are, gear by gear for s1..s4, x, y and u = r·θ, each divided by b_c. Taking the arc u along the
base circle for θ gives all coordinates one unit; r²·k_nt·θ then reads k_nt·u and J reads J/r². Time is τ = ω_d·t with
ω_d from (15), force is divided by k̄_12·b_c. In this form every spring between gears is one direction w in coordinate
space, the two meshes and the shaft that s2 and s3 may share alike:

    M q″ + C q′ + K q + Σ_j w_j·F_j + w_s·F_s = load·Q,   δ_j = w_j·q − e_j,   F_j = κ_j f(δ_j) + c_j δ_j′,
    F_s = κ_s·w_s·q + c_s·w_s·q′

with M, C and K diagonal. Variants change single terms: `backlash_in_torsion` off puts δ_j for f(δ_j) in the lines of
u, `damping_in_contact_only` drops c_j δ_j′ where f(δ_j) is 0. P34 is written in its mirror image, so that both loads
close their mesh; the shaft then twists by θ2 + θ3.
"""

from dataclasses import dataclass
from math import cos, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import Gear, GearTrain, Mesh

Array = NDArray[np.float64]

COORDINATES = 12
PER_MESH = 6


@dataclass(frozen=True)
class Coefficients:
    """Mass-normalised dimensionless coefficients; shape (12,) per coordinate, (2,) per mesh."""

    stiffness: Array
    """Support stiffness over mass, (12,)."""
    damping: Array
    """Support damping over mass, (12,)."""
    direction: Array
    """w: how each coordinate closes its own mesh, (12,)."""
    reaction: Array
    """w over mass: the acceleration that a unit of mesh force takes away, (12,)."""
    drive: Array
    """Acceleration by the given torques per N·m of T4, (12,)."""
    mesh_damping: Array
    """c_j, (2,)."""
    half_backlash: Array
    """b_j/(2·b_c), (2,)."""
    shaft_direction: Array
    """w_s: the twist of the shaft as an arc at r2, (12,); zero but for u2 and u3."""
    shaft_reaction: Array
    """w_s over mass, (12,)."""
    shaft_stiffness: float
    """κ_s; 0 without a shaft."""
    shaft_damping: float
    """c_s."""
    eccentricity: Array
    """Amplitude of each gear's own error over b_c, (4,)."""
    eccentricity_phase: Array
    """Its phase at mesh phase 0, rad, (4,)."""
    shaft_turns: Array
    """Revolutions of each gear in a mesh period of P12, (4,)."""
    backlash_in_torsion: bool
    damping_in_contact_only: bool
    force_unit: float
    """k̄_12·b_c: the force that 1 stands for, N."""
    length_unit: float
    """b_c, m."""


def coefficients(train: GearTrain) -> Coefficients:
    """Return the dimensionless coefficients of `train`, with its torques scaled by its `load_scale`.

    Without a shaft T1 and T2 are the static torques of P12, T3 and T4 those of P34, as (10)-(13) are printed. With one
    T2 and T3 are inner torques, which the shaft carries.
    """
    omega, first = train.derived_time_scale, train.meshes[0]
    mean = first.mean_model_stiffness
    scale = train.model.displacement_scale
    masses = np.concatenate([_masses(g) for g in train.gears])
    ratios = np.concatenate([_stiffnesses(g) for g in train.gears])
    dampings = np.concatenate([_dampings(g) for g in train.gears])
    w = np.concatenate([_direction(m) for m in train.meshes])
    inertia = masses * omega**2 / mean
    forces = np.array(train.static_forces(1.0)) * train.model.load_scale / (mean * scale)
    torque = np.zeros(COORDINATES)
    torque[[2, 5]], torque[[8, 11]] = forces[0], forces[1]
    shaft = np.zeros(COORDINATES)
    if train.shaft.couples:
        torque[[5, 8]] = 0.0
        shaft[5], shaft[8] = 1.0, train.gears[1].base_radius / train.gears[2].base_radius
    shaft_stiffness, shaft_damping = _shaft(train)
    return Coefficients(
        stiffness=ratios / mean / inertia,
        damping=dampings * omega / mean / inertia,
        direction=w,
        reaction=w / inertia,
        drive=torque / inertia,
        mesh_damping=np.array([m.damping * omega / mean for m in train.meshes]),
        half_backlash=np.array([m.backlash / 2 / scale for m in train.meshes]),
        shaft_direction=shaft,
        shaft_reaction=shaft / inertia,
        shaft_stiffness=shaft_stiffness / mean,
        shaft_damping=shaft_damping * omega / mean,
        eccentricity=np.array([g.eccentricity / scale for g in train.gears]),
        eccentricity_phase=np.array([g.eccentricity_phase for g in train.gears]),
        shaft_turns=np.array([mesh_rate(train, i // 2) / g.teeth for i, g in enumerate(train.gears)]),
        backlash_in_torsion=train.variant.backlash_in_torsion,
        damping_in_contact_only=train.variant.damping_in_contact_only,
        force_unit=mean * scale,
        length_unit=scale,
    )


def mesh_rate(train: GearTrain, index: int) -> float:
    """Return the mesh frequency of mesh `index` (0 or 1) over that of P12."""
    return 1.0 if index == 0 else train.gears[2].teeth / train.gears[1].teeth


def static_state(train: GearTrain, load: float) -> Array:
    """Return the state, (24,), at rest under `load` (T4, N·m) with every mesh at its mean stiffness and no error.

    At zero load the teeth rest in the middle of the backlash, and near it under a load that torsional supports carry
    before the backlash closes. Solves the linear balance exactly for each choice of loaded flanks, and takes the first
    that is consistent with itself. Where nothing holds the train against turning as a whole, the rest nearest to zero.
    """
    c = coefficients(train)
    kappa = np.array([m.mean_model_stiffness for m in train.meshes]) / train.meshes[0].mean_model_stiffness
    state = np.zeros(2 * COORDINATES)
    for touching in ((1, 1), (1, 0), (0, 1), (0, 0)):
        q = _balance(c, kappa, load, np.array(touching, dtype=float))
        closing = (c.direction * q).reshape(2, PER_MESH).sum(axis=1) * (np.sign(load) or 1.0)
        slack = 1e-9 * (1 + np.abs(closing))
        consistent = np.where(touching, closing >= c.half_backlash - slack, np.abs(closing) <= c.half_backlash + slack)
        if consistent.all():
            break
    state[:COORDINATES] = q
    return state


def _balance(c: Coefficients, kappa: Array, load: float, touching: Array) -> Array:
    """Return the coordinates, (12,), that balance `load` with the given meshes on their loaded flank."""
    matrix = np.diag(c.stiffness) + c.shaft_stiffness * np.outer(c.shaft_reaction, c.shaft_direction)
    right = load * c.drive
    for j in range(2):
        own = slice(PER_MESH * j, PER_MESH * (j + 1))
        torsional = np.arange(PER_MESH) % 3 == 2
        sprung, offset = np.full(PER_MESH, touching[j]), np.full(PER_MESH, touching[j])
        if not c.backlash_in_torsion:  # the printed torsional lines have no dead zone
            sprung[torsional], offset[torsional] = 1.0, 0.0
        pull = kappa[j] * c.reaction[own]
        matrix[own, own] += np.outer(pull * sprung, c.direction[own])
        right[own] += np.sign(load) * c.half_backlash[j] * pull * offset
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0], dtype=float)


def _shaft(train: GearTrain) -> tuple[float, float]:
    """Return stiffness (N/m) and damping (N·s/m) of the shaft, both as seen along the base circle of s2."""
    _, s2, s3, _ = train.gears
    stiffness = train.shaft.stiffness / s2.base_radius**2
    inertia = s2.inertia * s3.inertia / (s2.inertia + s3.inertia) / s2.base_radius**2
    return stiffness, 2 * train.shaft.damping_ratio * sqrt(stiffness * inertia)


def _direction(mesh: Mesh) -> Array:
    """Return w of (δ = −(x_a − x_b) sin φ + (y_a − y_b) cos φ + u_a + u_b), shape (6,)."""
    s, c = sin(mesh.driver.pressure_angle), cos(mesh.driver.pressure_angle)
    return np.array([-s, c, 1.0, s, -c, 1.0])


def _masses(gear: Gear) -> Array:
    return np.array([gear.mass, gear.mass, gear.equivalent_mass])


def _stiffnesses(gear: Gear) -> Array:
    support = gear.support_clearance_factor * gear.support_stiffness
    return np.array([support, support, gear.torsional_stiffness])


def _dampings(gear: Gear) -> Array:
    stiffness, masses = _stiffnesses(gear), _masses(gear)
    ratios = (gear.support_damping_ratio, gear.support_damping_ratio, gear.torsional_damping_ratio)
    return np.array([2 * z * sqrt(k * m) for z, k, m in zip(ratios, stiffness, masses, strict=True)])
