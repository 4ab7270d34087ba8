"""One block of lanes, marched through its run-in and its sampled periods in a thread without Python's lock."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion.lanes.excitation import Grid
from seat_gear_dynamics.motion.lanes.kernel import Kernel
from seat_gear_dynamics.motion.lanes.source import EXCITATION
from seat_gear_dynamics.motion.lanes.structure import STATISTICS

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_ALIGNMENT = 64  # bytes of a cache line: a vector that straddles two lines is loaded at half the speed


@dataclass(frozen=True)
class Run:
    """How far to march, and with which kernels."""

    transient: int
    periods: int
    run_in: Kernel
    sampled: Kernel


@dataclass(frozen=True, eq=False)
class BlockResponse:
    """What a block's lanes did, lane by lane in the first axis; times in `windows` are in steps, not τ."""

    section: Array
    growth: Array
    windows: Array
    state: Array
    """Reduced coordinates and rates of the meshes marched, (width, 2·coordinates)."""
    diverged: Flags


def march_block(table: Array, half_step: Array, grid: Grid, run: Run) -> BlockResponse:
    """March the lanes whose rows are `table`, (rows, width), and whose half steps are `half_step`, (width,)."""
    s, width = run.sampled.structure, run.sampled.width
    lanes = aligned(table.size)
    lanes[:] = table.ravel()
    excitation = np.empty((2 * grid.base + 1) * s.meshes * len(EXCITATION))
    growth, diverged = np.zeros(width), np.zeros(width, dtype=bool)
    sections, growths = np.empty((run.periods, width, 2)), np.zeros((run.periods, width))
    for kernel, begin, periods, taken in (
        (run.run_in, 0, run.transient, slice(0, 0)),
        (run.sampled, run.transient, run.periods, slice(None)),
    ):
        kernel.march(
            lanes,
            excitation,
            *grid.tables,
            grid.runout,
            grid.turning,
            grid.base,
            grid.parts,
            begin,
            periods,
            half_step,
            growth,
            sections[taken],
            growths[taken],
            diverged,
        )
    rows = lanes.reshape(-1, width)
    n = s.coordinates
    state = np.concatenate([rows[:n], rows[n : 2 * n] / half_step]).T
    windows = np.stack([_window(rows, s.row, j, grid.steps * run.periods) for j in range(s.meshes)], axis=1)
    return BlockResponse(sections.swapaxes(0, 1), growths.T, windows, state, diverged)


def _window(rows: Array, row: dict[str, int], mesh: int, steps: int) -> Array:
    columns = [rows[row[f"{kind}{mesh}"]] for kind in STATISTICS]
    return np.stack([np.full(rows.shape[1], float(steps)), *columns], axis=-1)


def aligned(size: int) -> Array:
    """Return room for `size` numbers that begins at a cache line."""
    room = np.empty(size + _ALIGNMENT // 8)
    begin = -room.ctypes.data % _ALIGNMENT // 8
    return room[begin : begin + size]
