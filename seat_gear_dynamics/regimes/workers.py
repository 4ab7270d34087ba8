"""Who computes blocks of points: the threads of this machine, or whoever else keeps the same three promises."""

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from os import cpu_count
from typing import Protocol, TypeVar

from seat_gear_dynamics.motion.lanes import WIDTH

Block = TypeVar("Block")
Found = TypeVar("Found")

BATCH = 2 * WIDTH
"""Points that a thread of this machine marches together."""
_IN_FLIGHT = 2  # blocks per worker submitted ahead of the one that is read: enough to keep all busy, little to hold


class Workers(Protocol):
    """Who computes blocks of points.

    How points are cut into blocks, and who computes which, changes no number: a point's answer depends on the point
    alone. So an implementation is free in all but the order in which it gives back what was found.
    """

    @property
    def segment(self) -> int:
        """Points of a chain to hand out at a time, in which each starts where the one before ended; at least 1."""

    def share(self, points: int) -> int:
        """Return how many independent points of `points` to hand out at a time, at least 1."""

    def compute(self, work: Callable[[Block], Found], blocks: Iterable[Block]) -> Generator[Found, None, None]:
        """Yield `work` of each of `blocks`, in their order, as they become ready.

        Blocks are taken few ahead of what is read, so that memory stays bounded however many there are. `work` and
        blocks must pickle. What `work` raises reaches the reader. Closing the generator drops what has not begun.
        """


class Threads:
    """The threads of this machine: `count` of them, default as many as processors. Raises ValueError below 1."""

    segment = 1
    """A chain gives each row as it is found: handing over to a thread costs nothing."""

    def __init__(self, count: int | None = None) -> None:
        self._count = (cpu_count() or 1) if count is None else count
        if self._count < 1:
            raise ValueError(f"Asked for {self._count} workers, expected at least 1.")

    def share(self, points: int) -> int:
        """Return BATCH, whatever `points`: what the lanes fill."""
        return BATCH

    def compute(self, work: Callable[[Block], Found], blocks: Iterable[Block]) -> Generator[Found, None, None]:
        """Yield `work` of each of `blocks`; see `Workers.compute`."""
        pool = ThreadPoolExecutor(self._count)
        waiting: deque[Future[Found]] = deque()
        try:
            for block in blocks:
                waiting.append(pool.submit(work, block))
                if len(waiting) >= _IN_FLIGHT * self._count:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            pool.shutdown(cancel_futures=True)


def chosen(workers: Workers | int | None) -> Workers:
    """Return `workers`, or as many threads of this machine as a number says, None for as many as processors."""
    return Threads(workers) if workers is None or isinstance(workers, int) else workers


def ranges(begin: int, end: int, length: int) -> Generator[range, None, None]:
    """Yield the numbers from `begin` to before `end` as ranges of `length`, the last as long as is left."""
    for first in range(begin, end, length):
        yield range(first, min(first + length, end))
