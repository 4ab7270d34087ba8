"""The nodes of a regime map: what the motion is at each of a grid of speeds and loads, found in blocks."""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes.classification import Name, Regime
from seat_gear_dynamics.regimes.points import Answer, Diverged, Point, answers, bare, increasing, regime_of
from seat_gear_dynamics.regimes.workers import Workers, chosen, ranges

Array = NDArray[np.float64]
Nodes = NDArray[np.void]
Judged = TypeVar("Judged")

NAMES: tuple[Name, ...] = ("periodic", "quasi-periodic", "chaotic", "undecided")
"""Regimes by their code in a map."""
NODE = np.dtype(
    [
        ("codes", np.int64),
        ("period", np.int64),
        ("lyapunov", np.float64),
        ("contact_loss", np.float64),
        ("force_max", np.float64),
        ("chaos", np.float64),
    ]
)
"""What is known of one node: the names of a map's columns, in its order."""


def chaos_weight(regime: Regime, *, diverged: bool) -> float:
    """Return what a node adds to the probability of chaos: 1 for chaos and for a divergence, which is worse.

    An undecided motion whose exponent leans to chaos counts half; everything else is calm.
    """
    if diverged or regime.name == "chaotic":
        return 1.0
    return 0.5 if regime.leans_chaotic else 0.0


@dataclass(frozen=True, eq=False)
class MapGrid:
    """The nodes of a map, speeds of the first load first, and how long to look at each.

    Raises ValueError unless speeds and loads increase, and there are two positive speeds at least: bands lie between
    speeds.
    """

    speeds: Array
    """rad/s of s1."""
    loads: Array
    """T4, N·m."""
    transient: int = 400
    """Mesh periods run in."""
    periods: int = 200
    """Mesh periods sampled."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "speeds", increasing("speeds", self.speeds, least=0.0, unit="rad/s"))
        if len(self.speeds) < 2:
            raise ValueError("The map has one speed, expected at least two: bands lie between speeds.")
        object.__setattr__(self, "loads", increasing("loads", self.loads, least=-np.inf, unit="N·m"))
        Point(1.0, 0.0, transient=self.transient, periods=self.periods)  # refuses impossible numbers

    @property
    def shape(self) -> tuple[int, int]:
        """(loads, speeds)."""
        return len(self.loads), len(self.speeds)

    @property
    def nodes(self) -> int:
        """How many nodes there are."""
        return len(self.loads) * len(self.speeds)


def map_nodes(
    train: GearTrain, grid: MapGrid, *, workers: Workers | int | None = None, begin: int = 0
) -> Generator[Nodes, None, None]:
    """Yield what is found at the nodes of `grid`, in blocks of NODE as they are ready.

    `workers`: who computes, a number: so many threads of this machine. `begin`: how many nodes to leave out, which an
    earlier run has. Nodes depend on none of these.
    """
    return _on_grid(_nodes, train, grid, chosen(workers), begin)


def map_weights(
    train: GearTrain, grid: MapGrid, *, workers: Workers | int | None = None, begin: int = 0
) -> Generator[Array, None, None]:
    """Yield what the nodes add to the probability of chaos, see `chaos_weight`, in blocks; arguments as `map_nodes`."""
    return _on_grid(_weights, train, grid, chosen(workers), begin)


def _on_grid(
    judge: Callable[[System, list[Answer]], Judged], train: GearTrain, grid: MapGrid, by: Workers, begin: int
) -> Generator[Judged, None, None]:
    drives = (_drives(grid.speeds, grid.loads, own) for own in ranges(begin, grid.nodes, by.share(grid.nodes - begin)))
    return by.compute(partial(_block, judge, System(bare(train)), grid.transient, grid.periods), drives)


def _drives(speeds: Array, loads: Array, numbers: range) -> tuple[Array, Array]:
    """Return speed and load of the `numbers`-th nodes, speeds of the first load first."""
    rows, columns = np.divmod(np.arange(numbers.start, numbers.stop), len(speeds))
    return speeds[columns], loads[rows]


def _block(
    judge: Callable[[System, list[Answer]], Judged],
    system: System,
    transient: int,
    periods: int,
    drives: tuple[Array, Array],
) -> Judged:
    train = system.train
    points = [
        Point(train.frequency(speed), load, transient=transient, periods=periods)
        for speed, load in zip(drives[0].tolist(), drives[1].tolist(), strict=True)
    ]
    return judge(system, answers(train, points))


def _nodes(system: System, found: list[Answer]) -> Nodes:
    unit = system.coefficients.force_unit
    return np.array([_node(answer, unit) for answer in found], dtype=NODE)


def _weights(system: System, found: list[Answer]) -> Array:
    return np.array([chaos_weight(regime_of(each), diverged=isinstance(each, Diverged)) for each in found])


def _node(found: Answer, unit: float) -> tuple[float, ...]:
    """Return (code, period, exponent, contact loss, largest force in N, weight of chaos) of one node."""
    regime = regime_of(found)
    lyapunov = np.nan if regime.lyapunov is None else regime.lyapunov
    judged = (NAMES.index(regime.name), regime.period or 0, lyapunov)
    if isinstance(found, Diverged):
        return *judged, np.nan, np.nan, chaos_weight(regime, diverged=True)
    force = found.forces[0]
    return *judged, force.contact_loss, force.maximum * unit, chaos_weight(regime, diverged=False)
