"""Nodes as processes of their own, for benchmarks that talk to them."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def monitor(domain: int, folder: Path, settings: Sequence[str]) -> Iterator["subprocess.Popen[bytes]"]:
    """Run the monitor on a domain with parameters `NAME:=VALUE`, its words in a file of `folder`."""
    flags = [part for setting in settings for part in ("-p", setting)]
    with _process("seat_gear_dynamics.nodes.monitor", domain, folder, ("--ros-args", *flags)) as process:
        yield process


@contextmanager
def echo(domain: int, folder: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a node that answers each number with the same number, its words in a file of `folder`."""
    with _process("benchmarks.echo", domain, folder) as process:
        yield process


@contextmanager
def _process(
    module: str, domain: int, folder: Path, arguments: Sequence[str] = ()
) -> Iterator["subprocess.Popen[bytes]"]:
    with (folder / module).open("wb") as words:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        command = [sys.executable, "-m", module, *arguments]
        process = subprocess.Popen(command, stdout=words, stderr=words, env=environment)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(15.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
