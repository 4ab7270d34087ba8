"""What happens to a block of lanes between steps: its excitation laid out, its tangents rescaled, its section taken.

These run once per part of a mesh period, some hundred steps, so they need no vector code; the generated kernel calls
them. All arrays are flat, as the kernel's.
"""

from math import cos, isfinite, log, sin, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

BEYOND = 1e8
"""A mesh deflection of a hundred million b_c is a diverged solution, not a motion."""


@njit(cache=True, error_model="numpy")
def lay_out(
    excitation: Array, first: Array, second: Array, runout: Array, turning: Array, base: int, part: int
) -> None:
    """Fill `excitation`, (2·base + 1, meshes, 3) flat, with the half steps of part number `part` since phase 0.

    first, second: the meshes' tables, (2·n, 3); second is empty for P12 alone. runout, turning: as in `Grid`.
    """
    meshes = 2 if second.shape[0] else 1
    for j in range(meshes):
        table = second if j else first
        at = (2 * base * part) % table.shape[0]
        for half in range(2 * base + 1):
            for k in range(3):
                excitation[(half * meshes + j) * 3 + k] = table[at, k]
            at = at + 1 if at + 1 < table.shape[0] else 0
    gears = runout.shape[0]
    for gear in range(gears):
        angle = runout[gear, 1] + runout[gear, 2] * part
        x, y = runout[gear, 0] * cos(angle), runout[gear, 0] * sin(angle)
        for half in range(2 * base + 1):
            turn_x, turn_y = turning[half, gear], turning[half, gears + gear]
            at = (half * meshes + gear // 2) * 3
            excitation[at + 1] += y * turn_x + x * turn_y
            excitation[at + 2] += runout[gear, 3] * (x * turn_x - y * turn_y)


@njit(cache=True, error_model="numpy")
def rescale(
    lanes: Array, width: int, displacement: int, change: int, count: int, half_step: Array, growth: Array
) -> None:
    """Scale each lane's tangent to length 1 and add the logarithm of what it had grown by to `growth`, (width,).

    The tangent stands in `count` rows from `displacement` on and, in half steps, from `change` on. One that died out
    below the smallest number starts again in another direction; what it lost is unknown.
    """
    for lane in range(width):
        total = 0.0
        for row in range(count):
            q, v = lanes[(displacement + row) * width + lane], lanes[(change + row) * width + lane] / half_step[lane]
            total += q * q + v * v
        norm = sqrt(total)
        if norm > 0.0 and isfinite(norm):
            growth[lane] += log(norm)
            for row in range(count):
                lanes[(displacement + row) * width + lane] /= norm
                lanes[(change + row) * width + lane] /= norm
        else:
            lanes[displacement * width + lane] = 1.0


@njit(cache=True, error_model="numpy")
def closing(lanes: Array, width: int, first: int, lane: int) -> float:
    """Return the sum of a lane's four rows from `first` on: δ without error, or its change in half a step."""
    at = first * width + lane
    return float((lanes[at] + lanes[at + width]) + (lanes[at + 2 * width] + lanes[at + 3 * width]))


@njit(cache=True, error_model="numpy")
def mark_diverged(lanes: Array, width: int, meshes: int, excitation: Array, half: int, diverged: Flags) -> bool:
    """Set `diverged`, (width,), where a lane is out of bounds or no number at a half step; return whether all are."""
    lost = 0
    for lane in range(width):
        reach = 0.0
        for j in range(meshes):
            reach += abs(closing(lanes, width, 4 * j, lane) - excitation[(half * meshes + j) * 3 + 1])
        if not reach < BEYOND:
            diverged[lane] = True
        lost += diverged[lane]
    return lost == width


@njit(cache=True, error_model="numpy")
def take_section(
    lanes: Array, width: int, meshes: int, excitation: Array, base: int, half_step: Array, section: Array
) -> None:
    """Write δ/b_c of P12 and its rate per τ at the end of a part into `section`, (width, 2)."""
    end = 2 * base * meshes * 3
    for lane in range(width):
        section[lane, 0] = closing(lanes, width, 0, lane) - excitation[end + 1]
        rate = closing(lanes, width, 4 * meshes, lane) - excitation[end + 2]
        section[lane, 1] = rate / half_step[lane]
