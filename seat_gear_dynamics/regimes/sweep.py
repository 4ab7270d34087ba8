"""Bifurcation sweeps: one quantity varied, the motion at each value, up, down or each from rest."""

from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion import System
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.regimes.attractors import TOLERANCE, same_motion
from seat_gear_dynamics.regimes.classification import Name, Regime
from seat_gear_dynamics.regimes.points import Answer, Motion, Point, abreast, answers, bare, follow, regime_of
from seat_gear_dynamics.regimes.simulate import MeshForce
from seat_gear_dynamics.regimes.sweep_plan import UNITS as UNITS
from seat_gear_dynamics.regimes.sweep_plan import Begun, Direction, Plan, Quantity
from seat_gear_dynamics.regimes.sweep_plan import Way as Way
from seat_gear_dynamics.regimes.workers import Workers, chosen, ranges

Array = NDArray[np.float64]
Made = TypeVar("Made")


@dataclass(frozen=True, eq=False)
class Row:
    """What the motion is at one value of a sweep."""

    value: float
    """In the sweep's unit."""
    direction: Way
    regime: Regime
    force: MeshForce | None
    """Force of P12, N; None where the motion diverged."""
    section: Array
    """Section points of P12, (periods, 2), units of b_c; (0, 2) where the motion diverged."""
    state: Array | None = None
    """Where the next value starts, (24,); None: at static deflection, as in a cold sweep and after a divergence."""

    def as_dict(self) -> dict[str, Any]:
        """Return the row without its section as plain values, forces in N; None where there is none."""
        force = self.force
        return {
            "value": self.value,
            "regime": self.regime.name,
            "period": self.regime.period,
            "lyapunov": self.regime.lyapunov,
            "contact_loss": force and force.contact_loss,
            "force_min": force and force.min,
            "force_max": force and force.max,
            "force_mean": force and force.mean,
            "force_rms": force and force.rms,
            "direction": self.direction,
            "lyapunov_error": self.regime.lyapunov_error,
        }


@dataclass(frozen=True, eq=False)
class Sweep(Plottable, figure="bifurcation:plot_sweep", table="regimes:sweep_table"):
    """A finished sweep."""

    over: Quantity
    rows: tuple[Row, ...]
    """In the order in which they were found; up and down alternate."""

    def along(self, direction: Way) -> tuple[Row, ...]:
        """Return the rows of one direction by increasing value."""
        return tuple(sorted((row for row in self.rows if row.direction == direction), key=lambda row: row.value))

    @property
    def directions(self) -> tuple[Way, ...]:
        """The directions that the sweep has, of `up`, `down` and `cold`."""
        return tuple(way for way in get_args(Way) if any(row.direction == way for row in self.rows))

    def coexisting(self, *, tolerance: float = TOLERANCE) -> tuple[float, ...]:
        """Return the values at which up and down end on different motions; empty where the sweep is not of both.

        Sections are compared as sets within `tolerance` b_c, see `same_motion`. A value where one of them diverged and
        the other did not counts.
        """
        down = {row.value: row for row in self.along("down")}
        pairs = ((row, down[row.value]) for row in self.along("up") if row.value in down)
        return tuple(first.value for first, second in pairs if differ(first, second, tolerance=tolerance))


def differ(first: Row, second: Row, *, tolerance: float = TOLERANCE) -> bool:
    """Return whether two rows are of different motions; a divergence differs from all but another one."""
    if first.force is None or second.force is None:
        return first.force is not second.force
    return not same_motion(first.section, second.section, tolerance=tolerance)


def sweep(
    system: System,
    *,
    over: Quantity,
    start: float,
    stop: float,
    points: int,
    direction: Direction = "cold",
    transient: int = 600,
    periods: int = 400,
    workers: Workers | int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Sweep:
    """Return the bifurcation sweep of `system` over one quantity; see `Plan` for what to ask, `sweep_rows` for errors.

    `progress` is told (rows done, rows in all).
    """
    plan, found = Plan(over, start, stop, points, direction, transient, periods), []
    for row in sweep_rows(system, plan, workers=workers):
        found.append(row)
        if progress is not None:
            progress(len(found), plan.rows)
    return Sweep(over, tuple(found))


def sweep_rows(
    system: System, plan: Plan, *, workers: Workers | int | None = None, begun: Begun | None = None
) -> Generator[Row, None, None]:
    """Yield the rows of a sweep of `system` as they are found; everything but `plan.over` is as `system` has it.

    Arguments, errors and limits as `sweep_each` has them.
    """
    return sweep_each(system, plan, _itself, workers=workers, begun=begun)


def sweep_each(
    system: System,
    plan: Plan,
    make: Callable[[Row], Made],
    *,
    workers: Workers | int | None = None,
    begun: Begun | None = None,
) -> Generator[Made, None, None]:
    """Yield what `make` makes of each row of a sweep, in the rows' order, as they are found.

    `make` runs where the row was computed and must pickle, so that what it leaves out does not travel. `begun`: go on
    behind these rows. Rows do not depend on `workers` (a number: so many threads of this machine) nor on where a sweep
    was taken up again. A cold sweep is shared out in blocks. Up and down are chains: each block of one waits for the
    one before it, so that two workers at most are busy. Closing the generator ends the sweep. Raises ValueError, at
    once, for impossible ranges and values. Limit: a state is carried by steps, so a step wider than a motion's basin
    leaves it; see `follow` for P34.
    """
    plan.check(system)
    by, begun = chosen(workers), begun or Begun()
    lean = System(bare(system.train), system.operating_point)
    if plan.direction == "cold":
        return _cold(lean, plan, make, by, begun.rows)
    done = {way: (begun.rows + len(plan.ways) - 1 - turn) // len(plan.ways) for turn, way in enumerate(plan.ways)}
    # The direction that is behind has the next turn.
    ways = sorted(plan.ways, key=lambda way: done[way])
    return abreast([_chain(lean, plan, way, make, by, done[way], begun.states.get(way)) for way in ways])


def _cold(
    system: System, plan: Plan, make: Callable[[Row], Made], by: Workers, begin: int
) -> Generator[Made, None, None]:
    blocks = ranges(begin, plan.points, by.share(plan.points - begin))
    with closing(by.compute(partial(_cold_block, system, plan, make), blocks)) as found:
        for block in found:
            yield from block


def _cold_block(system: System, plan: Plan, make: Callable[[Row], Made], numbers: range) -> list[Made]:
    """Return what is made of the rows of a block of a cold sweep."""
    values = plan.values("cold", numbers)
    points = [plan.point(system, value) for value in values]
    rows = _rows(system, "cold", values, points, answers(system.train, points))
    return [make(row) for row in rows]


def _chain(
    system: System,
    plan: Plan,
    way: Way,
    make: Callable[[Row], Made],
    by: Workers,
    begin: int,
    state: Sequence[float] | Array | None,
) -> Generator[Made, None, None]:
    work = partial(_chain_block, system, plan, way, make)
    reached = None if state is None else np.array(state, dtype=float)
    for numbers in ranges(begin, plan.points, by.segment):
        with closing(by.compute(work, [(numbers, reached)])) as found:
            made, reached = next(found)
        yield from made


def _chain_block(
    system: System, plan: Plan, way: Way, make: Callable[[Row], Made], block: tuple[range, Array | None]
) -> tuple[list[Made], Array | None]:
    """Return what is made of the rows of a block that starts at a state, and the state it ends at."""
    numbers, state = block
    values = plan.values(way, numbers)
    points = [plan.point(system, value) for value in values]
    started = [replace(points[0], state=state), *points[1:]]
    rows = list(_rows(system, way, values, points, follow(system.train, started)))
    return [make(row) for row in rows], rows[-1].state


def _rows(
    system: System, way: Way, values: Iterable[float], asked: Iterable[Point], found: Iterable[Answer]
) -> Generator[Row, None, None]:
    unit = system.coefficients.force_unit
    for value, point, answer in zip(values, asked, found, strict=True):
        regime = regime_of(answer)
        if isinstance(answer, Motion):
            static = system.train.static_forces(point.load)[0]
            force = MeshForce.from_window(answer.forces[0], unit, static)
            yield Row(value, way, regime, force, answer.section, None if way == "cold" else answer.state)
        else:
            yield Row(value, way, regime, None, np.empty((0, 2)))


def _itself(row: Row) -> Row:
    return row


def intervals(found: Sweep, regime: Name, *, direction: Way | None = None) -> tuple[tuple[float, float], ...]:
    """Return the ranges of values (lowest, highest) over which the motion is of `regime`, in the sweep's unit.

    Of one `direction`, or of any that the sweep has. A range goes from the first to the last value found so; its ends
    are uncertain by one step of the sweep outwards, and a single value gives a range of no width.
    """
    rows = found.rows if direction is None else found.along(direction)
    holds: dict[float, bool] = {}
    for row in rows:
        holds[row.value] = holds.get(row.value, False) or row.regime.name == regime
    return tuple(stretches(sorted(holds.items())))


def stretches(judged: Iterable[tuple[float, bool]]) -> Generator[tuple[float, float], None, None]:
    """Yield (lowest, highest) of each run of values that hold, of values with a verdict in their order, either way."""
    run: tuple[float, float] | None = None
    for value, held in judged:
        if held:
            run = (value, value) if run is None else (min(run[0], value), max(run[1], value))
        elif run is not None:
            yield run
            run = None
    if run is not None:
        yield run
