"""One Runge-Kutta step without mesh forces, as the coefficients that a lane kernel reads from its rows.

The step of (20)-(21) with the mesh forces as given numbers is linear, so its coefficients are its answers to unit
starts: a coordinate of 1, a change of 1, the drive, a force of 1 in the first stage. The four stages are gone through
as they stand in the textbook, for all lanes at once; nothing is expanded by hand. A force of a later stage answers as
one of the first does, that many stages later, which is why one start does for all four.

Time is in half steps: with A the acceleration times the square of half the step and V the rate times it,

    Q2 = Q + V, V2 = V + A1;  Q3 = Q + V2, V3 = V + A2;  Q4 = Q + 2·V3, V4 = V + 2·A3;
    Q′ = Q + 2·V + 2/3·(A1 + A2 + A3);  V′ = V + 1/3·(A1 + 2·A2 + 2·A3 + A4).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion.lanes.structure import PER_MESH, U2, U3, Structure, pushes

Array = NDArray[np.float64]
Stages = tuple[Array, Array, Array, Array]


@dataclass(frozen=True)
class Mechanics:
    """What is linear about n lanes, in half steps; every field has the shape (coordinates, n)."""

    stiffness: Array
    """Acceleration that support and shaft take away per displacement of the coordinate itself."""
    damping: Array
    gain: Array
    drive: Array
    """Acceleration by the lane's load."""
    far_stiffness: Array
    """Acceleration that the other end of the shaft takes away; 0 but for u2 and u3."""
    far_damping: Array


def propagator(s: Structure, m: Mechanics) -> dict[str, Array]:
    """Return the linear coefficients of every lane, (n,), by the names of rows in `structure`."""
    rows: dict[str, Array] = {}
    for unit in "qv":
        for start, answers in _unit_starts(s, m, unit):
            for i in start:
                rows |= _linear_rows(s, answers, i, unit.upper())
    rows |= _drive_rows(s, _stages(s, m, push=(m.drive,) * 4))
    for force in s.forces:
        rows |= _force_rows(s, m, force)
    return rows


def _unit_starts(s: Structure, m: Mechanics, unit: str) -> list[tuple[list[int], Stages]]:
    """Return the answers to unit starts, as many at once as do not meet: the ends of the shaft need a turn each."""
    first = [i for i in range(s.coordinates) if not (s.coupled and i == U3)]
    starts = [first, [U3]] if s.coupled else [first]
    found = []
    for start in starts:
        ones = np.zeros_like(m.gain)
        ones[start] = 1.0
        found.append((start, _stages(s, m, q=ones) if unit == "q" else _stages(s, m, v=ones)))
    return found


def _stages(
    s: Structure, m: Mechanics, *, q: Array | None = None, v: Array | None = None, push: tuple[Array, ...] | None = None
) -> Stages:
    """Return the accelerations of the four stages from start q, v with accelerations `push` added stage by stage."""
    zero = np.zeros_like(m.gain)
    q, v = zero if q is None else q, zero if v is None else v
    pushed = (zero,) * 4 if push is None else push
    a1 = pushed[0] - _held(s, m, q, v)
    a2 = pushed[1] - _held(s, m, q + v, v + a1)
    a3 = pushed[2] - _held(s, m, q + v + a1, v + a2)
    a4 = pushed[3] - _held(s, m, q + 2 * (v + a2), v + 2 * a3)
    return a1, a2, a3, a4


def _held(s: Structure, m: Mechanics, q: Array, v: Array) -> Array:
    """Return the acceleration that supports and shaft take away."""
    taken = m.stiffness * q + m.damping * v
    if s.coupled:
        for i, far in ((U2, U3), (U3, U2)):
            taken[i] += m.far_stiffness[i] * q[far] + m.far_damping[i] * v[far]
    return taken


def _gains(a: Stages) -> tuple[Array, Array]:
    """Return what a step gives q beyond q + 2·v, and v."""
    a1, a2, a3, a4 = a
    return 2 / 3 * (a1 + a2 + a3), (a1 + 2 * a2 + 2 * a3 + a4) / 3


def _linear_rows(s: Structure, a: Stages, i: int, unit: str) -> dict[str, Array]:
    """Return what a unit start in coordinate i does to itself and to what it is linked with."""
    to_q, to_v = _gains(a)
    rows: dict[str, Array] = {}
    for m in s.linked(i):
        rows |= {f"Q{m}_OF_{unit}{i}": to_q[m], f"V{m}_OF_{unit}{i}": to_v[m]}
        rows |= {f"A{n}_{m // PER_MESH}_OF_{unit}{i}": a[n - 1][m] for n in (1, 2, 3)}
    return rows


def _drive_rows(s: Structure, a: Stages) -> dict[str, Array]:
    to_q, to_v = _gains(a)
    rows = {f"A{n}_{j}_DRIVE": _closing(a[n - 1], j) for n in (1, 2, 3) for j in range(s.meshes)}
    for i in range(s.coordinates):
        if s.is_driven(i):
            rows |= {f"Q{i}_DRIVE": to_q[i], f"V{i}_DRIVE": to_v[i]}
    return rows


def _force_rows(s: Structure, m: Mechanics, force: str) -> dict[str, Array]:
    """Return what a unit of `force` in stage 1 does: to each coordinate, and to the closing of each mesh."""
    mine = [i for i in range(s.coordinates) if s.force_on(i) == force]
    push = np.zeros_like(m.gain)
    push[mine] = -m.gain[mine]
    a = _stages(s, m, push=(push, np.zeros_like(push), np.zeros_like(push), np.zeros_like(push)))
    rows = {f"P{n}_{j}_{force}": _closing(a[n], j) for j in range(s.meshes) for n in pushes(s, j, force)}
    _, to_v = _gains(a)
    for i in sorted({far for near in mine for far in s.linked(near)}):
        rows[f"V{i}_FIRST_{force}"] = to_v[i]
        reach = a[0][i], a[0][i] + a[1][i], a[0][i] + a[1][i] + a[2][i]
        rows |= {f"R{n}_{i}_{force}": 2 / 3 * reach[3 - n] for n in (1, 2, 3)}
    return rows


def _closing(a: Array, mesh: int) -> Array:
    own = a[PER_MESH * mesh : PER_MESH * (mesh + 1)]
    return np.asarray((own[0] + own[1]) + (own[2] + own[3]))
