"""Progress of a long computation on standard error: bars with the time left at a terminal, a line now and then else."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import ceil
from time import monotonic
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from rich.progress import Progress

Tell = Callable[[int, int], None]
"""Takes (done, in all); (0, 0) where it is not known how much there is."""
TellStage = Callable[[str, int, int], None]
"""Takes (stage, done, in all)."""

LINE_INTERVAL = 10.0
"""Seconds, at least, before the first line and between two, where standard error is no terminal."""
_MEMORY = 300.0  # s, over which speed is estimated: blocks of a cluster come rarely


@contextmanager
def progress(
    label: str, *, quiet: bool = False, begun: int = 0, clock: Callable[[], float] = monotonic
) -> Iterator[Tell]:
    """Give a callback that takes (done, in all) and shows both with the time left; one stage of `stages`.

    `begun`: how much was done before, by an earlier run: it says nothing of how fast this one is.
    """
    with stages(quiet=quiet, begun=begun, clock=clock) as tell:
        tell(label, begun, 0)
        yield lambda done, total: tell(label, done, total)


@contextmanager
def stages(*, quiet: bool = False, begun: int = 0, clock: Callable[[], float] = monotonic) -> Iterator[TellStage]:
    """Give a callback that takes (stage, done, in all) and shows a bar for each stage; it may be called by any thread.

    A stage of which nothing is known in all shows the time it has taken. Silent where `quiet`, as with --json. The bars
    are gone when the context ends. Where standard error is no terminal, or one that cannot move its cursor, a line
    comes every LINE_INTERVAL at most, and none from what is over before. `clock` gives seconds for these lines.
    """
    if quiet:
        yield lambda stage, done, total: None
    elif not sys.stderr.isatty() or os.environ.get("TERM") in ("dumb", "unknown"):
        yield _Lines(sys.stderr, clock, begun).tell
    else:
        with _bars() as bars:
            yield _Bars(bars, begun).tell


class _Bars:
    """A bar for each stage, in the order in which they begin."""

    def __init__(self, bars: "Progress", begun: int) -> None:
        self._bars, self._begun = bars, begun
        self._tasks: dict[str, Any] = {}

    def tell(self, stage: str, done: int, total: int) -> None:
        if stage not in self._tasks:
            self._tasks[stage] = self._bars.add_task(stage, total=None, completed=self._begun)
        self._bars.update(self._tasks[stage], completed=done, total=total or None)


class _Lines:
    """A line now and then: what is done of how much, and the time left at the stage's pace so far."""

    def __init__(self, stream: TextIO, clock: Callable[[], float], begun: int) -> None:
        self._stream, self._clock, self._begun = stream, clock, begun
        self._due = clock() + LINE_INTERVAL
        self._since: dict[str, float] = {}

    def tell(self, stage: str, done: int, total: int) -> None:
        now = self._clock()
        since = self._since.setdefault(stage, now)
        if now >= self._due:
            self._due = now + LINE_INTERVAL
            print(f"{stage}: {self._standing(done, total, now - since)}", file=self._stream, flush=True)

    def _standing(self, done: int, total: int, taken: float) -> str:
        if not total:
            return f"{_duration(taken)} so far"
        made = done - self._begun
        left = f", {_duration(taken / made * (total - done))} left" if made > 0 and done < total else ""
        return f"{done} of {total}{left}"


def _bars() -> "Progress":
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
    from rich.progress import MofNCompleteColumn as Count
    from rich.progress import TimeRemainingColumn as Left
    from rich.text import Text

    class Known(ProgressColumn):
        """Count and time left; the time taken where it is not known how much there is."""

        max_refresh = None
        _count, _left, _taken = Count(), Left(), TimeElapsedColumn()

        def render(self, task: Task) -> Text:
            if task.total is None:
                return self._taken.render(task)
            left = Text(" left", "progress.remaining")
            return Text.assemble(self._count.render(task), "  ", self._left.render(task), left)

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), Known())
    # Standard output is left alone: what is printed there meanwhile may go to a file.
    console = Console(stderr=True)
    return Progress(*columns, console=console, transient=True, redirect_stdout=False, speed_estimate_period=_MEMORY)


def _duration(seconds: float) -> str:
    """Return a time in the two units that tell: 42 s, 3 min 5 s, 2 h 10 min."""
    whole = ceil(seconds)
    minutes, hours = whole // 60, whole // 3600
    if hours:
        return f"{hours} h {minutes % 60} min"
    return f"{minutes} min {whole % 60} s" if minutes else f"{whole} s"
