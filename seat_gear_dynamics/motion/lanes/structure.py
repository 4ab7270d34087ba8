"""What a lane kernel consists of: its coordinates, the forces that act on them, and the rows of a block in memory.

Where a gear's supports in x and y are equal, motion across the line of action is pushed by nothing and pushes nothing.
Two coordinates a gear are left, exactly: p, the motion along the line of action counted as it closes the mesh, and
u = r·θ. Their order is p1, u1, p2, u2, p3, u3, p4, u4; every one of them closes its mesh with weight 1.

A block is one flat array of rows, each row one number for every lane: states first, then coefficients, then scratch
and statistics. Row names say what they hold:

- Q3, V3: coordinate 3 and its change in half a step; ZQ3, ZV3: those of the tangent.
- Q1_OF_V1: what V1 adds to Q1 in a step without mesh forces, beyond the exact Q1 + 2·V1; Q1_DRIVE: what torque adds.
- R1_1_F0, R2_, R3_: what force F0 of the first, second, third stage adds to Q1; V1_FIRST_F0: of the first stage to V1.
- A1_0_OF_Q1, A2_, A3_: what Q1 adds to the closing acceleration of mesh 0 in stages 1, 2, 3; A1_0_DRIVE: what torque.
- P0_0_F0, P1_, P2_: what force F0 adds to the closing acceleration of mesh 0 in its own and in the next two stages.
- E3_OF_Q3, E3_OF_V5, E3_OF_F0: what Q3, V5, F0 add to the acceleration of an end of the shaft, which has no other rows.
- DAMPING0 (DAMPING0_1, … where there is a shaft), UPPER0, LOWER0: damping and the ends of the backlash of mesh 0.
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
        return tuple(force for mesh in range(self.meshes) for force in self.forces_of(mesh))

    def forces_of(self, mesh: int) -> tuple[str, ...]:
        """Return the names of the forces of `mesh`."""
        return (f"F{mesh}",) if self.backlash_in_torsion else (f"F{mesh}", f"U{mesh}")

    def force_on(self, coordinate: int) -> str:
        """Return the name of the force in the line of `coordinate`."""
        kind = "F" if self.backlash_in_torsion or coordinate % 2 == 0 else "U"
        return f"{kind}{coordinate // PER_MESH}"

    def end(self, mesh: int) -> int | None:
        """Return the coordinate of `mesh` at which the shaft ends, or None without a shaft."""
        return (U2, U3)[mesh] if self.coupled else None

    @property
    def ends(self) -> tuple[tuple[int, int], ...]:
        """Both ends of the shaft, each with the other one; empty without a shaft."""
        return ((U2, U3), (U3, U2)) if self.coupled else ()

    def mapped(self, mesh: int) -> tuple[int, ...]:
        """Return the coordinates of `mesh` on which nothing acts but their supports and the forces of the mesh."""
        return tuple(i for i in range(PER_MESH * mesh, PER_MESH * (mesh + 1)) if i != self.end(mesh))

    def damping(self, mesh: int, stage: int) -> str:
        """Return the name of the row with the damping of `mesh` for a stage.

        Without a shaft one row serves all stages. With one there is a copy for each: from stage to stage a compiler
        keeps what it has read, and two meshes leave no register free for that.
        """
        return f"DAMPING{mesh}_{stage}" if self.coupled else f"DAMPING{mesh}"

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
    meshes, tangent = range(s.meshes), range(PER_MESH * s.tangent_meshes)
    rows = [f"{kind}{i}" for kind in "QV" for i in range(s.coordinates)]
    rows += [f"Z{kind}{i}" for kind in "QV" for i in tangent]
    for i in (i for j in meshes for i in s.mapped(j)):
        rows += [f"{to}{i}_OF_{of}{i}" for to in "QV" for of in "QV"]
        rows += [f"{to}{i}_DRIVE" for to in "QV" if s.is_driven(i)]
        rows += [f"A{stage}_{i // PER_MESH}_OF_{of}{i}" for stage in (1, 2, 3) for of in "QV"]
        rows += [f"V{i}_FIRST_{s.force_on(i)}", *(f"R{n}_{i}_{s.force_on(i)}" for n in (1, 2, 3))]
    for i, far in s.ends:
        rows += [f"E{i}_OF_{of}{m}" for m in (i, far) for of in "QV"] + [f"E{i}_OF_{s.force_on(i)}"]
    for j in meshes:
        rows += [f"A{stage}_{j}_DRIVE" for stage in (1, 2, 3)]
        rows += [f"P{n}_{j}_{force}" for force in s.forces_of(j) for n in (0, 1, 2)]
        rows += [*dict.fromkeys(s.damping(j, stage) for stage in STAGES), f"UPPER{j}", f"LOWER{j}"]
    rows += [f"{force}_{stage}" for force in s.forces for stage in STAGES]
    rows += [f"Z{force}_{stage}" for force in s.forces if int(force[1]) < s.tangent_meshes for stage in STAGES]
    rows += [f"{kind}{j}" for j in meshes for kind in STATISTICS]
    return rows
