"""Explicit Runge-Kutta steps: the tableaux, and one compiled step for all of them.

Every tableau here ends with a stage at the new state, so that a step knows contact and rate of closing where it ends,
and the next step begins with that stage instead of an evaluation.
"""

from math import inf, isfinite
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.motion.integrators.field import Field, rates

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Tableau(NamedTuple):
    """One method; s stages, the last at the new state."""

    order: int
    stages: Array
    """a of Butcher's tableau, (s, s); its last row holds the weights b."""
    nodes: Array
    """c, (s,)."""
    error: Array
    """Weights b less those of the embedded method, (s,); zeros where there is none."""
    between: Array
    """Weights of the stages inside the step as polynomials of its share θ: coefficient of θ^(d+1), (s, degree)."""


def _tableau(order: int, rows: list[list[float]], error: list[float], between: list[list[float]]) -> Tableau:
    stages = np.zeros((len(rows), len(rows)))
    for i, row in enumerate(rows):
        stages[i, : len(row)] = row
    return Tableau(order, stages, stages.sum(axis=1), np.array(error), np.array(between))


RUNGE_KUTTA_4 = _tableau(
    4,
    [[], [1 / 2], [0, 1 / 2], [0, 0, 1], [1 / 6, 1 / 3, 1 / 3, 1 / 6]],
    [0.0] * 5,
    [[1, -3 / 2, 2 / 3], [0, 1, -2 / 3], [0, 1, -2 / 3], [0, -1 / 2, 2 / 3], [0, 0, 0]],
)
"""(20)-(21) with the factor 1/6 that (20) lacks; inside the step of third order (Hairer et al. 1993, II.6)."""

DORMAND_PRINCE = _tableau(
    5,
    [
        [],
        [1 / 5],
        [3 / 40, 9 / 40],
        [44 / 45, -56 / 15, 32 / 9],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ],
    [71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40],
    [
        [1, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432],
        [0, 0, 0, 0],
        [0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799],
        [0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072],
        [0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632],
        [0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844],
        [0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423],
    ],
)
"""The 5(4) pair of Dormand & Prince (1980), inside the step the fourth order of Shampine (1986)."""


@njit(error_model="numpy")
def step(
    t: float,
    h: float,
    rows: Array,
    count: int,
    k: Array,
    end: Array,
    tableau: Tableau,
    branches: Index,
    field: Field,
    look: bool = True,
) -> None:
    """Put the first `count` rows after one step of length h into end; k, (s, rows, 24), begins with its first stage.

    The last stage, left in k and in `field.mesh`, is the right-hand side at the end of the step; without `look` it is
    left out.
    """
    last = tableau.nodes.shape[0] - 1
    for s in range(1, tableau.nodes.shape[0]):
        for r in range(count):
            for i in range(24):
                end[r, i] = rows[r, i]
        for stage in range(s):
            weight = h * tableau.stages[s, stage]
            if weight != 0.0:
                for r in range(count):
                    for i in range(24):
                        end[r, i] += weight * k[stage, r, i]
        if look or s < last:
            rates(t + tableau.nodes[s] * h, end, k[s], count, branches, field)


@njit(error_model="numpy")
def advance(rows: Array, count: int, k: Array, end: Array) -> None:
    """Go to the end of a step: its last stage becomes the next one's first."""
    last = k.shape[0] - 1
    for r in range(count):
        for i in range(24):
            rows[r, i] = end[r, i]
            k[0, r, i] = k[last, r, i]


@njit(error_model="numpy")
def scaled_error(h: float, rows: Array, k: Array, end: Array, tableau: Tableau, tolerance: float) -> float:
    """Return the state's largest estimated error over tolerance·(1 + |state|); it passes up to 1."""
    worst = 0.0
    for i in range(24):
        error = 0.0
        for s in range(tableau.nodes.shape[0]):
            error += tableau.error[s] * k[s, 0, i]
        if not isfinite(error):
            return inf
        worst = max(worst, abs(h * error) / (tolerance * (1.0 + max(abs(rows[0, i]), abs(end[0, i])))))
    return worst
