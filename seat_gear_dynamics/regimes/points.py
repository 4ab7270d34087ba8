"""Operating points in, motions out: the one seam between questions about regimes and the compiled kernels.

Points are marched in lanes, many at once, and by `motion.integrate` where lanes cannot. They are independent of each
other: how they are shared out over lanes and threads changes no number. Only `follow` hands a state on to the next.
"""

from collections import deque
from collections.abc import Generator, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from math import inf, isfinite, pi
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import OperatingPoint, System, Window, integrate
from seat_gear_dynamics.motion.lanes import in_reach, respond_lanes, supports
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.regimes.classification import Regime, classify, undecided
from seat_gear_dynamics.regimes.workers import BATCH as BATCH
from seat_gear_dynamics.regimes.workers import Workers, chosen

Array = NDArray[np.float64]
Item = TypeVar("Item")


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
    """Logarithmic growth of P12's tangent, or a coupled train's, over each sampled period, (periods,)."""
    forces: tuple[Window, ...]
    """Dimensionless force statistics over the sampled periods: of P12, and of P34 where it was integrated."""
    state: Array
    """Final state, (24,), at mesh phase 0; P34 as it started where it was not integrated."""
    interval: float
    """Mesh period of P12 in τ."""


@dataclass(frozen=True)
class Diverged:
    """The outcome of a point whose solution left every bound."""

    reason: str


Answer = Motion | Diverged


def bare(train: GearTrain) -> GearTrain:
    """Return `train` without its texts and what it has computed already: what its motion needs, fit to travel."""
    meshes = replace(train.meshes[0]), replace(train.meshes[1])
    return replace(train, text="", provenance={}, bands=(), meshes=meshes)


def respond(
    train: GearTrain, points: Iterable[Point], *, workers: Workers | int | None = None
) -> Generator[Answer, None, None]:
    """Yield the answer to each of `points` of `train`, in their order, as they become ready.

    Points are marched BATCH at a time by `workers` (a number: so many threads, default as many as processors), few
    batches ahead of the answer yielded, so that memory stays bounded however many points there are. Answers depend
    neither on who computes them nor on the order of points. Closing the iterator drops what has not begun. Raises
    ValueError where `workers` is below 1.
    """
    return _stream(train, iter(points), chosen(workers))


def _stream(train: GearTrain, points: Iterator[Point], workers: Workers) -> Generator[Answer, None, None]:
    batches = iter(lambda: list(islice(points, BATCH)), [])
    with closing(workers.compute(partial(answers, train), batches)) as found:
        for batch in found:
            yield from batch


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
    return answers(train, [point])[0]


def answers(train: GearTrain, points: Sequence[Point]) -> list[Answer]:
    """Return the answers to `points`: those that lanes can march all at once, the others one by one."""
    found: dict[int, Answer] = {}
    alike: dict[tuple[object, ...], list[int]] = {}
    marched = in_reach(train, np.array([p.frequency for p in points])) & supports(train)
    for index, point in enumerate(points):
        if marched[index]:
            given = (point.damping_ratio is None, point.backlash is None, point.state is None)
            alike.setdefault((point.transient, point.periods, given), []).append(index)
        else:
            found[index] = _integrated(train, point)
    for own in alike.values():
        found |= zip(own, _in_lanes(train, [points[index] for index in own]), strict=True)
    return [found[index] for index in range(len(points))]


def _in_lanes(train: GearTrain, points: Sequence[Point]) -> list[Answer]:
    """Return the answers to points of one run-in and record, each giving the same of damping, backlash and state."""
    first = points[0]
    found = respond_lanes(
        train,
        [p.frequency for p in points],
        [p.load for p in points],
        damping_ratio=None if first.damping_ratio is None else [p.damping_ratio or 0.0 for p in points],
        backlash=None if first.backlash is None else [p.backlash or 0.0 for p in points],
        state=None if first.state is None else np.array([p.state for p in points], dtype=float),
        transient=first.transient,
        periods=first.periods,
        threads=1,
    )
    answers: list[Answer] = []
    for lane, point in enumerate(points):
        if found.diverged[lane]:
            answers.append(_diverged(point))
            continue
        forces = tuple(Window(*map(float, window)) for window in found.windows[lane])
        interval = 2 * pi / abs(point.frequency)
        answers.append(Motion(found.section[lane], found.growth[lane], forces, found.state[lane], interval))
    return answers


def _diverged(point: Point) -> Diverged:
    return Diverged(
        f"The motion diverged at frequency {point.frequency:.6g} and load {point.load:.6g} N·m: the parameters are "
        f"unstable there (parametric resonance) or damping is too low; change them, or the initial state."
    )


def _integrated(train: GearTrain, point: Point) -> Answer:
    """Return the answer to a point by the march of a single motion."""
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
