"""What the monitor node takes of a machine: `python -m benchmarks.node [--seconds S]` prints one JSON object.

`seat-gear monitor` and `seat-gear simulator`, which plays up-down at 50 Hz, run as processes on a ROS domain of their
own, and this process listens to the forces, as a recorder would. From the first force on /proc is read once a second:
the monitor's share of one core over all the time, and in the second that took most (the profile goes up to
2200 r/min), both meant to stay below 15 %; and its resident memory, the most that it ever held, imports and compiled
code included, meant to stay below 400 MB. `forces_per_second` says that it did its work meanwhile.

In real time nothing can be repeated in a moment: what others do on the machine makes the share larger.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Any

from benchmarks.calibration import calibration_seconds
from benchmarks.ratio import Findings, Ratio

COMMAND = "from seat_gear_dynamics.commands import main; import sys; sys.exit(main(sys.argv[1:]))"
SETTINGS = {"simulator": "rate=50.0", "monitor": "publish_rate=50.0"}
SHARE_REACH, MEMORY_REACH = 0.15, 400.0
PATIENCE = 120.0
"""Seconds until the monitor has to be at work; the first start on a machine compiles the model."""


def measure(
    *, short: bool = False, seconds: float | None = None, progress: Callable[[str], None] | None = None
) -> Findings:
    """Run both nodes and watch for `seconds`: by default a round of the profile, 10 in the short form."""
    if not Path("/proc/self/stat").exists():
        return Findings(skipped="There is no /proc here, from which the processes' use is read.")
    lasting = seconds or (10.0 if short else 56.0)
    if progress is not None:
        progress(f"monitor node, {lasting:g} s")
    unit, domain = calibration_seconds(), random.SystemRandom().randrange(1, 100)
    with (
        TemporaryDirectory(prefix="seat_gear_node_") as folder,
        Listener(domain) as listener,
        nodes(Path(folder), domain) as monitor,
    ):
        listener.wait(lambda: listener.heard > 0 or monitor.poll() is not None, PATIENCE)
        if not listener.heard:
            said = (Path(folder) / "monitor").read_text(errors="replace")[-500:]
            raise RuntimeError(f"The monitor published no force within {PATIENCE:g} s; it said: {said}")
        first, spent = listener.heard, watched(monitor.pid, listener, round(lasting))
        forces, held = listener.heard - first, memory(monitor.pid)
    return _findings(spent, held, forces, unit)


def _findings(spent: list[float], held: dict[str, float], forces: int, unit: float) -> Findings:
    shares = [after - before for before, after in pairwise(spent)]
    mean, meaning = sum(shares) / len(shares), "share of one core, monitor at 50 Hz"
    figures: dict[str, Any] = {
        "seconds": len(shares),
        "forces_per_second": forces / len(shares),
        "share_of_a_core": mean,
        "highest_share_in_a_second": max(shares),
        "resident_megabytes": held["VmRSS"],
        "peak_megabytes": held["VmHWM"],
    }
    return Findings(
        figures,
        {
            "monitor_share": Ratio((mean,), meaning, better="lower", reach=SHARE_REACH),
            "monitor_share_over_calibration": Ratio((mean / unit,), f"{meaning}, over a calibration", better="lower"),
            "monitor_megabytes": Ratio((held["VmHWM"],), "peak of resident memory, MB", "lower", MEMORY_REACH),
        },
    )


class Listener:
    """A node of this process that counts the monitor's forces."""

    def __init__(self, domain: int) -> None:
        import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)

        # isort: split
        import rclpy

        self.heard = 0
        self._rclpy, self._domain = rclpy, domain

    def __enter__(self) -> "Listener":
        from rclpy.node import Node
        from rclpy.qos import QoSProfile
        from rclpy.signals import SignalHandlerOptions
        from sensor_msgs.msg import JointState

        from seat_gear_dynamics.logs import topics

        self._rclpy.init(args=[], domain_id=self._domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node: Any = Node("benchmark_listener")
        self._node.create_subscription(JointState, topics.MESH_FORCE.name, self._on_force, QoSProfile(depth=100))
        return self

    def __exit__(self, *error: object) -> None:
        self._node.destroy_node()
        self._rclpy.try_shutdown()

    def _on_force(self, message: object) -> None:
        self.heard += 1

    def wait(self, reached: Callable[[], bool], patience: float) -> None:
        """Listen until `reached`, or for `patience` seconds."""
        begin = monotonic()
        while not reached() and (left := begin + patience - monotonic()) > 0:
            self._rclpy.spin_once(self._node, timeout_sec=min(left, 0.1))


@contextmanager
def nodes(folder: Path, domain: int) -> Iterator["subprocess.Popen[bytes]"]:
    """Run simulator and monitor, their words in files of `folder`; give the monitor's process."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    started: list[subprocess.Popen[bytes]] = []
    try:
        for name, setting in SETTINGS.items():
            with (folder / name).open("wb") as words:
                command = [sys.executable, "-c", COMMAND, name, "--set", setting]
                started.append(subprocess.Popen(command, stdout=words, stderr=words, env=environment))
        yield started[-1]
    finally:
        for process in started:
            process.send_signal(signal.SIGINT)
        for process in started:
            _end(process)


def _end(process: "subprocess.Popen[bytes]") -> None:
    try:
        process.wait(15.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def watched(pid: int, listener: Listener, seconds: int) -> list[float]:
    """Return the processor time of a process now and at the end of each of `seconds`."""
    begin, spent = monotonic(), [processor_seconds(pid)]
    for n in range(1, seconds + 1):
        listener.wait(lambda: False, begin + n - monotonic())
        spent.append(processor_seconds(pid))
    return spent


def processor_seconds(pid: int) -> float:
    """Return the processor time that a process has taken so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory(pid: int) -> dict[str, float]:
    """Return VmRSS and VmHWM of a process, MB."""
    lines = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines() if ":" in line)
    return {name: int(lines[name].split()[0]) / 1024 for name in ("VmRSS", "VmHWM")}


def main() -> None:
    """Measure and print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, help="how long to watch")
    found = measure(seconds=parser.parse_args().seconds)
    print(json.dumps(found.as_dict(), indent=1))


if __name__ == "__main__":
    main()
