"""The dimensionless coefficients of (16)-(19): what the equations need of a gear train, as arrays.

The twelve coordinates are, gear by gear for s1..s4, x, y and u = r·θ, each divided by b_c. Taking the arc u along the
base circle for θ gives all coordinates one unit; r²·k_nt·θ then reads k_nt·u and J reads J/r². Time is τ = ω_d·t with
ω_d from (15), force is divided by k̄_12·b_c. In this form every mesh is one direction w in coordinate space:

    M q″ + C q′ + K q + Σ_j w_j·F_j = load·Q,   δ_j = w_j·q − e_j,   F_j = κ_j f(δ_j) + c_j δ_j′

with M, C and K diagonal, because shafts and supports couple no two coordinates in the decoupled train as printed.
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
    force_unit: float
    """k̄_12·b_c: the force that 1 stands for, N."""
    length_unit: float
    """b_c, m."""


def coefficients(train: GearTrain) -> Coefficients:
    """Return the dimensionless coefficients of `train`, with its torques scaled by its `load_scale`.

    T1 and T2 are the static torques of the P12 mesh and T3 and T4 those of P34, because as printed (10)-(13) know no
    shaft between s2 and s3.
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
    return Coefficients(
        stiffness=ratios / mean / inertia,
        damping=dampings * omega / mean / inertia,
        direction=w,
        reaction=w / inertia,
        drive=torque / inertia,
        mesh_damping=np.array([m.damping * omega / mean for m in train.meshes]),
        half_backlash=np.array([m.backlash / 2 / scale for m in train.meshes]),
        force_unit=mean * scale,
        length_unit=scale,
    )


def static_state(train: GearTrain, load: float) -> Array:
    """Return the state, (24,), at rest under `load` (T4, N·m) with every mesh at its mean stiffness and no error.

    At zero load the teeth rest in the middle of the backlash, and near it under a load that torsional supports carry
    before the backlash closes. Solves the linear balance exactly, on the loaded flank or free of it.
    """
    c = coefficients(train)
    state = np.zeros(2 * COORDINATES)
    mean = train.meshes[0].mean_model_stiffness
    for j, mesh in enumerate(train.meshes):
        own = slice(PER_MESH * j, PER_MESH * (j + 1))
        stiffness, w, push, half = c.stiffness[own], c.direction[own], load * c.drive[own], c.half_backlash[j]
        free = np.divide(push, stiffness, out=np.zeros(PER_MESH), where=stiffness > 0)
        if np.all(stiffness[push != 0] > 0) and abs(w @ free) <= half:  # the supports alone carry so small a load
            state[own] = free
            continue
        reaction = mesh.mean_model_stiffness / mean * c.reaction[own]
        right = push + np.sign(load) * half * reaction
        state[own] = np.linalg.lstsq(np.diag(stiffness) + np.outer(reaction, w), right, rcond=None)[0]
    return state


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
