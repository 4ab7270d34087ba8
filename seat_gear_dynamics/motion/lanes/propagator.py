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

from seat_gear_dynamics.motion.lanes.structure import PER_MESH, Structure

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
    zero, one = np.zeros_like(m.gain), np.ones_like(m.gain)
    rows: dict[str, Array] = {}
    for unit, answers in (("Q", _stages(m, q=one, v=zero)), ("V", _stages(m, q=zero, v=one))):
        for j in range(s.meshes):
            for i in s.mapped(j):
                rows |= _linear_rows(answers, i, unit)
    rows |= _drive_rows(s, _stages(m, q=zero, v=zero, push=(m.drive,) * 4))
    for force in s.forces:
        rows |= _force_rows(s, m, force)
    for i, far in s.ends:
        rows |= _end_rows(s, m, i, far)
    return rows


def _stages(m: Mechanics, *, q: Array, v: Array, push: tuple[Array, ...] | None = None) -> Stages:
    """Return the accelerations of the four stages from start q, v with accelerations `push` added stage by stage.

    Every coordinate goes by itself, so that one call answers for unit starts of all of them.
    """
    pushed = (np.zeros_like(q),) * 4 if push is None else push
    a1 = pushed[0] - _held(m, q, v)
    a2 = pushed[1] - _held(m, q + v, v + a1)
    a3 = pushed[2] - _held(m, q + v + a1, v + a2)
    a4 = pushed[3] - _held(m, q + 2 * (v + a2), v + 2 * a3)
    return a1, a2, a3, a4


def _held(m: Mechanics, q: Array, v: Array) -> Array:
    """Return the acceleration that supports take away."""
    return m.stiffness * q + m.damping * v


def _gains(a: Stages) -> tuple[Array, Array]:
    """Return what a step gives q beyond q + 2·v, and v."""
    a1, a2, a3, a4 = a
    return 2 / 3 * (a1 + a2 + a3), (a1 + 2 * a2 + 2 * a3 + a4) / 3


def _linear_rows(a: Stages, i: int, unit: str) -> dict[str, Array]:
    """Return what a unit start in coordinate i does to itself and to the closing of its mesh."""
    to_q, to_v = _gains(a)
    rows = {f"Q{i}_OF_{unit}{i}": to_q[i], f"V{i}_OF_{unit}{i}": to_v[i]}
    return rows | {f"A{n}_{i // PER_MESH}_OF_{unit}{i}": a[n - 1][i] for n in (1, 2, 3)}


def _drive_rows(s: Structure, a: Stages) -> dict[str, Array]:
    to_q, to_v = _gains(a)
    rows = {f"A{n}_{j}_DRIVE": _closing(s, a[n - 1], j) for n in (1, 2, 3) for j in range(s.meshes)}
    for i in range(s.coordinates):
        if s.is_driven(i):
            rows |= {f"Q{i}_DRIVE": to_q[i], f"V{i}_DRIVE": to_v[i]}
    return rows


def _force_rows(s: Structure, m: Mechanics, force: str) -> dict[str, Array]:
    """Return what a unit of `force` in stage 1 does: to each coordinate, and to the closing of its mesh."""
    mesh = int(force[1])
    mine = [i for i in s.mapped(mesh) if s.force_on(i) == force]
    push, none = np.zeros_like(m.gain), np.zeros_like(m.gain)
    push[mine] = -m.gain[mine]
    a = _stages(m, q=none, v=none, push=(push, none, none, none))
    rows = {f"P{n}_{mesh}_{force}": _closing(s, a[n], mesh) for n in (0, 1, 2)}
    end = s.end(mesh)
    if end is not None and s.force_on(end) == force:
        rows[f"P0_{mesh}_{force}"] = rows[f"P0_{mesh}_{force}"] - m.gain[end]
    _, to_v = _gains(a)
    for i in mine:
        rows[f"V{i}_FIRST_{force}"] = to_v[i]
        reach = a[0][i], a[0][i] + a[1][i], a[0][i] + a[1][i] + a[2][i]
        rows |= {f"R{n}_{i}_{force}": 2 / 3 * reach[3 - n] for n in (1, 2, 3)}
    return rows


def _end_rows(s: Structure, m: Mechanics, i: int, far: int) -> dict[str, Array]:
    """Return what accelerates an end of the shaft: its stages are gone through in the kernel itself."""
    return {
        f"E{i}_OF_Q{i}": -m.stiffness[i],
        f"E{i}_OF_V{i}": -m.damping[i],
        f"E{i}_OF_Q{far}": -m.far_stiffness[i],
        f"E{i}_OF_V{far}": -m.far_damping[i],
        f"E{i}_OF_{s.force_on(i)}": -m.gain[i],
    }


def _closing(s: Structure, a: Array, mesh: int) -> Array:
    own = [a[i] for i in s.mapped(mesh)]
    return np.asarray((own[0] + own[1]) + (own[2] + own[3] if len(own) == PER_MESH else own[2]))
