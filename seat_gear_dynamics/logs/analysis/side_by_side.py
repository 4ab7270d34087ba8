"""The estimate of a long log in stretches that are marched side by side, each held against the end of the one before.

Time-parallel integration by a guess of the state at each seam, as in the parareal method (Lions, Maday and Turinici
2001), without its iteration: the guess is what some seconds of run-in lead to, and where it is not what the stretch
before arrived at, the stretch is marched again from there.
"""

from __future__ import annotations

import pickle
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs.analysis.batches import DRIVE_COLUMNS, Array, Batch, empty
from seat_gear_dynamics.logs.analysis.estimate import MAX_GAP, Estimate
from seat_gear_dynamics.logs.analysis.seam import Join, Phase, Seam
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.sensing import BandSource

STRETCH = 60.0
"""s of drive in a stretch at least. It ends within as much again, where the drive was slowest; a shorter log is one."""
RUN_IN = 5.0
"""s before a stretch that lead its motion in.

The teeth forget in a tenth of a second, the swing of the gears on their shafts by e each second. The packaged train's
creep on its torsional supports takes a minute, but it moves both gears of a pair together and hardly their teeth.
"""


@dataclass
class Stretches:
    """How an estimate was cut, and how its stretches but the first go on; the rest does in the same state."""

    count: int = 0
    shifted: int = 0
    """In the same motion of several mesh periods, some of them earlier or later (`Join.SHIFTED`)."""
    chaotic: int = 0
    """In chaos, on another path (`Join.CHAOS`)."""
    again: int = 0
    """Anywhere else, and were therefore marched again from the end of the one before."""


class _Job(NamedTuple):
    """A stretch: its batches, the drive of its run-in (m, 4), the mesh phase there, and whether another follows."""

    batches: list[Batch]
    run_in: Array
    phase: float
    ends: bool


class _Done(NamedTuple):
    batches: list[Batch]
    begin: Seam | None
    end: Seam | None
    estimate: bytes
    """The estimate at the end, pickled; empty for the last stretch."""


class SideBySide:
    """Fills batches that hold only a drive, in order, by `workers` processes (1: in this one).

    Results do not depend on the number of workers: the cuts follow from the drive alone. Memory is bounded by a few
    stretches a worker. Within a log of one stretch, and from each seam at which a stretch was marched again, the result
    is that of a single session. Where a stretch was not, its motion agrees with that of a single session to what
    `Phase.meets` allows at the seam, and nearer from there on. Limit: the record on which a regime is judged begins
    with the run-in, so a steady drive's may be judged again at other moments than in a single session.
    """

    def __init__(
        self,
        train: GearTrain,
        *,
        bands: BandSource | None = None,
        workers: int = 1,
        stretch: float = STRETCH,
        run_in: float = RUN_IN,
    ) -> None:
        """Take the bands by which warnings are judged (None: the published ones), and lengths in s."""
        self.stretches = Stretches()
        self._machine, self._workers = _Machine(train, bands), max(workers, 1)
        self._phase, self._seams = _Integral(train), Phase(train)
        self._stretch, self._run_in = stretch, run_in
        self._before = empty((*DRIVE_COLUMNS, "phase"))
        self._open: list[tuple[Batch, Array]] = []
        """What has not been given away, each with the drive that would lead in behind it."""
        self._led_in = self._before
        self._pending: deque[tuple[_Job, Future[_Done]]] = deque()
        self._last: _Done | None = None

    def batches(self, recorded: Iterable[Batch]) -> Iterator[Batch]:
        """Yield the batches of `recorded` filled; a few stretches later than they came."""
        with _pool(self._machine, self._workers) as pool:
            for batch in recorded:
                self._take(batch)
                if self._length(len(self._open)) >= 2 * self._stretch:
                    self._submit(pool, self._slowest())
                while len(self._pending) > self._workers:
                    yield from self._accept(pool)
            if self._open:
                self._submit(pool, len(self._open), ends=False)
            while self._pending:
                yield from self._accept(pool)

    def _take(self, batch: Batch) -> None:
        rows = np.column_stack([batch.drive, self._phase.follow(batch.drive)])
        kept = np.concatenate([self._before, rows])
        self._before = kept[kept[:, 0] >= kept[-1, 0] - self._run_in] if len(kept) else kept
        self._open.append((batch, self._before))

    def _length(self, count: int) -> float:
        """Return how long the drive of the first `count` open batches is, s."""
        ends = [batch.drive[[0, -1], 0] for batch, _ in self._open[:count] if len(batch.drive)]
        return float(ends[-1][1] - ends[0][0]) if ends else 0.0

    def _slowest(self) -> int:
        """Return how many of the open batches the stretch takes: up to where the drive is slowest, so calm if ever."""
        chosen = [n for n in range(1, len(self._open) + 1) if self._length(n) >= self._stretch]
        return min(chosen, key=lambda n: float(np.abs(self._open[n - 1][1][:, 1]).max(initial=0.0)))

    def _submit(self, pool: Executor, count: int, *, ends: bool = True) -> None:
        """Give away the first `count` open batches; the drive before their end leads in the next stretch."""
        phase = float(self._led_in[0, -1]) if len(self._led_in) else 0.0
        job = _Job([batch for batch, _ in self._open[:count]], self._led_in[:, :-1], phase, ends)
        self._pending.append((job, pool.submit(_march, job)))
        self._led_in, self._open = self._open[count - 1][1], self._open[count:]
        self.stretches.count += 1

    def _accept(self, pool: Executor) -> list[Batch]:
        job, future = self._pending.popleft()
        done = _result(future)
        if self._last is not None:
            join = self._join(self._last, done)
            self.stretches.shifted += join is Join.SHIFTED
            self.stretches.chaotic += join is Join.CHAOS
            if join is Join.NONE:
                done = _result(pool.submit(_go_on, job, self._last.estimate))
                self.stretches.again += 1
        self._last = done
        return done.batches

    def _join(self, last: _Done, done: _Done) -> Join:
        if last.end is None or done.begin is None:
            return Join.NONE
        return self._seams.join(last.end, done.begin)


class _Integral:
    """The mesh phase of P12 along a drive, in periods: what a march from the drive's first sample on comes to."""

    def __init__(self, train: GearTrain) -> None:
        self._train = train
        self._last: tuple[float, float] | None = None
        self._phase = 0.0

    def follow(self, drive: Array) -> Array:
        """Return the phase at each row, (n,); a gap, at which the model restarts, begins at 0 again."""
        if not len(drive):
            return np.empty(0)
        time, frequency = drive[:, 0], np.array([self._train.frequency(speed) for speed in drive[:, 1].tolist()])
        before = self._last or (float(time[0]), float(frequency[0]))
        span = np.diff(time, prepend=before[0])
        turned = span * (frequency + np.concatenate([[before[1]], frequency[:-1]])) / 2
        total = self._phase + np.cumsum(turned * self._train.model.time_scale / (2 * np.pi))
        restarts = np.flatnonzero((span > MAX_GAP) | (span < -MAX_GAP))
        for place in restarts.tolist():
            total[place:] -= total[place]
        self._last, self._phase = (float(time[-1]), float(frequency[-1])), float(total[-1])
        return total


def _result(future: Future[_Done]) -> _Done:
    try:
        return future.result()
    except BrokenExecutor as cause:
        raise LogError(
            "A process that marched the model ended by itself, maybe for want of memory; expected it to finish. "
            "Analyse with one process."
        ) from cause


class _Machine(NamedTuple):
    """What is marched, and by which bands it is warned of."""

    train: GearTrain
    bands: BandSource | None


_machine: _Machine | None = None


def _use(machine: _Machine) -> None:
    """Keep the machine in this process."""
    global _machine
    _machine = machine


def _march(job: _Job) -> _Done:
    """March a stretch after its run-in, whose own results are dropped."""
    assert _machine is not None, "the process was started with a machine"
    estimate = Estimate(_machine.train, bands=_machine.bands)
    if len(job.run_in):
        estimate.begin(job.run_in[0], job.phase)
        estimate.extend(Batch(drive=job.run_in[1:]))
        estimate.cut()
    return _filled(job, estimate)


def _go_on(job: _Job, before: bytes) -> _Done:
    """March a stretch from where the one before has ended."""
    estimate = pickle.loads(before)
    assert isinstance(estimate, Estimate)
    return _filled(job, estimate)


def _filled(job: _Job, estimate: Estimate) -> _Done:
    begin = estimate.seam
    for number, batch in enumerate(job.batches, start=1):
        batch.restarts, batch.warnings = [], []
        estimate.extend(batch, last=job.ends and number == len(job.batches))
    return _Done(job.batches, begin, estimate.seam, pickle.dumps(estimate) if job.ends else b"")


class _Here(Executor):
    """Marches at once and in this process."""

    def submit(self, fn, /, *args, **kwargs):  # type: ignore[no-untyped-def]  # as Executor's
        future: Future[_Done] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def _pool(machine: _Machine, workers: int) -> Executor:
    if workers == 1:
        _use(machine)
        return _Here()
    # Spawned: a fork would copy the locks of numba's and the plots' threads as they happen to stand.
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_use, initargs=(machine,))
