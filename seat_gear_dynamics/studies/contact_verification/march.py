"""The compiled march of the rigid train: a stiff integrator with error control, sampled as ADAMS writes its output.

ROS34PW2 of Rang & Angermann 2005, doi:10.1007/s10543-005-0035-y: linearly implicit, four stages, order 3 with an
error estimate of order 2, L-stable, and of that order whatever approximates the Jacobian. IMPACT's damping makes the
equations stiff (rates above 1e6 per second), where an explicit method would need some 1e7 steps for Table 2's 5 s.
Across jumps of the force (a tip that touches with `corner` off) steps shrink until the jump no more matters.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.studies.contact_verification.rigid_train import (
    Drive,
    Train,
    accelerations,
    jacobian,
    mesh_loads,
)

Array = NDArray[np.float64]

# The compiled march contains the law, the gap and the equations. Numba's cache sees changes of a function's own file
# alone, so after a change in one of theirs the cache files beside this one have to go.

FINISHED, DIVERGED = 0, 1
SAMPLE_COLUMNS = ("time", "first_force", "second_force", "back_force", "input_torque")
WINDOW_COLUMNS = ("duration", "sum", "sum_of_squares", "minimum", "maximum", "separated")

GAMMA = 0.43586652150845900
ALPHA = np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [0.87173304301691801, 0.0, 0.0, 0.0],
        [0.84457060015369423, -0.11299064236484185, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]
)
COUPLING = np.array(
    [
        [GAMMA, 0.0, 0.0, 0.0],
        [-0.87173304301691801, GAMMA, 0.0, 0.0],
        [-0.90338057013044082, 0.054180672388095326, GAMMA, 0.0],
        [0.24212380706095346, -1.2232505839045147, 0.54526025533510214, GAMMA],
    ]
)
WEIGHTS = np.array([0.24212380706095346, -1.2232505839045147, 1.5452602553351020, 0.43586652150845900])
EMBEDDED = np.array([0.37810903145819369, -0.096042292212423178, 0.5, 0.2179332607542295])

_LEAST_STEP = 1e-10  # s; a step this short over a jump of the force moves nothing by more than the tolerance
_BEYOND = 1.0  # rad that s2-s3 and s4 may lead or lag: more than a tooth, so the solution is lost


class Accuracy(NamedTuple):
    """What error a step may make."""

    arc: float
    """On a base-circle arc, m."""
    speed: float
    """On its rate, m/s."""
    longest_step: float
    """s"""


@njit(cache=True, nogil=True, error_model="numpy")
def try_step(train: Train, drive: Drive, time: float, h: float, y: Array, result: Array, error: Array) -> None:
    """Fill `result` with the state after a step `h`, s, from `y`, and `error` with its estimated error, shape (4,)."""
    stiffness, damping = np.empty((2, 2)), np.empty((2, 2))
    first, second = mesh_loads(train, drive, time, y)
    jacobian(train, first, second, stiffness, damping)
    g = h * GAMMA
    # (I − g·J) with J = [[0, I], [A, B]] leaves two equations for the speeds: (I − g·B − g²·A)·w = b + g·A·a.
    m00 = 1.0 - g * damping[0, 0] - g * g * stiffness[0, 0]
    m01 = -g * damping[0, 1] - g * g * stiffness[0, 1]
    m10 = -g * damping[1, 0] - g * g * stiffness[1, 0]
    m11 = 1.0 - g * damping[1, 1] - g * g * stiffness[1, 1]
    determinant = m00 * m11 - m01 * m10
    k = np.zeros((4, 4))
    at, coupled = np.empty(4), np.empty(4)
    for i in range(4):
        moved = 0.0
        for n in range(4):
            at[n], coupled[n] = y[n], 0.0
            for j in range(i):
                at[n] += ALPHA[i, j] * k[j, n]
                coupled[n] += COUPLING[i, j] * k[j, n]
        for j in range(i):
            moved += ALPHA[i, j]
        middle, output = accelerations(train, drive, time + moved * h, at)
        a0, a1 = h * (at[2] + coupled[2]), h * (at[3] + coupled[3])
        p0, p1 = h * coupled[0] + g * a0, h * coupled[1] + g * a1
        v0, v1 = h * coupled[2], h * coupled[3]
        b0 = h * middle + stiffness[0, 0] * p0 + stiffness[0, 1] * p1 + damping[0, 0] * v0 + damping[0, 1] * v1
        b1 = h * output + stiffness[1, 0] * p0 + stiffness[1, 1] * p1 + damping[1, 0] * v0 + damping[1, 1] * v1
        w0, w1 = (b0 * m11 - m01 * b1) / determinant, (m00 * b1 - m10 * b0) / determinant
        k[i, 0], k[i, 1], k[i, 2], k[i, 3] = a0 + g * w0, a1 + g * w1, w0, w1
    for n in range(4):
        result[n], error[n] = y[n], 0.0
        for i in range(4):
            result[n] += WEIGHTS[i] * k[i, n]
            error[n] += (WEIGHTS[i] - EMBEDDED[i]) * k[i, n]


@njit(cache=True, nogil=True, error_model="numpy")
def _relative_error(train: Train, accuracy: Accuracy, error: Array) -> float:
    """Return the largest of the errors over what is allowed."""
    middle, output = train.first.driven_radius, train.second.driven_radius
    worst = max(abs(error[0]) * middle, abs(error[1]) * output) / accuracy.arc
    return float(max(worst, max(abs(error[2]) * middle, abs(error[3]) * output) / accuracy.speed))


@njit(cache=True, nogil=True, error_model="numpy")
def _count(windows: Array, h: float, before: Array, after: Array) -> None:
    """Add a step of `h` seconds between forces `before` and `after`, (2,), to the windows, (2, 6)."""
    for j in range(2):
        a, b = before[j], after[j]
        windows[j, 0] += h
        windows[j, 1] += h * (a + b) / 2
        windows[j, 2] += h * (a * a + b * b) / 2
        windows[j, 3] = min(windows[j, 3], a, b)
        windows[j, 4] = max(windows[j, 4], a, b)
        windows[j, 5] += h * (0.5 * (a <= 0.0) + 0.5 * (b <= 0.0))


@njit(cache=True, nogil=True, error_model="numpy")
def march(
    train: Train, drive: Drive, accuracy: Accuracy, y: Array, clock: Array, samples: Array, windows: Array
) -> int:
    """Integrate from clock[0] to samples[-1, 0], in s; return FINISHED or DIVERGED.

    In and out: y (4,); clock (2,) = time and the step to try next; windows (2, 6), over every step made, of the driving
    flanks' force of P12 and P34, in the order of WINDOW_COLUMNS. samples (n, 5): the times come in column 0, rising,
    and the values in the order of SAMPLE_COLUMNS go out.
    """
    result, error = np.empty(4), np.empty(4)
    before, after = np.empty(2), np.empty(2)
    first, second = mesh_loads(train, drive, clock[0], y)
    before[0], before[1] = first.force, second.force
    for row in range(samples.shape[0]):
        end = samples[row, 0]
        while clock[0] < end:
            h = min(clock[1], accuracy.longest_step)
            last = clock[0] + h >= end - _LEAST_STEP
            if last:
                h = end - clock[0]
            try_step(train, drive, clock[0], h, y, result, error)
            worst = _relative_error(train, accuracy, error)
            growth = 0.2 if not isfinite(worst) else min(4.0, max(0.2, 0.9 * (worst + 1e-9) ** (-1.0 / 3.0)))
            if not worst <= 1.0 and h > _LEAST_STEP:
                clock[1] = max(h * growth, _LEAST_STEP)
                continue
            if not last or growth < 1.0:
                clock[1] = max(h * growth, _LEAST_STEP)
            clock[0] = end if last else clock[0] + h
            for n in range(4):
                y[n] = result[n]
            first, second = mesh_loads(train, drive, clock[0], y)
            after[0], after[1] = first.force, second.force
            _count(windows, h, before, after)
            before[0], before[1] = after[0], after[1]
            if not abs(y[0]) + abs(y[1]) < _BEYOND:
                return DIVERGED
        samples[row, 1], samples[row, 2], samples[row, 3] = first.force, second.force, first.back_force
        samples[row, 4] = first.driver_torque
    return FINISHED
