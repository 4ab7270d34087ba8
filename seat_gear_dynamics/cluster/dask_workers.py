"""The workers of a Dask cluster as those who compute blocks of points."""

import asyncio
import logging
import pickle
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from time import monotonic
from typing import Any, TypeVar

from seat_gear_dynamics.cluster.build import CODE, MACHINE, Build, build, difference
from seat_gear_dynamics.cluster.errors import ClusterError
from seat_gear_dynamics.cluster.remote import compute_block

Block = TypeVar("Block")
Found = TypeVar("Found")

BLOCK = 256
"""Most points in a block: some tenths of a second of work, against some milliseconds to hand it over."""
SEGMENT = 16
"""Points of a chain that are handed over at a time: about as long, as a chain fills one lane."""
_LANES = 16  # blocks are whole lanes of this width wherever there are points enough
_PER_THREAD = 4  # blocks of a short study for each thread of the cluster, so that all end at about the same time
_AHEAD = 3  # blocks under way for each thread: what it computes, and what is on its way there or back
_ASK_AGAIN = 2.0  # s, how old the number of threads may be, and how long a block is waited for without a look around
_TRIED, _WITHIN = 3, 2.0  # workers that are tried for a connection of their own, and for how long each, s
_LOGGERS = ("distributed", "distributed.client", "tornado.application")


class DaskWorkers:
    """The workers that a Dask scheduler has, whichever they are at any moment.

    A block whose worker is lost is computed again by another one. `segment` and `share` as `Workers` has them.
    """

    def __init__(self, client: Any, address: str, *, patience: float = 60.0, block: int = BLOCK) -> None:
        """Take a connected `distributed.Client`; `patience`: seconds to wait for a worker while there is none.

        `block`: most points to hand over at a time. Raises ClusterError, one sentence, where no worker comes, or where
        one has other code than this process, or another processor than the rest.
        """
        self._client, self._address, self._patience, self._block = client, address, patience, block
        self._threads, self._asked = 1, -_ASK_AGAIN
        self._alone: float | None = None
        self.build = self._agreed()

    segment = SEGMENT

    def share(self, points: int) -> int:
        """Return how many of `points` to hand over at a time."""
        even = -(-points // (_PER_THREAD * self._count()))
        return min(self._block, -(-even // _LANES) * _LANES) or 1

    def compute(self, work: Callable[[Block], Found], blocks: Iterable[Block]) -> Generator[Found, None, None]:
        """Yield `work` of each of `blocks`; see `Workers.compute`.

        Raises ClusterError where the scheduler is lost, all workers stay away, or one has another build.
        """
        packed = pickle.dumps(work)
        waiting: deque[Any] = deque()
        try:
            for block in blocks:
                with self._errors():
                    waiting.append(self._client.submit(compute_block, packed, block, self.build, pure=False))
                if len(waiting) >= _AHEAD * self._count():
                    yield self._result(waiting.popleft())
            while waiting:
                yield self._result(waiting.popleft())
        finally:
            if waiting and self._client.status == "running":
                with suppress(Exception):  # the run is over: what cannot be called off any more runs out by itself
                    self._client.cancel(list(waiting), asynchronous=False)

    def _result(self, future: Any) -> Any:
        """Return what a block gave, looking around from time to time while it is waited for."""
        while True:
            with self._errors():
                try:
                    found = future.result(timeout=_ASK_AGAIN)
                except TimeoutError:
                    if future.status != "error":  # it may have been finished since: the next look tells
                        self._look_around()
                        continue
                    found = future.result()  # raises what the block raised, which may be this very error
            self._alone = None
            return found

    def _look_around(self) -> None:
        """Raise ClusterError where there has been no worker for longer than patience allows."""
        self._asked = -_ASK_AGAIN
        self._count()
        now = monotonic()
        if self._threads:
            self._alone = None
        elif self._alone is None:
            self._alone = now
        elif now - self._alone > self._patience:
            raise ClusterError(
                f"The scheduler at {self._address} has had no worker for {self._patience:g} s; start workers "
                f"(dask worker {self._address}) and run the same command again, which goes on where it was."
            )

    def _count(self) -> int:
        """Return how many threads the cluster has, at least 1; a figure that may be some seconds old."""
        if monotonic() - self._asked > _ASK_AGAIN:
            with self._errors():
                self._threads = sum(self._client.nthreads().values())
            self._asked = monotonic()
        return max(1, self._threads)

    def _agreed(self) -> Build:
        """Return the build that all workers have; raises ClusterError where there is no such one."""
        with self._errors():
            try:
                self._client.wait_for_workers(1, timeout=self._patience)
            except TimeoutError:
                raise ClusterError(
                    f"The scheduler at {self._address} has no worker, and none came within {self._patience:g} s; "
                    f"start one: dask worker {self._address}"
                ) from None
            answers = self._client.run(build, on_error="return")
        first: Build | None = None
        for worker, found in sorted(answers.items()):
            if isinstance(found, BaseException):
                raise ClusterError(f"The worker {worker} cannot load seat_gear_dynamics ({found}); {_REMEDY}.")
            first = first or found
            differs = difference(build(), found, CODE) or difference(first, found, MACHINE)
            if differs is not None:
                raise ClusterError(f"The worker {worker} has {differs}: its numbers may differ; {_REMEDY}.")
        if first is None:
            raise ClusterError(f"The workers of the scheduler at {self._address} went away; start them again.")
        return first

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Turn what Dask raises into sentences."""
        from distributed import CancelledError, KilledWorker

        try:
            yield
        except ClusterError as error:
            text = str(error)
            raise ClusterError(text if text[0].isupper() else f"In the cluster at {self._address} {text}.") from error
        except KilledWorker as error:
            raise ClusterError(
                f"A block of points was lost with every worker that it was given to ({error.last_worker.address} was "
                f"the last): they were killed, perhaps for want of memory; see their logs, and run the same command "
                f"again, which goes on where it was."
            ) from error
        except (CancelledError, OSError) as error:
            if isinstance(error, TimeoutError):
                raise
            raise ClusterError(
                f"The scheduler at {self._address} was lost; start it and its workers, and run the same command again, "
                f"which goes on where it was."
            ) from error


_REMEDY = "install the same version of everything on every machine, and workers on processors of one kind"


@contextmanager
def connected(address: str, *, timeout: float = 10.0, patience: float = 60.0) -> Iterator[DaskWorkers]:
    """Give the workers of the Dask scheduler at `address`, as in tcp://10.0.0.5:8786 or tls://10.0.0.5:8786.

    Certificates and everything else about the connection come from Dask's own configuration. `timeout`: seconds to
    wait for the scheduler; `patience`: see `DaskWorkers`. Raises ClusterError where the package `distributed` is not
    installed, where nobody answers, and as `DaskWorkers` does. While it lasts Dask's own log is silent: what matters is
    raised.
    """
    try:
        distributed = import_module("distributed")
    except ImportError as error:
        raise ClusterError(
            "Handing points to a Dask scheduler needs the package distributed, which is not installed; "
            "install it with: pip install 'seat_gear_dynamics[cluster]'"
        ) from error
    with _silent():
        try:
            asyncio.run(_knock(address, timeout))
            client = distributed.Client(address, timeout=timeout, set_as_default=False)
        except (OSError, ValueError, TypeError, RuntimeError) as error:
            # Dask names unknown schemes and missing certificates by errors of several kinds.
            raise ClusterError(_unreachable(address, timeout, error)) from error
        try:
            workers = DaskWorkers(client, address, patience=patience)
            # Rows are fetched past the scheduler where that can be: it is one process, and they are the most of it.
            client.direct_to_workers = _in_reach(sorted(client.nthreads())[:_TRIED])
            yield workers
        finally:
            with suppress(Exception):  # nothing hangs on a goodbye that is not heard
                client.close(timeout=timeout)


def _in_reach(workers: Iterable[str]) -> bool:
    """Return whether this machine can connect to `workers`, and not only to their scheduler."""
    try:
        for worker in workers:
            asyncio.run(_knock(worker, _WITHIN))
    except (OSError, ValueError, TypeError, RuntimeError):
        return False
    return True


async def _knock(address: str, timeout: float) -> None:
    """Connect once and hang up. Raises TimeoutError where nobody answers, and what Dask raises.

    Dask's client waits for ever for one that lets it connect and says nothing, and leaves noise behind when it fails.
    """
    dask, core = import_module("dask"), import_module("distributed.core")
    if dask.config.get("distributed.client.security-loader", None):
        return  # the client alone knows how to get its certificates
    how = import_module("distributed.security").Security().get_connection_args("client")
    comm = await asyncio.wait_for(core.connect(address, timeout=timeout, **how), timeout)
    await comm.close()


def _unreachable(address: str, timeout: float, error: Exception) -> str:
    if isinstance(error, OSError):
        return (
            f"No Dask scheduler answered at {address!r} within {timeout:g} s; check the address, and that a scheduler "
            f"runs there (dask scheduler)"
        )
    text = " ".join(str(error).split())
    return f"The scheduler address {address!r} cannot be used ({text}); expected one as tcp://HOST:8786"


@contextmanager
def _silent() -> Iterator[None]:
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL)
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
