"""The monitor as a process of its own, for benchmarks that talk to it."""

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
    command = [sys.executable, "-m", "seat_gear_dynamics.nodes.monitor", "--ros-args", *flags]
    with (folder / "monitor").open("wb") as words:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
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
