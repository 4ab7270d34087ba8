"""The right-hand side for steps of any length: the march's equations, excited by the Fourier series themselves.

The production march reads its excitation from tables, because its step is locked to the mesh period. Here the series
are summed at every evaluation. The equations are `kernel._rates`, with every variant.

A mesh is on one of three branches: -1 and 1, in contact on a flank, and 0, apart. `FREE` lets δ choose in each
evaluation, as (1) reads. A held branch goes on smoothly beyond its boundary, as a step needs that is to be cut there.
"""

from collections.abc import Callable
from math import cos, floor, inf, pi, sin
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.gears import PeriodicSeries
from seat_gear_dynamics.motion import kernel
from seat_gear_dynamics.motion.kernel import Equations, _rates
from seat_gear_dynamics.motion.revision import revision
from seat_gear_dynamics.motion.system import System

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FREE = 9
"""Branch of a mesh whose contact is chosen by δ in every evaluation."""
_NEVER_APART = -1e-300  # half of a backlash within which no δ lies


class Excitation(NamedTuple):
    """What moves the equations from outside, at a steady drive."""

    frequency: float
    load: float
    mean: Array
    """κ of each mesh, (2,)."""
    harmonics: Array
    """κ cosine and sine, e/b_c cosine and sine per harmonic, (2, n, 4)."""
    ratio: Array
    """Mesh frequency over that of P12, (2,)."""
    eccentric: bool
    eccentricity: Array
    eccentricity_phase: Array
    shaft_turns: Array


class Field(NamedTuple):
    """The right-hand side with room for its work: not to be shared between threads."""

    equations: Equations
    """Its `half_backlash` is written in each evaluation, as the branches want it."""
    half_backlash: Array
    excitation: Excitation
    row: Array
    """Excitation at the last evaluation as `kernel._rates` wants it, (2, 3)."""
    mesh: Array
    """(δ, δ′, force, in contact) of each mesh at the last evaluation, (2, 4); δ counts from the held flank."""
    spare: Array
    """Stands in for a tangent where there is none, (2, 24)."""


def field_of(system: System) -> Field:
    """Return the compiled right-hand side of `system` at its operating point."""
    c, train, point = system.coefficients, system.train, system.operating_point
    shared = {name: getattr(c, name) for name in Equations._fields if name != "coupled"}
    equations = Equations(**shared | {"half_backlash": np.empty(2), "coupled": train.shaft.couples})
    mean = train.meshes[0].mean_model_stiffness
    stiffness = [m.stiffness.scaled(1 / mean) for m in train.meshes]
    error = [m.transmission_error.scaled(1 / c.length_unit) for m in train.meshes]
    # A whole number given for a real one would be another type to the compiler, and compile everything once more.
    excitation = Excitation(
        float(point.frequency),
        float(point.load),
        np.array([series.mean for series in stiffness]),
        _harmonics(stiffness, error),
        np.array(system.mesh_rates),
        bool(c.eccentricity.any()),
        c.eccentricity,
        c.eccentricity_phase,
        c.shaft_turns,
    )
    return Field(equations, c.half_backlash, excitation, np.empty((2, 3)), np.empty((2, 4)), np.zeros((2, 24)))


def _harmonics(stiffness: list[PeriodicSeries], error: list[PeriodicSeries]) -> Array:
    """Return the harmonics of both meshes side by side, shorter series filled with zeros, (2, n, 4)."""
    table = np.zeros((2, max(len(s.cosine) for s in stiffness + error), 4))
    for j in range(2):
        for column, part in enumerate((stiffness[j].cosine, stiffness[j].sine, error[j].cosine, error[j].sine)):
            table[j, : len(part), column] = part
    return table


def right_hand_side(system: System) -> Callable[[float, ArrayLike], Array]:
    """Return the compiled equivalent of `system.derivative`: f(τ, state (24,)) -> d(state)/dτ, (24,).

    For solvers from outside at the price of a compiled call; not to be called from several threads at once. Nothing is
    checked: a state of another shape is refused by numba, not in a sentence.
    """
    field, branches = field_of(system), np.full(2, FREE)

    def derivative(t: float, state: ArrayLike) -> Array:
        return np.asarray(_evaluate(float(t), np.asarray(state, dtype=float).reshape(1, 24), branches, field))

    return derivative


@njit(error_model="numpy", inline="always")
def excite(t: float, x: Excitation, row: Array) -> None:
    """Fill row[j] = (κ, e, de per mesh period of P12) of both meshes at τ = t, shape (2, 3)."""
    periods = x.frequency * t / (2 * pi)
    for j in range(2):
        phase = x.ratio[j] * periods
        angle = 2 * pi * (phase - floor(phase))
        c1, s1, c, s = cos(angle), sin(angle), 1.0, 0.0
        kappa, error, slope = x.mean[j], 0.0, 0.0
        for n in range(x.harmonics.shape[1]):
            c, s = c * c1 - s * s1, s * c1 + c * s1
            kappa += x.harmonics[j, n, 0] * c + x.harmonics[j, n, 1] * s
            error += x.harmonics[j, n, 2] * c + x.harmonics[j, n, 3] * s
            slope += (n + 1) * (x.harmonics[j, n, 3] * c - x.harmonics[j, n, 2] * s)
        row[j, 0], row[j, 1], row[j, 2] = kappa, error, 2 * pi * x.ratio[j] * slope
    if x.eccentric:
        for gear in range(4):
            angle = 2 * pi * periods * x.shaft_turns[gear] + x.eccentricity_phase[gear]
            row[gear // 2, 1] += x.eccentricity[gear] * sin(angle)
            row[gear // 2, 2] += 2 * pi * x.shaft_turns[gear] * x.eccentricity[gear] * cos(angle)


@njit(error_model="numpy", inline="always")
def rates(t: float, rows: Array, out: Array, count: int, branches: Index, field: Field) -> None:
    """Fill out[r] = d(rows[r])/dτ for the first `count` rows, (24,) each: the state, then tangent vectors.

    A held contact is (1) with a backlash so small that no δ lies in it, the flank's own place moved into e. As printed,
    the torsional lines know δ and not f(δ), so that what was moved is given back to them.

    Made part of its callers before compilation: as a call of its own it counts references to every array of the field.
    """
    eq, x, row = field.equations, field.excitation, field.row
    excite(t, x, row)
    for j in range(2):
        if branches[j] == FREE:
            eq.half_backlash[j] = field.half_backlash[j]
        elif branches[j] == 0:
            eq.half_backlash[j] = inf
        else:
            eq.half_backlash[j] = _NEVER_APART
            row[j, 1] += branches[j] * field.half_backlash[j]
    rate = x.frequency / (2 * pi)
    if count == 1:
        _rates(rows[0], field.spare[0], row, rate, x.load, eq, out[0], field.spare[1], field.mesh)
    for r in range(1, count):
        _rates(rows[0], rows[r], row, rate, x.load, eq, out[0], out[r], field.mesh)
    if not eq.backlash_in_torsion:
        for j in range(2):
            if branches[j] != FREE and branches[j] != 0:
                moved = row[j, 0] * branches[j] * field.half_backlash[j]
                for i in range(6 * j + 2, 6 * j + 6, 3):
                    out[0, i + 12] -= eq.reaction[i] * moved


def _entry(revision: int) -> Any:
    @njit(cache=True, error_model="numpy")
    def evaluate(t: float, rows: Array, branches: Index, field: Field) -> Array:
        _ = revision
        out = np.empty((1, 24))
        rates(t, rows, out, 1, branches, field)
        return np.asarray(out[0])

    return evaluate


_evaluate = _entry(revision(kernel))
