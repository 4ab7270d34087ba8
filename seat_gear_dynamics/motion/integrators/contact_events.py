"""Where in a step a mesh leaves its branch: both flanks of both meshes, found inside the step and then landed on.

A held branch s in {-1, 0, 1} of a mesh ends where v = σ·δ − offset passes zero from below: for s = ±1 with σ = −s and
offset −b/2 (the flank is left), for s = 0 with σ = ±1 and offset b/2 (a flank is met). Inside a step v and its rate
come from the step's own polynomials of q and q′ and the exact e(t). v is looked at in `PARTS` parts and at every
extremum between (where its rate passes zero), so that a pair of crossings within one part is seen too. What is missed
is a v whose rate passes zero twice within one part, at which the polynomial itself is no longer true. Steps that stay
well away from every flank are not searched.
"""

from math import pi

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.motion.integrators.field import Field, excite
from seat_gear_dynamics.motion.integrators.tableau import Tableau

Array = NDArray[np.float64]
Index = NDArray[np.int64]

PARTS = 8
"""Parts of a step that are looked at one by one."""
_ROUNDING = 2e-14  # of δ, by the size of its terms: some 64 times the spacing of floating-point numbers at 1
_BISECTIONS = 24  # of a part, for a first guess that Newton's method then makes exact


@njit(error_model="numpy")
def resolution(rows: Array, field: Field) -> Array:
    """Return how finely δ of each mesh can be told from rounding at a state, (2,)."""
    fine = np.empty(2)
    for j in range(2):
        size = 1.0 + field.half_backlash[j]
        for i in range(6 * j, 6 * j + 6):
            size += abs(field.equations.direction[i] * rows[0, i])
        fine[j] = _ROUNDING * size
    return fine


@njit(error_model="numpy")
def deflection(j: int, branches: Index, field: Field) -> float:
    """Return δ/b_c of mesh j at the last evaluation, counted from the middle of the backlash."""
    held = branches[j] if abs(branches[j]) == 1 else 0
    return float(field.mesh[j, 0] + held * field.half_backlash[j])


@njit(error_model="numpy")
def look(branches: Index, field: Field, seen: Array) -> None:
    """Fill seen[j] = (δ, δ′) of both meshes at the last evaluation, (2, 2)."""
    for j in range(2):
        seen[j, 0], seen[j, 1] = deflection(j, branches, field), field.mesh[j, 1]


@njit(error_model="numpy")
def far(h: float, begin: Array, end: Array, branches: Index, field: Field) -> bool:
    """Return whether δ of both meshes stays so far from their boundaries in a step that none need be sought.

    The Bézier points of the cubic through δ and δ′ at both ends hold it within them. For what else δ may do they are
    given as much room again on each side as they are apart.
    """
    for j in range(2):
        low = min(begin[j, 0], end[j, 0], begin[j, 0] + h * begin[j, 1] / 3, end[j, 0] - h * end[j, 1] / 3)
        high = max(begin[j, 0], end[j, 0], begin[j, 0] + h * begin[j, 1] / 3, end[j, 0] - h * end[j, 1] / 3)
        room, half = high - low, field.half_backlash[j]
        above, below = low - room > half, high + room < -half
        within = low - room > -half and high + room < half
        if not (within if branches[j] == 0 else (above if branches[j] == 1 else below)):
            return False
    return True


@njit(error_model="numpy")
def settle(branches: Index, fine: Array, field: Field) -> None:
    """Put each mesh on the branch on which it moves on from the last evaluation; at rest on a boundary it is apart."""
    for j in range(2):
        delta, speed, half = deflection(j, branches, field), field.mesh[j, 1], field.half_backlash[j]
        if delta > half + fine[j] or (delta >= half - fine[j] and speed > 0.0):
            branches[j] = 1
        elif delta < -half - fine[j] or (delta <= -half + fine[j] and speed < 0.0):
            branches[j] = -1
        else:
            branches[j] = 0


@njit(error_model="numpy")
def closing(h: float, rows: Array, k: Array, tableau: Tableau, field: Field, polynomial: Array) -> None:
    """Fill the coefficients of w·q (first axis 0) and w·q′ (1) of each mesh by powers of θ, (2, 2, degree + 1)."""
    degree = tableau.between.shape[1]
    polynomial[:] = 0.0
    for j in range(2):
        for i in range(6 * j, 6 * j + 6):
            w = field.equations.direction[i]
            for part in range(2):
                polynomial[part, j, 0] += w * rows[0, i + 12 * part]
                for s in range(tableau.nodes.shape[0]):
                    weight = h * w * k[s, 0, i + 12 * part]
                    for d in range(degree):
                        polynomial[part, j, d + 1] += weight * tableau.between[s, d]


@njit(error_model="numpy")
def inside(theta: float, t: float, h: float, polynomial: Array, field: Field, found: Array) -> None:
    """Fill found[j] = (δ, δ′) of both meshes at the share θ of a step, (2, 2)."""
    excite(t + theta * h, field.excitation, field.row)
    rate = field.excitation.frequency / (2 * pi)
    for j in range(2):
        delta = speed = 0.0
        for d in range(polynomial.shape[2] - 1, -1, -1):
            delta = delta * theta + polynomial[0, j, d]
            speed = speed * theta + polynomial[1, j, d]
        found[j, 0] = delta - field.row[j, 1]
        found[j, 1] = speed - field.row[j, 2] * rate


@njit(error_model="numpy")
def _passage(
    column: int,
    j: int,
    sign: float,
    offset: float,
    low: float,
    high: float,
    t: float,
    h: float,
    polynomial: Array,
    field: Field,
    found: Array,
) -> tuple[float, float]:
    """Bisect where σ·δ − offset (column 0) or σ·δ′ − offset (column 1) rises past zero; return the bracket's ends."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        inside(middle, t, h, polynomial, field, found)
        if sign * found[j, column] - offset <= 0.0:
            low = middle
        else:
            high = middle
    return low, high


@njit(error_model="numpy")
def _first_crossing(
    j: int,
    sign: float,
    offset: float,
    fine: float,
    seen: Array,
    t: float,
    h: float,
    polynomial: Array,
    field: Field,
    found: Array,
) -> tuple[float, float]:
    """Return (a share where v is still below zero, the share of its first crossing); (0, 2) where there is none.

    v counts as passed when it is above the resolution of δ. Between two looks an extremum is looked at as well: a
    maximum may pass and come back, and a minimum is where a crossing must be sought from, as v may start at zero.
    """
    for part in range(seen.shape[0] - 1):
        low, high = part / (seen.shape[0] - 1), (part + 1) / (seen.shape[0] - 1)
        start_rate, end_rate = sign * seen[part, j, 1], sign * seen[part + 1, j, 1]
        passed = sign * seen[part + 1, j, 0] - offset > 2 * fine
        if start_rate > 0.0 >= end_rate or start_rate < 0.0 < end_rate:
            rising = sign if start_rate < 0.0 else -sign
            extremum, _ = _passage(1, j, rising, 0.0, low, high, t, h, polynomial, field, found)
            inside(extremum, t, h, polynomial, field, found)
            value = sign * found[j, 0] - offset
            if start_rate > 0.0 and value > 2 * fine:
                passed, high = True, extremum
            elif start_rate < 0.0:
                low = extremum
        if passed:
            below, above = _passage(0, j, sign, offset, low, high, t, h, polynomial, field, found)
            return low, 0.5 * (below + above)
    return 0.0, 2.0


@njit(error_model="numpy")
def first_change(
    t: float,
    h: float,
    rows: Array,
    k: Array,
    tableau: Tableau,
    branches: Index,
    field: Field,
) -> tuple[int, int, float, float]:
    """Return (mesh, branch it goes to, share of the step just before, share of the step) of the first change.

    The mesh is -1 where no mesh leaves its branch in the step from t to t + h.
    """
    polynomial = np.empty((2, 2, tableau.between.shape[1] + 1))
    seen, found, fine = np.empty((PARTS + 1, 2, 2)), np.empty((2, 2)), resolution(rows, field)
    closing(h, rows, k, tableau, field, polynomial)
    for part in range(PARTS + 1):
        inside(part / PARTS, t, h, polynomial, field, seen[part])
    mesh, target, before, first = -1, 0, 0.0, 2.0
    for j in range(2):
        half = field.half_backlash[j]
        for side in range(-1, 2, 2):
            if branches[j] == -side:
                continue
            sign, offset = (-side, -half) if branches[j] == side else (side, half)
            low, share = _first_crossing(j, float(sign), offset, fine[j], seen, t, h, polynomial, field, found)
            if share < first:
                mesh, target, before, first = j, side - branches[j], low, share
    return mesh, target, before, first
