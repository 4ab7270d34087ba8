"""A real Dask scheduler and its workers: processes of this machine, started by Dask's own command line."""

import os
import queue
import subprocess
import sys
import threading
from pathlib import Path
from time import monotonic
from typing import Any

from distributed import Client

PATIENCE = 120.0
"""Seconds that an awaited line may take on a machine that is very busy."""


class Daemon:
    """A process of Dask's command line, in a folder of its own, that tells what it does on standard error."""

    def __init__(self, folder: Path, *words: str, **environment: str) -> None:
        folder.mkdir()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "dask", *words],
            cwd=folder,  # elsewhere than here, where Python would find this package first
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, **environment},
        )
        self._said: list[str] = []
        self._queue: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self._queue.put(line)
        self._queue.put(None)

    def expect(self, text: str) -> str:
        """Return the next line that holds a text."""
        end = monotonic() + PATIENCE
        while True:
            try:
                line = self._queue.get(timeout=max(0.0, end - monotonic()))
            except queue.Empty:
                line = None
            if line is None:
                raise AssertionError(f"{text!r} did not come, only:\n{''.join(self._said)}")
            self._said.append(line)
            if text in line:
                return line

    def kill(self) -> None:
        """End the process without a chance to say goodbye."""
        self.process.kill()
        self.process.wait()


class Cluster:
    """A scheduler on loopback, and the workers that were started for it."""

    def __init__(self, folder: Path, *options: str, protocol: str = "tcp") -> None:
        self._folder, self._options = folder, options
        self.scheduler = Daemon(
            folder / "scheduler",
            "scheduler",
            "--host",
            f"{protocol}://127.0.0.1",
            "--port",
            "0",
            "--no-dashboard",
            *options,
        )
        self.address = self.scheduler.expect("Scheduler at:").split()[-1]
        self.workers: list[Daemon] = []
        self._started = 0

    def start(self, count: int = 1, **environment: str) -> None:
        """Start workers of one thread each, and return once the scheduler knows them."""
        started = []
        for _ in range(count):
            self._started += 1
            folder = self._folder / f"worker-{self._started}"
            words = ("--no-nanny", "--nthreads", "1", "--memory-limit", "0", "--no-dashboard", *self._options)
            worker = Daemon(folder, "worker", self.address, "--local-directory", str(folder), *words, **environment)
            self.workers.append(worker)
            started.append(worker)
        for worker in started:
            worker.expect("Registered to:")

    def kill(self, worker: Daemon) -> None:
        """Kill a worker, which the scheduler learns of when the connection breaks."""
        self.workers.remove(worker)
        worker.kill()

    def wait(self) -> None:
        """Return once the scheduler has noticed whatever happened to workers."""
        end = monotonic() + PATIENCE
        make: Any = Client  # which has no types
        with make(self.address, set_as_default=False) as client:
            while len(client.nthreads()) != len(self.workers):
                assert monotonic() < end, f"the scheduler has {client.nthreads()}"

    def close(self) -> None:
        """Kill whatever still runs."""
        for daemon in (*self.workers, self.scheduler):
            daemon.kill()
