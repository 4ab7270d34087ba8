"""Programs and nodes for the tests of the bundled runtime: text in, a process with its lines out."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import pytest

from seat_gear_dynamics.runtime.node import Node

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 20.0
"""Seconds an awaited event may take on a loaded machine."""

PREAMBLE = """
from seat_gear_dynamics.runtime import provide_rclpy
assert provide_rclpy() == "bundled"
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float64
"""
"""Start of every program of bundled node code."""


class MakeNode(Protocol):
    """Makes a node in the test's context, destroyed at its end."""

    def __call__(self, name: str = "node", **options: Any) -> Node: ...


class Program:
    """A Python program in a process of its own, with its lines of output as they come."""

    def __init__(self, text: str, domain_id: int, *arguments: str, **environment: str) -> None:
        variables = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]),
            "ROS_DOMAIN_ID": str(domain_id),
            "SEAT_GEAR_RUNTIME": "bundled",
            "PYTHONUNBUFFERED": "1",
            **environment,
        }
        self.process = subprocess.Popen(
            [sys.executable, "-c", textwrap.dedent(text), *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=variables,
        )
        self.lines: list[str] = []
        self._queue: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._queue.put(line.rstrip("\n"))
        self._queue.put(None)

    def expect(self, text: str) -> str:
        """Return the next line that contains a text; fail with the output if none comes."""
        end = time.monotonic() + PATIENCE
        while True:
            try:
                line = self._queue.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                pytest.fail(f"{text!r} did not come, only:\n" + "\n".join(self.lines))
            if line is None:
                pytest.fail(f"the program ended without {text!r}:\n" + "\n".join(self.lines))
            self.lines.append(line)
            if text in line:
                return line

    def wait(self) -> int:
        """Wait for the end, keep the rest of the output, return the exit code."""
        code = self.process.wait(PATIENCE)
        while (line := self._queue.get(timeout=PATIENCE)) is not None:
            self.lines.append(line)
        return code

    def stop(self, number: int = signal.SIGINT) -> int:
        """Send a signal and wait for the end."""
        self.process.send_signal(number)
        return self.wait()


Run = Callable[..., Program]

SpinUntil = Callable[[Callable[[], Any]], None]
