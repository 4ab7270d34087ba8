"""Progress of a long computation on standard error: a bar with the time left, where a person is looking."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_MEMORY = 300.0  # s, over which speed is estimated: blocks of a cluster come rarely


@contextmanager
def progress(label: str, *, quiet: bool = False, begun: int = 0) -> Iterator[Callable[[int, int], None]]:
    """Give a callback that takes (done, in all) and shows both with the time left.

    `begun`: how much was done before, by an earlier run: it says nothing of how fast this one is. Silent where `quiet`
    (as with --json) or where standard error is no terminal. The bar is gone when the context ends.
    """
    if quiet or not sys.stderr.isatty():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True, speed_estimate_period=_MEMORY) as bars:
        task = bars.add_task(label, total=None, completed=begun)
        yield lambda done, total: bars.update(task, completed=done, total=total)


@contextmanager
def stages(*, quiet: bool = False) -> Iterator[Callable[[str, int, int], None]]:
    """Give a callback that takes (stage, done, in all) and shows a bar for each stage, those done without it.

    Silent where `quiet` or where standard error is no terminal.
    """
    if quiet or not sys.stderr.isatty():
        yield lambda stage, done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        tasks: dict[str, TaskID] = {}

        def show(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage)
            bars.update(tasks[stage], completed=done, total=total)

        yield show
