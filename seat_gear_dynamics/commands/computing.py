"""Who computes the points of a command, and how a long computation is begun, interrupted and taken up again."""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from seat_gear_dynamics.cluster.build import Build
    from seat_gear_dynamics.regimes.workers import Workers


def add_computing_arguments(parser: argparse.ArgumentParser) -> None:
    """Add where to compute, and whether to begin anew."""
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="hand points to a Dask cluster, as tcp://10.0.0.5:8786 (default: local)"
    )
    parser.add_argument(
        "--restart", action="store_true", help="begin anew (default: go on where an interrupted run of this stands)"
    )


@contextmanager
def workers(arguments: argparse.Namespace) -> "Iterator[tuple[Workers, Build]]":
    """Give who computes, and the build that the numbers come from; a cluster's errors are the command's."""
    from seat_gear_dynamics.cluster.build import build
    from seat_gear_dynamics.cluster.dask_workers import connected
    from seat_gear_dynamics.cluster.errors import ClusterError
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.regimes.workers import Threads

    if arguments.scheduler is None:
        yield Threads(), build()
        return
    try:
        with connected(arguments.scheduler) as found:
            yield found, found.build
    except ClusterError as error:
        raise CommandError(str(error)) from error


@contextmanager
def interruptible(standing: Callable[[], str]) -> Iterator[None]:
    """Say on standard error, when Ctrl-C ends what is inside, what `standing` says and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        print(f"interrupted at {standing()}; the same command goes on from there", file=sys.stderr)
        raise
