"""Many operating points at once: lanes sorted into blocks that share an excitation, blocks shared out over threads.

A lane's numbers depend on its own inputs alone, to the last bit: every lane goes through the same instructions, and
what a block shares (equations, excitation, grid, direction) follows from each lane's own inputs.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from os import cpu_count

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.compiling import Announce
from seat_gear_dynamics.motion.kernel import WINDOW_COLUMNS
from seat_gear_dynamics.motion.lanes.batch import Company, Entry, Index, entry, rows
from seat_gear_dynamics.motion.lanes.block import BlockResponse, Run, march_block
from seat_gear_dynamics.motion.lanes.excitation import Grid, grid
from seat_gear_dynamics.motion.lanes.kernel import WIDTH, kernel
from seat_gear_dynamics.motion.lanes.points import LanePoints, LaneResponse, checked
from seat_gear_dynamics.motion.lanes.reduction import COORDINATES
from seat_gear_dynamics.motion.lanes.structure import Structure
from seat_gear_dynamics.motion.march import LONGEST_STEP
from seat_gear_dynamics.motion.tables import TARGET_STEPS

Array = NDArray[np.float64]


_IN_TIME = np.array([column not in ("minimum", "maximum") for column in WINDOW_COLUMNS])


@dataclass(frozen=True, eq=False)
class _Block:
    """Lanes that are marched together, and where their answers go."""

    structure: Structure
    grid: Grid
    table: Array
    half_step: Array
    places: Index
    """Index of each lane among all that were asked for; fewer than the block is wide where it is padded."""


def respond_lanes(
    train: GearTrain,
    frequency: ArrayLike,
    load: ArrayLike,
    *,
    damping_ratio: ArrayLike | None = None,
    backlash: ArrayLike | None = None,
    state: ArrayLike | None = None,
    transient: int,
    periods: int,
    target_steps: int = TARGET_STEPS,
    longest_step: float = LONGEST_STEP,
    tangent: bool = True,
    statistics: bool = True,
    meshes: int | None = None,
    threads: int | None = None,
    announce: Announce | None = None,
) -> LaneResponse:
    """Return the motions of `train` at many operating points; see `LanePoints` for them and `respond_trains` for more.

    Each lane is what `motion.integrate` gives at its point, but for rounding: the same steps of the same equations.
    """
    points = LanePoints(frequency, load, damping_ratio, backlash, state)
    return respond_trains(
        [(train, points)],
        transient=transient,
        periods=periods,
        target_steps=target_steps,
        longest_step=longest_step,
        tangent=tangent,
        statistics=statistics,
        meshes=meshes,
        threads=threads,
        announce=announce,
    )[0]


def respond_trains(
    asked: Sequence[tuple[GearTrain, LanePoints]],
    *,
    transient: int,
    periods: int,
    target_steps: int = TARGET_STEPS,
    longest_step: float = LONGEST_STEP,
    tangent: bool = True,
    statistics: bool = True,
    meshes: int | None = None,
    threads: int | None = None,
    announce: Announce | None = None,
) -> list[LaneResponse]:
    """Return the motions of several trains, each at its operating points, in the order of `asked`.

    transient, periods: mesh periods of P12 run in and sampled. target_steps, longest_step: of the grid, as in
    `motion.integrate`. meshes: 1 for P12 alone, 2 for the whole train, None for as many as a shaft couples. threads:
    default as many as processors. announce: gets a sentence before a kernel is compiled, which takes some seconds once
    per machine.

    Lanes share blocks wherever their excitation is the same to the last bit: any points of one train, and trains that
    differ in masses, supports, dampings, backlash or load scale only. Trains of other stiffness shape or transmission
    error get blocks of their own, which are then padded: give each some `kernel.WIDTH` points if you can.

    Results depend neither on the number of lanes nor on their order, company or threads, to the last bit. They are
    those of `motion.integrate` up to rounding, so that a chaotic motion parts from its own after some tens of periods.
    A lane that diverges, or starts at no number, is told by `diverged`; bounds are looked at each part of a period.

    Raises ValueError for impossible points or numbers, for a train that `structure.supports` refuses, and for
    frequencies below the slowest grid.
    """
    if transient < 0 or periods < 1:
        raise ValueError(f"Asked for {transient} transient and {periods} sampled periods; expected at least 0 and 1.")
    workers = (cpu_count() or 1) if threads is None else threads
    if workers < 1:
        raise ValueError(f"Asked for {workers} threads, expected at least 1.")
    entries = [
        entry(train, checked(points), meshes=meshes, target_steps=target_steps, longest_step=longest_step)
        for train, points in asked
    ]
    blocks = _blocks(entries)
    announce_once = None if announce is None else cache(announce)
    runs = {
        structure: _run(structure, transient, periods, tangent, statistics, announce_once)
        for structure in {block.structure for block in blocks}
    }
    answers = _Answers(entries, periods)

    def march(block: _Block) -> None:
        answers.take(block, march_block(block.table, block.half_step, block.grid, runs[block.structure]))

    if workers == 1 or len(blocks) == 1:
        for block in blocks:
            march(block)
    else:
        with ThreadPoolExecutor(min(workers, max(1, len(blocks)))) as pool:
            list(pool.map(march, blocks))
    return answers.of_entries(entries, tangent=tangent, statistics=statistics)


def _run(
    structure: Structure, transient: int, periods: int, tangent: bool, statistics: bool, announce: Announce | None
) -> Run:
    sampled = kernel(replace(structure, tangent=tangent, statistics=statistics), announce=announce)
    if not (transient and statistics):
        return Run(transient, periods, sampled, sampled)
    run_in = kernel(replace(structure, tangent=tangent, statistics=False), announce=announce)
    return Run(transient, periods, run_in, sampled)


def _blocks(entries: Sequence[Entry]) -> list[_Block]:
    """Return all lanes in blocks, those of the finest grids first: they take longest."""
    offsets = np.cumsum([0, *(len(e.half_step) for e in entries)])
    members: dict[Company, list[tuple[Entry, Index, Index]]] = {}
    for e, offset in zip(entries, offsets[:-1], strict=True):
        for company, lanes in e.companies():
            members.setdefault(company, []).append((e, lanes, offset + lanes))
    blocks = []
    for company in sorted(members, key=lambda c: -c.level):
        table, half_step = rows(company.structure, [(e, lanes) for e, lanes, _ in members[company]])
        places = np.concatenate([own for _, _, own in members[company]])
        shared = grid(company.excitation, company.level, company.direction)
        for begin in range(0, len(places), WIDTH):
            # The last block is filled up with its last lane, which is then computed several times over.
            columns = np.minimum(np.arange(begin, begin + WIDTH), len(places) - 1)
            own = places[begin : begin + WIDTH]
            blocks.append(_Block(company.structure, shared, table[:, columns], half_step[columns], own))
    return blocks


class _Answers:
    """The answers of all lanes of all entries, filled block by block; each block writes its own lanes only."""

    def __init__(self, entries: Sequence[Entry], periods: int) -> None:
        count = sum(len(e.half_step) for e in entries)
        self._section = np.empty((count, periods, 2))
        self._growth = np.empty((count, periods))
        self._windows = np.empty((count, 2, len(WINDOW_COLUMNS)))
        self._state = np.concatenate([np.zeros((0, 2 * COORDINATES)), *(e.start for e in entries)])
        self._diverged = np.zeros(count, dtype=bool)

    def take(self, block: _Block, found: BlockResponse) -> None:
        """Store what a block's lanes did, its windows in τ."""
        own, n = block.places, len(block.places)
        meshes, coordinates = block.structure.meshes, block.structure.coordinates
        self._section[own], self._growth[own] = found.section[:n], found.growth[:n]
        step = np.where(_IN_TIME, 2 * block.half_step[:n, None], 1.0)
        self._windows[own, :meshes] = found.windows[:n] * step[:, None, :]
        self._state[own, :coordinates] = found.state[:n, :coordinates]
        self._state[own, COORDINATES : COORDINATES + coordinates] = found.state[:n, coordinates:]
        self._diverged[own] = found.diverged[:n]

    def of_entries(self, entries: Sequence[Entry], *, tangent: bool, statistics: bool) -> list[LaneResponse]:
        """Return the answers entry by entry, NaN where there is none."""
        for values in (self._section, self._growth, self._windows, self._state):
            values[self._diverged] = np.nan
        if not tangent:
            self._growth[:] = np.nan
        if not statistics:
            self._windows[:] = np.nan
        responses, begin = [], 0
        for e in entries:
            own = slice(begin, begin + len(e.half_step))
            windows = self._windows[own, : e.structure.meshes]
            state = e.expand(self._state[own])
            responses.append(LaneResponse(self._section[own], self._growth[own], windows, state, self._diverged[own]))
            begin = own.stop
        return responses
