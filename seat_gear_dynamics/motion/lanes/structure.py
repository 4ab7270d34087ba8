"""What a lane kernel consists of: its coordinates, the forces that act on them, and the rows of a block in memory.

Where a gear's supports in x and y are equal, motion across the line of action is pushed by nothing and pushes nothing.
Two coordinates a gear are left, exactly: p, the motion along the line of action counted as it closes the mesh, and
u = r·θ. Their order is p1, u1, p2, u2, p3, u3, p4, u4; every one of them closes its mesh with weight 1.

A block is one flat array of rows, each row one number for every lane: states first, then coefficients, then scratch
and statistics. Row names say what they hold:

- Q3, V3: coordinate 3 and its change in half a step; ZQ3, ZV3: those of the tangent.
- Q3_OF_V5: what V5 adds to Q3 in a step without mesh forces, beyond the exact Q3 + 2·V3; Q3_DRIVE: what torque adds.
- R1_3_F0, R2_, R3_: what force F0 of the first, second, third stage adds to Q3; V3_FIRST_F0: of the first stage to V3.
- A1_0_OF_Q3, A2_, A3_: what Q3 adds to the closing acceleration of mesh 0 in stages 1, 2, 3; A1_0_DRIVE: what torque.
- P0_0_F1, P1_, P2_: what force F1 adds to the closing acceleration of mesh 0 in its own and in the next two stages.
- DAMPING0, UPPER0, LOWER0: damping and the ends of the backlash of mesh 0.
- F0_1 … F0_4, ZF0_1 …: scratch between the two loops of a step.
- SUM0, SQUARES0, LEAST0, MOST0, APART0: statistics of the force of mesh 0.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.coefficients import coefficients

PER_MESH = 4
"""Reduced coordinates of a mesh: p and u of its driver, p and u of its driven gear."""
U2, U3 = 3, 5
STAGES = (1, 2, 3, 4)
STATISTICS = ("SUM", "SQUARES", "LEAST", "MOST", "APART")
"""Rows of statistics of each mesh, in the order of kernel.WINDOW_COLUMNS after the duration."""


@dataclass(frozen=True)
class Structure:
    """Which terms a kernel has; everything else is a number in a row."""

    meshes: int
    """1: P12 alone; 2: P12 and P34."""
    coupled: bool
    """Whether the shaft of s2 and s3 couples the meshes."""
    backlash_in_torsion: bool
    damping_in_contact_only: bool
    tangent: bool
    """Whether a tangent travels with the state: the train's where it is coupled, else P12's."""
    statistics: bool
    """Whether force statistics are taken."""

    @property
    def coordinates(self) -> int:
        """Number of reduced coordinates."""
        return PER_MESH * self.meshes

    @property
    def tangent_meshes(self) -> int:
        """Number of meshes whose tangent is integrated."""
        return (self.meshes if self.coupled else 1) if self.tangent else 0

    @property
    def forces(self) -> tuple[str, ...]:
        """Names of the forces of a stage: F of each mesh, and U where the lines of u carry another."""
        kinds = "F" if self.backlash_in_torsion else "FU"
        return tuple(f"{kind}{mesh}" for mesh in range(self.meshes) for kind in kinds)

    def force_on(self, coordinate: int) -> str:
        """Return the name of the force in the line of `coordinate`."""
        kind = "F" if self.backlash_in_torsion or coordinate % 2 == 0 else "U"
        return f"{kind}{coordinate // PER_MESH}"

    def partner(self, coordinate: int) -> int | None:
        """Return the coordinate at the other end of the shaft, or None."""
        return {U2: U3, U3: U2}.get(coordinate) if self.coupled else None

    def linked(self, coordinate: int) -> tuple[int, ...]:
        """Return the coordinates that act on `coordinate` without any mesh: itself and its partner."""
        partner = self.partner(coordinate)
        return (coordinate,) if partner is None else (coordinate, partner)

    def is_driven(self, coordinate: int) -> bool:
        """Whether a given torque acts on `coordinate`; T2 and T3 are inner torques of a coupled train."""
        return coordinate % 2 == 1 and not (self.coupled and coordinate in (U2, U3))

    @cached_property
    def full(self) -> "Structure":
        """The same with tangent and statistics: its rows hold those of every kernel of these equations."""
        return replace(self, tangent=True, statistics=True)

    @cached_property
    def row(self) -> dict[str, int]:
        """Index of each row of a block by its name; the same with and without tangent and statistics."""
        return {name: index for index, name in enumerate(_rows(self.full))}


def structure_of(train: GearTrain, *, meshes: int, tangent: bool = True, statistics: bool = True) -> Structure:
    """Return the structure of `train`'s equations with `meshes` 1 or 2."""
    variant = train.variant
    return Structure(
        meshes,
        train.shaft.couples and meshes == 2,
        variant.backlash_in_torsion,
        variant.damping_in_contact_only,
        tangent,
        statistics,
    )


def supports(train: GearTrain) -> bool:
    """Whether lanes can march `train`: whether motion across the lines of action decouples.

    It does where each gear is held alike in x and y. Every described train is; the test is on its coefficients, so
    that another kind of support falls back on `motion.integrate` instead of giving wrong numbers.
    """
    c = coefficients(train)
    x, y = np.arange(0, 12, 3), np.arange(1, 12, 3)
    alike = [np.allclose(row[x], row[y], rtol=1e-12, atol=0.0) for row in (c.stiffness, c.damping)]
    along = np.allclose(c.reaction[x] * c.direction[y], c.reaction[y] * c.direction[x], rtol=1e-12, atol=0.0)
    unpushed = not (c.drive[x].any() or c.drive[y].any() or c.shaft_direction[x].any() or c.shaft_direction[y].any())
    return bool(all(alike) and along and unpushed)


def _rows(s: Structure) -> list[str]:
    coordinates, meshes = range(s.coordinates), range(s.meshes)
    tangent = range(PER_MESH * s.tangent_meshes)
    rows = [f"{kind}{i}" for kind in "QV" for i in coordinates]
    rows += [f"Z{kind}{i}" for kind in "QV" for i in tangent]
    for i in coordinates:
        rows += [f"{to}{i}_OF_{of}{m}" for to in "QV" for m in s.linked(i) for of in "QV"]
        rows += [f"{to}{i}_DRIVE" for to in "QV" if s.is_driven(i)]
        rows += [f"A{stage}_{i // PER_MESH}_OF_{of}{m}" for stage in (1, 2, 3) for m in s.linked(i) for of in "QV"]
        rows += [f"V{i}_FIRST_{s.force_on(m)}" for m in s.linked(i)]
        rows += [f"R{n}_{i}_{s.force_on(m)}" for m in s.linked(i) for n in (1, 2, 3) if n < 3 or m == i]
    for j in meshes:
        rows += [f"A{stage}_{j}_DRIVE" for stage in (1, 2, 3)]
        rows += [f"P{n}_{j}_{force}" for force in s.forces for n in pushes(s, j, force)]
        rows += [f"DAMPING{j}", f"UPPER{j}", f"LOWER{j}"]
    rows += [f"{force}_{stage}" for force in s.forces for stage in STAGES]
    rows += [f"Z{force}_{stage}" for force in s.forces if int(force[1]) < s.tangent_meshes for stage in STAGES]
    rows += [f"{kind}{j}" for j in meshes for kind in STATISTICS]
    return list(dict.fromkeys(rows))


def pushes(s: Structure, mesh: int, force: str) -> tuple[int, ...]:
    """Return after how many stages `force` is felt in the closing acceleration of `mesh`: 0, 1, 2 or not at all.

    A force of the mesh itself is felt at once; one of the other mesh comes through the shaft a stage later.
    """
    if int(force[1]) == mesh:
        return (0, 1, 2)
    through_shaft = s.coupled and force == s.force_on(U2 if mesh == 1 else U3)
    return (1, 2) if through_shaft else ()
