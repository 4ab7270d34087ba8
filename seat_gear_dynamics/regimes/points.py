"""Operating points in, motions out: the one seam between questions about regimes and the compiled march.

Points are independent of each other, so that however they are shared out over threads (or later over lanes of one
loop) changes no number. Only `follow` hands the state of a point on to the next.
"""

from collections import deque
from collections.abc import Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from math import inf, isfinite, pi
from os import cpu_count
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import OperatingPoint, System, Window, integrate
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.regimes.classification import Regime, classify, undecided

Array = NDArray[np.float64]
Item = TypeVar("Item")

_IN_FLIGHT = 4  # points per worker submitted ahead of the one that is read: enough to keep all busy, little to hold


@dataclass(frozen=True, eq=False)
class Point:
    """One operating point of a gear train, and how long to look at it.

    Raises ValueError, a sentence, for a frequency of 0 (there is no mesh period) and for impossible values.
    """

    frequency: float
    """Omega of P12, signed, not 0."""
    load: float
    """T4, N·m."""
    damping_ratio: float | None = None
    """xi of both meshes; None: the train's own."""
    backlash: float | None = None
    """b of both meshes, m; None: the train's own."""
    state: Array | None = None
    """Initial state, (24,), at mesh phase 0; None: rest at static deflection."""
    transient: int = 600
    """Mesh periods of P12 run in."""
    periods: int = 400
    """Mesh periods of P12 sampled."""

    def __post_init__(self) -> None:
        OperatingPoint(self.frequency, self.load)  # refuses what is not finite
        if self.frequency == 0:
            raise ValueError("The frequency is 0, where there is no mesh period to sample; give one other than 0.")
        for name, value in (("damping ratio", self.damping_ratio), ("backlash", self.backlash)):
            if value is not None and not 0 <= value < inf:
                raise ValueError(f"The {name} is {value!r}, expected a finite number of at least 0.")
        if self.transient < 0 or self.periods < 1:
            raise ValueError(
                f"Asked for {self.transient} transient and {self.periods} sampled periods; "
                f"expected at least 0 and at least 1."
            )

    def applied_to(self, train: GearTrain) -> GearTrain:
        """Return `train` with the point's damping ratio and backlash."""
        for index in (0, 1):
            train = train.with_mesh(index, damping_ratio=self.damping_ratio, backlash=self.backlash)
        return train


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion at a point, after its run-in."""

    section: Array
    """Stroboscopic Poincaré section of P12 at mesh phase 0, (periods, 2): δ/b_c and its rate per τ."""
    growth: Array
    """Logarithmic growth of P12's tangent over each sampled period, (periods,)."""
    forces: tuple[Window, ...]
    """Dimensionless force statistics over the sampled periods: of P12, and of P34 where it was integrated."""
    state: Array
    """Final state, (24,), at mesh phase 0."""
    interval: float
    """Mesh period of P12 in τ."""


@dataclass(frozen=True)
class Diverged:
    """The outcome of a point whose solution left every bound."""

    reason: str


Answer = Motion | Diverged


def respond(train: GearTrain, points: Iterable[Point], *, workers: int | None = None) -> Iterator[Answer]:
    """Yield the answer to each of `points` of `train`, in their order, as they become ready.

    Points are integrated in `workers` threads (default: as many as processors), few ahead of the one yielded, so that
    memory stays bounded however many points there are. Answers depend neither on the number of threads nor on the
    order of points. Closing the iterator drops what has not begun. Raises ValueError where `workers` is below 1.
    """
    count = (cpu_count() or 1) if workers is None else workers
    if count < 1:
        raise ValueError(f"Asked for {count} workers, expected at least 1.")
    return _stream(train, points, count)


def _stream(train: GearTrain, points: Iterable[Point], workers: int) -> Iterator[Answer]:
    pool = ThreadPoolExecutor(workers)
    waiting: deque[Future[Answer]] = deque()
    try:
        for point in points:
            waiting.append(pool.submit(answer, train, point))
            if len(waiting) >= _IN_FLIGHT * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


def follow(train: GearTrain, points: Iterable[Point]) -> Iterator[Answer]:
    """Yield the answers to `points` one after the other, each starting where the one before ended.

    The state at mesh phase 0 of P12 is carried over; after a divergence the next point starts as if it were the first.
    Limit: P34 (and an eccentric gear) is carried over at its own phase only where the periods of a point are a whole
    number of its cycles, for P34 a multiple of z2/gcd(z2, z3) (40 for the paper's train); else it takes a jump of
    phase, which decoupled pairs do not pass on to P12.
    """
    state: Array | None = None
    for point in points:
        found = answer(train, point if state is None else replace(point, state=state))
        state = found.state if isinstance(found, Motion) else None
        yield found


def answer(train: GearTrain, point: Point) -> Answer:
    """Return the motion of `train` at `point`, or that it diverged."""
    system = System(point.applied_to(train), OperatingPoint(point.frequency, point.load))
    try:
        found = integrate(system, transient=point.transient, periods=point.periods, state=point.state)
    except DivergedError as error:
        return Diverged(str(error))
    interval = 2 * pi / abs(point.frequency)
    return Motion(found.section, found.growth[:, 0], found.windows, found.state, interval)


def abreast(sequences: Sequence[Iterator[Item]]) -> Generator[Item, None, None]:
    """Yield from each of `sequences` in turn, each advanced in a thread of its own, one item ahead.

    An exhausted sequence is left out from then on. Closing the iterator waits for the items that are under way.
    """
    end = object()
    pool = ThreadPoolExecutor(max(1, len(sequences)))
    try:
        ahead = deque((sequence, pool.submit(next, sequence, end)) for sequence in sequences)
        while ahead:
            sequence, future = ahead.popleft()
            found = future.result()
            if found is not end:
                ahead.append((sequence, pool.submit(next, sequence, end)))
                yield found  # type: ignore[misc]  # the sentinel is sorted out above
    finally:
        pool.shutdown(cancel_futures=True)


def regime_of(found: Answer) -> Regime:
    """Return the regime of an answer; a divergence is undecided, and its reason says so."""
    if isinstance(found, Diverged):
        return undecided(found.reason)
    return classify(found.section, found.growth, found.interval)


def increasing(name: str, values: object, *, least: float, unit: str) -> Array:
    """Return grid `values` as a float array of shape (n,), n >= 1.

    Raises ValueError unless they are finite, strictly increasing and above `least`.
    """
    grid = np.array(values, dtype=float)
    if grid.ndim != 1 or not grid.size or not all(map(isfinite, grid)) or (np.diff(grid) <= 0).any():
        raise ValueError(f"The {name} are {values!r}, expected finite numbers of {unit}, each above the one before.")
    if grid[0] <= least:
        raise ValueError(f"The lowest of the {name} is {grid[0]:g} {unit}, expected more than {least:g} {unit}.")
    return grid
