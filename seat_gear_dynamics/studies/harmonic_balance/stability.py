"""Floquet multipliers of an orbit: the linearised equations of all twelve states, integrated over one period.

The linear part is smooth but for the instants at which teeth part or meet. These are found first and made ends of
steps, so that the classical Runge-Kutta method keeps its fourth order. f(δ) is continuous, so the solution needs no
jump there; where damping acts in contact only the force jumps by c·δ′, and the tangent's rates by the saltation
w/m·c·(w·Δq) (Leine & Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems", 2004).
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.fourier import evaluate
from seat_gear_dynamics.studies.harmonic_balance.orbit import Orbit
from seat_gear_dynamics.studies.harmonic_balance.pair import COORDINATES, Pair

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STATES = 2 * COORDINATES
LONGEST_STEP = 0.06
"""Units of τ; the stiffest mode of the packaged pair turns by a tenth of a radian in it."""
LEAST_STEPS = 128
"""Per mesh period."""
NEUTRAL = 1e-5
"""How far beyond 1 a multiplier still counts as neutral: a train that nothing holds against turning has two at 1."""


class Linear(NamedTuple):
    """The linear part of the pair, as the compiled loop wants it."""

    stiffness: Array
    damping: Array
    direction: Array
    reaction: Array
    mesh_damping: float
    backlash_in_torsion: bool
    damping_in_contact_only: bool


def multipliers(orbit: Orbit, *, longest_step: float = LONGEST_STEP) -> Complex:
    """Return the twelve Floquet multipliers of `orbit` over its period, largest first.

    Four belong to motion across the line of action, which is decoupled and only decays. An orbit is stable where none
    is beyond 1 + NEUTRAL in size. The orbit is taken as the harmonics give it, so truncation shows in them as well.
    """
    found = np.linalg.eigvals(monodromy(orbit, longest_step=longest_step))
    return np.asarray(found[np.argsort(-np.abs(found), kind="stable")], dtype=complex)


def monodromy(orbit: Orbit, *, longest_step: float = LONGEST_STEP) -> Array:
    """Return the matrix, (12, 12), that takes a small disturbance at phase 0 to what it is a period later."""
    ends = _nodes(orbit, longest_step)
    begin, length = ends[:-1], np.diff(ends)
    middle = begin + length / 2
    periods, series = orbit.balance.subharmonics, orbit.balance.pair.kappa_coefficients
    kappa = np.column_stack([evaluate(series, p * periods % 1.0)[0] for p in (begin, middle, ends[1:])])
    half = orbit.balance.pair.half_backlash(orbit.conditions)
    contact = (np.abs(orbit.deflection(middle)) > half).astype(float)
    return np.asarray(
        propagated(np.ascontiguousarray(kappa), contact, length * orbit.period, linear_part(orbit.balance.pair, orbit))
    )


def linear_part(pair: Pair, orbit: Orbit) -> Linear:
    """Return the coefficients of the linearised equations under the orbit's conditions."""
    return Linear(
        pair.stiffness,
        pair.damping,
        pair.direction,
        pair.reaction,
        pair.mesh_damping(orbit.conditions),
        pair.backlash_in_torsion,
        pair.damping_in_contact_only,
    )


def _nodes(orbit: Orbit, longest_step: float) -> Array:
    """Return the ends of the steps in phases, from 0 to 1: even ones and the instants of parting and meeting."""
    steps = max(int(np.ceil(orbit.period / longest_step)), LEAST_STEPS * orbit.balance.subharmonics)
    return np.unique(np.concatenate([np.linspace(0.0, 1.0, steps + 1), orbit.crossings]))


@njit(cache=True, error_model="numpy")
def _rates(z: Array, kappa: float, contact: float, eq: Linear, dz: Array) -> None:
    """Fill dz = A(τ)·z of one disturbance, (12,)."""
    closing, speed = 0.0, 0.0
    for i in range(6):
        closing += eq.direction[i] * z[i]
        speed += eq.direction[i] * z[i + 6]
    c = eq.mesh_damping
    if eq.damping_in_contact_only:
        c *= contact
    force = kappa * contact * closing + c * speed
    for i in range(6):
        dz[i] = z[i + 6]
        dz[i + 6] = -eq.stiffness[i] * z[i] - eq.damping[i] * z[i + 6] - eq.reaction[i] * force
    if not eq.backlash_in_torsion:
        for i in range(2, 6, 3):
            dz[i + 6] -= eq.reaction[i] * kappa * (1.0 - contact) * closing


@njit(cache=True, error_model="numpy")
def propagated(kappa: Array, contact: Array, lengths: Array, eq: Linear) -> Array:
    """Return the product of all steps, (12, 12); kappa (n, 3) at the begin, middle and end of each of n steps."""
    result = np.empty((12, 12))
    z, shifted = np.empty(12), np.empty(12)
    k1, k2, k3, k4 = np.empty(12), np.empty(12), np.empty(12), np.empty(12)
    for column in range(12):
        z[:] = 0.0
        z[column] = 1.0
        touching = contact[-1]
        for n in range(len(lengths)):
            h = lengths[n]
            if eq.damping_in_contact_only and contact[n] != touching:
                closing = 0.0
                for i in range(6):
                    closing += eq.direction[i] * z[i]
                for i in range(6):
                    z[i + 6] -= eq.reaction[i] * eq.mesh_damping * (contact[n] - touching) * closing
            touching = contact[n]
            _rates(z, kappa[n, 0], touching, eq, k1)
            for i in range(12):
                shifted[i] = z[i] + 0.5 * h * k1[i]
            _rates(shifted, kappa[n, 1], touching, eq, k2)
            for i in range(12):
                shifted[i] = z[i] + 0.5 * h * k2[i]
            _rates(shifted, kappa[n, 1], touching, eq, k3)
            for i in range(12):
                shifted[i] = z[i] + h * k3[i]
            _rates(shifted, kappa[n, 2], touching, eq, k4)
            for i in range(12):
                z[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
        for i in range(12):
            result[i, column] = z[i]
    return result
