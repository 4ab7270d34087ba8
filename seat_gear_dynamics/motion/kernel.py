"""What a march is made of: the equations for plain numbers, the excitation's tables, and the plan of a step.

`steps.march` puts them together, with the equations of `stages`, which are these for four numbers at a time.
"""

from math import cos, isfinite, log, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FINISHED, DIVERGED, SECTIONS_FULL = 0, 1, 2
"""Result codes of a march."""
WINDOW_COLUMNS = ("duration", "sum", "sum_of_squares", "minimum", "maximum", "separated")
SECTION_COLUMNS = ("tau", "delta", "rate", "growth_12", "growth_34")

BEYOND = 1e8
"""A mesh deflection of a hundred million b_c is a diverged solution, not a motion."""
RENORMALISE = 1024
"""Steps after which the tangent is rescaled where no section does it (standstill)."""

# Part of their callers: a call would count references to every array that it is given, and a motion in registers would
# go through memory, both of which take longer than what is computed.
inlined = njit(error_model="numpy", forceinline=True)


class Equations(NamedTuple):
    """The coefficients as the march wants them; shapes as in `Coefficients`."""

    stiffness: Array
    damping: Array
    direction: Array
    reaction: Array
    drive: Array
    mesh_damping: Array
    half_backlash: Array
    shaft_direction: Array
    shaft_reaction: Array
    shaft_stiffness: float
    shaft_damping: float
    coupled: bool
    backlash_in_torsion: bool
    damping_in_contact_only: bool


class Grid(NamedTuple):
    """The tables as the march wants them; see `tables.Tables`."""

    first: Array
    second: Array
    base: int
    base_second: int
    levels: int
    cycle: int
    longest_step: float
    eccentric: bool
    eccentricity: Array
    eccentricity_phase: Array
    shaft_turns: Array


class Segment(NamedTuple):
    """Inputs linear in τ from `tau` on; steps are made while they start before `end`."""

    tau: float
    end: float
    frequency: float
    frequency_slope: float
    load: float
    load_slope: float


@njit(cache=True, error_model="numpy")
def _rates(
    y: Array, z: Array, row: Array, rate: float, load: float, eq: Equations, dy: Array, dz: Array, mesh: Array
) -> None:
    """Fill dy = dy/dτ and dz = Jacobian·z; mesh[j] = (δ, δ′, force, in contact) of each mesh.

    f(δ) is continuous, so the tangent needs no jump where contact changes; its slope is κ in contact and 0 out of it.
    Only where damping acts in contact alone the force jumps, and this tangent lacks the jump's share.
    """
    twist = d_twist = 0.0
    if eq.coupled:
        for i in range(5, 9, 3):  # u2 and u3
            twist += eq.shaft_direction[i] * (eq.shaft_stiffness * y[i] + eq.shaft_damping * y[i + 12])
            d_twist += eq.shaft_direction[i] * (eq.shaft_stiffness * z[i] + eq.shaft_damping * z[i + 12])
    for j in range(2):
        o = 6 * j
        delta, speed = -row[j, 1], -row[j, 2] * rate
        d_delta, d_speed = 0.0, 0.0
        for i in range(o, o + 6):
            delta += eq.direction[i] * y[i]
            speed += eq.direction[i] * y[i + 12]
            d_delta += eq.direction[i] * z[i]
            d_speed += eq.direction[i] * z[i + 12]
        half = eq.half_backlash[j]
        beyond, contact = 0.0, 0.0
        if delta > half:
            beyond, contact = delta - half, 1.0
        elif delta < -half:
            beyond, contact = delta + half, 1.0
        kappa, c = row[j, 0], eq.mesh_damping[j]
        if eq.damping_in_contact_only:
            c *= contact
        force = kappa * beyond + c * speed
        d_force = kappa * contact * d_delta + c * d_speed
        mesh[j, 0], mesh[j, 1], mesh[j, 2], mesh[j, 3] = delta, speed, force, contact
        for i in range(o, o + 6):
            dy[i] = y[i + 12]
            dz[i] = z[i + 12]
            k, b, g = eq.stiffness[i], eq.damping[i], eq.reaction[i]
            dy[i + 12] = load * eq.drive[i] - k * y[i] - b * y[i + 12] - g * force
            dz[i + 12] = -k * z[i] - b * z[i + 12] - g * d_force
        if not eq.backlash_in_torsion:  # what δ has over f(δ), on the lines of u
            for i in range(o + 2, o + 6, 3):
                dy[i + 12] -= eq.reaction[i] * kappa * (delta - beyond)
                dz[i + 12] -= eq.reaction[i] * kappa * (1.0 - contact) * d_delta
    if eq.coupled:
        for i in range(5, 9, 3):
            dy[i + 12] -= eq.shaft_reaction[i] * twist
            dz[i + 12] -= eq.shaft_reaction[i] * d_twist


@inlined
def look_up(row: Array, grid: Grid, level: int, half: int) -> None:
    """Copy the excitation of both meshes at half step `half` of `level` into row, shape (2, 3)."""
    scale = 1 << level
    n1, n2 = 2 * grid.base * scale, 2 * grid.base_second * scale
    i1 = 2 * grid.base * (scale - 1) + half % n1
    i2 = 2 * grid.base_second * (scale - 1) + half % n2
    for k in range(3):
        row[0, k] = grid.first[i1, k]
        row[1, k] = grid.second[i2, k]
    row[1, 2] *= grid.base / grid.base_second  # P34's phase runs slower than P12's, to whose rate slopes are taken
    if grid.eccentric:
        periods = half / n1
        for gear in range(4):
            angle = 2 * pi * periods * grid.shaft_turns[gear] + grid.eccentricity_phase[gear]
            row[gear // 2, 1] += grid.eccentricity[gear] * sin(angle)
            row[gear // 2, 2] += 2 * pi * grid.shaft_turns[gear] * grid.eccentricity[gear] * cos(angle)


@njit(cache=True, error_model="numpy")
def renormalise(z: Array, growth: Array, coupled: bool) -> None:
    """Scale the tangent to length 1 and add the logarithm of what it had grown by: each pair's own, or the train's."""
    squares = np.zeros(2)
    for j in range(2):
        for i in range(6 * j, 6 * j + 6):
            squares[j] += z[i] * z[i] + z[i + 12] * z[i + 12]
    for j in range(2):
        norm = sqrt(squares[0] + squares[1]) if coupled else sqrt(squares[j])
        if norm > 0.0 and isfinite(norm):
            growth[j] += log(norm)
            for i in range(6 * j, 6 * j + 6):
                z[i] /= norm
                z[i + 12] /= norm
        else:  # died out below the smallest number: start another direction, its growth is unknown
            z[6 * j] = 1.0


@inlined
def _grid_level(frequency: float, place: int, grid: Grid) -> int:
    """Return the coarsest level whose step is short enough and on whose grid `place` lies; grid.levels means creep."""
    speed = abs(frequency)
    for level in range(grid.levels):
        stride = 1 << (grid.levels - 1 - level)
        if place & (stride - 1) == 0 and 2 * pi <= grid.longest_step * speed * grid.base * (1 << level):
            return level
    return grid.levels


@inlined
def plan(frequency: float, clock: Array, place: Index, grid: Grid) -> tuple[int, float, float, int]:
    """Return (level, step in τ, phase rate of P12 per τ, finest steps that the phase moves, signed) of the next step.

    Where even the finest grid would take too long a step the phase creeps: the excitation is held over a longest step
    (rate 0), what the phase should have moved is saved up in clock[1], and it moves by whole finest steps.
    """
    finest = grid.levels - 1
    level = _grid_level(frequency, place[0], grid)
    if level < grid.levels:
        h = 2 * pi / (abs(frequency) * grid.base * (1 << level))
        stride = 1 << (finest - level)
        return level, h, frequency / (2 * pi), stride if frequency > 0 else -stride
    clock[1] += frequency * grid.longest_step / (2 * pi) * (grid.base << finest)
    whole = int(clock[1])  # towards zero
    clock[1] -= whole
    return finest, grid.longest_step, 0.0, whole


@njit(cache=True, error_model="numpy")
def record(sections: Array, recorded: Index, tau: float, delta: float, rate: float, growth: Array) -> None:
    """Write one section point of P12 in the order of SECTION_COLUMNS and start the growth anew."""
    r = recorded[0]
    sections[r, 0], sections[r, 1], sections[r, 2] = tau, delta, rate
    sections[r, 3], sections[r, 4] = growth[0], growth[1]
    growth[0], growth[1] = 0.0, 0.0
    recorded[0] = r + 1


@njit(cache=True, error_model="numpy")
def mesh_values(y: Array, place: Index, frequency: float, eq: Equations, grid: Grid) -> Array:
    """Return (δ, δ′, force, in contact) of both meshes at the present place, shape (2, 4)."""
    row, mesh = np.empty((2, 3)), np.empty((2, 4))
    scratch_y, scratch_z, z = np.empty(24), np.empty(24), np.zeros(24)
    look_up(row, grid, grid.levels - 1, 2 * place[0])
    _rates(y, z, row, frequency / (2 * pi), 0.0, eq, scratch_y, scratch_z, mesh)
    return mesh
