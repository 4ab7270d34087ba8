"""What happens at a change of contact: the step is made to end on it, the branch changes, the tangent jumps.

The tangent jumps with the force. δ′ itself is continuous, so that in S = I + (f⁺ − f⁻)·nᵀ/(nᵀf⁻ + h_t) of the boundary
h = δ ∓ b/2 the denominator is δ′, and the numerator has the factor δ′ as well, for what jumps is the damper's c·δ′:

    S = I − (contact after − contact before)·c_j·g_j·w_jᵀ        (g_j in the rates, w_j in the coordinates)

where damping acts in contact only, and S = I otherwise. No rate is divided by, so grazing is no special case.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.motion.integrators.contact_events import deflection, resolution, settle
from seat_gear_dynamics.motion.integrators.field import Field, field_of
from seat_gear_dynamics.motion.integrators.run import EVALUATIONS, NOW, Run, note_change
from seat_gear_dynamics.motion.integrators.tableau import Tableau, step
from seat_gear_dynamics.motion.system import System

Array = NDArray[np.float64]

_LANDINGS = 60  # tries: Newton's method takes three, and as many bisections exhaust a floating-point number


def contact_jump(system: System, mesh: int, before: int, after: int) -> Array:
    """Return S, (24, 24), by which a tangent jumps where `mesh` (0 or 1) goes from branch `before` to `after`.

    Branches are -1 and 1 in contact on a flank, 0 apart. The identity but where damping acts in contact only. Source:
    Aizerman & Gantmacher (1958), as in Leine & Nijmeijer (2004), at a boundary whose rate is continuous; the form that
    it takes here is derived in the module.
    """
    rows = np.eye(24)
    jump(rows, 0, mesh, abs(after) - abs(before), field_of(system))
    return np.asarray(rows.T)


@njit(error_model="numpy")
def jump(rows: Array, first: int, mesh: int, gained: int, field: Field) -> None:
    """Apply S to the tangent rows from `first` on; `gained` is contact after less contact before."""
    eq = field.equations
    if not eq.damping_in_contact_only:
        return
    for r in range(first, rows.shape[0]):
        closing = 0.0
        for i in range(6 * mesh, 6 * mesh + 6):
            closing += eq.direction[i] * rows[r, i]
        for i in range(6 * mesh, 6 * mesh + 6):
            rows[r, i + 12] -= gained * eq.mesh_damping[mesh] * eq.reaction[i] * closing


@njit(error_model="numpy")
def land(
    run: Run, field: Field, tableau: Tableau, h: float, mesh: int, target: int, before: float, share: float
) -> tuple[float, bool]:
    """Make the step again so that it ends on the boundary; return its length, and whether the boundary is reached.

    `before` and `share` are the shares of the step between which it lies as the step's polynomial sees it. Where steps
    of the method itself do not pass it, the polynomial was wrong by as much, and the step ends short of it.
    """
    half, fine = field.half_backlash[mesh], resolution(run.rows, field)[mesh]
    sign, offset = (-run.branches[mesh], -half) if target == 0 else (target, half)
    low, high, length, following = before * h, h, share * h, share * h
    for _ in range(_LANDINGS):
        length = following
        step(run.clock[NOW], length, run.rows, 1, run.k, run.end, tableau, run.branches, field)
        run.counts[EVALUATIONS] += tableau.nodes.shape[0] - 1
        value = sign * deflection(mesh, run.branches, field) - offset
        if abs(value) <= fine:
            return length, True
        if value < 0.0:
            low = length
        else:
            high = length
        rate = sign * field.mesh[mesh, 1]
        newton = length - value / rate if rate > 0.0 else low
        following = newton if low < newton < high else 0.5 * (low + high)
        if following <= low or following >= high:
            break
    return length, high < h


@njit(error_model="numpy")
def change(run: Run, field: Field, mesh: int, target: int) -> None:
    """Go to the other branch of `mesh`, and of the other mesh where that changes at the same time."""
    old = run.branches.copy()
    settle(run.branches, resolution(run.rows, field), field)
    if run.branches[mesh] == old[mesh]:
        run.branches[mesh] = target
    for j in range(2):
        if run.branches[j] != old[j]:
            note_change(run, run.clock[NOW], j, old[j], run.branches[j], field.mesh[j, 1])
            jump(run.rows, 1, j, abs(run.branches[j]) - abs(old[j]), field)
