"""From a speed on the wire to the warning on the wire: `python -m benchmarks.latency [--short]` prints one JSON object.

The monitor runs as a process of its own on a ROS domain of its own, and this process plays a bench: a load and a speed,
alternately calm (900 r/min) and inside a band (1800), at `--rate` with some jitter, so that neither process is in step
with the other. Debounce and hold are 0 here, so that every sample moves the trip signal and is answered; what the
debounce adds by intention is not latency. Measured is the time from just before a speed is written until this process
has the trip signal, and the warning, of it: two ways over DDS and both processes' Python. The sender's and the
receiver's own share is in it. Forces, sections, states and diagnostics go out at their default rates, and what
they hold up is in the figures.

Beside it stands what the way there and back takes without any monitor: a node that answers each Float64 with the same,
asked at the same rate by the same loop. Where rclpy is sourced both are rclpy's.

Idle, and then with one busy process for each core.
"""

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, perf_counter_ns
from typing import Any, Self

import numpy as np

from benchmarks import machine, processes
from benchmarks.ratio import Findings, Ratio

FULL, SHORT = 100_000, 2_000
ECHOES = 0.2  # of the samples: its median and its tail settle sooner
RATE = 200.0  # samples a second: four times the default bench's, so that 100 000 take ten minutes
RPM = np.pi / 30
SPEEDS = (900.0 * RPM, 1800.0 * RPM)  # clear of every band of the packaged train, and inside one
LOAD = 600.0
LOST = 2.0  # s after which a sample counts as unanswered
PATIENCE = 120.0  # s for the first answer: a monitor's first start compiles the model
DROPPED = 20  # samples at the start that are not counted
SETTINGS = ("debounce:=0.0", "hold:=0.0")
BUSY = "while True: pass"
PERCENTILES = (50.0, 99.0, 99.9)


def measure(*, short: bool = False, rate: float = RATE, progress: Callable[[str], None] | None = None) -> Findings:
    """Return the latencies idle and with every core busy, ms."""
    count = SHORT if short else FULL
    figures: dict[str, Any] = {"machine": machine.description(), "samples": count, "rate_hz": rate}
    ratios: dict[str, Ratio] = {}
    for name, busy in (("idle", 0), ("loaded", os.cpu_count() or 1)):
        if progress is not None:
            progress(f"latency, {name}: {count} samples at {rate:g} Hz")
        with burners(busy):
            found = run(count, rate) | run_echo(int(count * ECHOES), rate)
        figures[name] = found
        ratios[f"warning_{name}_over_echo"] = Ratio(
            (found["warning"]["p50"] / found["echo"]["p50"],),
            f"speed to warning over a bare echo, {name}, p50",
            "lower",
        )
    return Findings(figures, ratios)


def run(count: int, rate: float) -> dict[str, Any]:
    """Return one condition's figures: percentiles of trip and warning, ms, and how many samples went unanswered."""
    with (
        place() as (domain, folder),
        processes.monitor(domain, folder, SETTINGS),
        Bench(domain) as bench,
    ):
        bench.ready()
        found = [bench.sample(rate) for _ in range(count + DROPPED)][DROPPED:]
    return {name: spread([one[name] for one in found if one]) for name in ("trip", "warning")} | {
        "unanswered": sum(one is None for one in found)
    }


def run_echo(count: int, rate: float) -> dict[str, Any]:
    """Return what a bare echo takes, ms."""
    with place() as (domain, folder), processes.echo(domain, folder), Caller(domain) as caller:
        caller.ready()
        found = [caller.sample(rate) for _ in range(count + DROPPED)][DROPPED:]
    return {"echo": spread([one["pong"] for one in found if one])}


@contextmanager
def place() -> Iterator[tuple[int, Path]]:
    """Give a ROS domain that is likely free, and a folder for words."""
    with tempfile.TemporaryDirectory(prefix="seat_gear_latency_") as folder:
        yield random.SystemRandom().randrange(1, 100), Path(folder)


def spread(times_ms: list[float]) -> dict[str, float]:
    """Return p50, p99, p99.9, maximum and mean of some times."""
    values = np.percentile(times_ms, PERCENTILES)
    named = {f"p{p:g}": float(v) for p, v in zip(PERCENTILES, values, strict=True)}
    return {**named, "max": max(times_ms), "mean": float(np.mean(times_ms))}


class Asking:
    """A node in this process that sends something and times each answer until all are there."""

    answers: tuple[str, ...]

    def __init__(self, domain: int) -> None:
        import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)

        # isort: split
        import rclpy

        self._rclpy, self._domain = rclpy, domain
        self._times: dict[str, int] = {}

    def __enter__(self) -> Self:
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from rclpy.signals import SignalHandlerOptions

        self._rclpy.init(args=[], domain_id=self._domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node: Any = Node("benchmark_bench")
        self._executor: Any = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._open()
        return self

    def __exit__(self, *error: object) -> None:
        self._node.destroy_node()
        self._rclpy.try_shutdown()

    def _open(self) -> None:
        """Make publishers and subscriptions."""
        raise NotImplementedError

    def _send(self) -> int:
        """Send; return when, ns."""
        raise NotImplementedError

    def _heard(self, answer: str) -> None:
        self._times.setdefault(answer, perf_counter_ns())

    def _spin_until(self, end: float) -> None:
        while (left := end - monotonic()) > 0:
            self._executor.spin_once(timeout_sec=left)

    def ready(self) -> None:
        """Ask until there is an answer; raises RuntimeError when there never is."""
        begin = monotonic()
        while self.sample(50.0) is None:
            if monotonic() - begin > PATIENCE:
                raise RuntimeError(f"There was no answer in {PATIENCE:g} s.")

    def sample(self, rate: float) -> dict[str, float] | None:
        """Ask, wait for all answers, sleep the rest of a period; return ms, None without an answer."""
        period = random.uniform(0.5, 1.5) / rate
        start = monotonic()
        self._times = {}
        begin = self._send()
        while len(self._times) < len(self.answers) and monotonic() - start < LOST:
            self._executor.spin_once(timeout_sec=0.1)
        found = {name: (at - begin) * 1e-6 for name, at in self._times.items()}
        self._spin_until(start + period)
        return found if len(found) == len(self.answers) else None


class Bench(Asking):
    """Plays the bench to a monitor."""

    answers = ("trip", "warning")

    def _open(self) -> None:
        from diagnostic_msgs.msg import DiagnosticStatus
        from rclpy.qos import QoSProfile
        from std_msgs.msg import Bool, Float64

        from seat_gear_dynamics.logs import topics

        self._inside = False
        self._float = Float64
        qos = QoSProfile(depth=10)
        self._speed = self._node.create_publisher(Float64, topics.MOTOR_SPEED.name, qos)
        self._load = self._node.create_publisher(Float64, topics.LOAD_TORQUE.name, qos)
        self._node.create_subscription(Bool, topics.IN_FORBIDDEN_BAND.name, self._on_trip, qos)
        self._node.create_subscription(DiagnosticStatus, topics.CHAOS_WARNING.name, self._on_warning, qos)

    def _send(self) -> int:
        self._inside = not self._inside
        self._load.publish(self._float(data=LOAD))
        begin = perf_counter_ns()
        self._speed.publish(self._float(data=SPEEDS[self._inside]))
        return begin

    def _on_trip(self, message: Any) -> None:
        if message.data == self._inside:
            self._heard("trip")

    def _on_warning(self, message: Any) -> None:
        # An error of the running model may outlast the band: the text that names the band is this sample's answer.
        if ("inside the forbidden band" in message.message) == self._inside:
            self._heard("warning")


class Caller(Asking):
    """Calls numbers to an echo."""

    answers = ("pong",)

    def _open(self) -> None:
        from rclpy.qos import QoSProfile
        from std_msgs.msg import Float64

        from benchmarks.echo import DEPTH, PING, PONG

        self._float, self._number = Float64, 0.0
        self._ping = self._node.create_publisher(Float64, PING, QoSProfile(depth=DEPTH))
        self._node.create_subscription(Float64, PONG, self._on_pong, QoSProfile(depth=DEPTH))

    def _send(self) -> int:
        self._number += 1.0
        begin = perf_counter_ns()
        self._ping.publish(self._float(data=self._number))
        return begin

    def _on_pong(self, message: Any) -> None:
        if message.data == self._number:
            self._heard("pong")


@contextmanager
def burners(count: int) -> Iterator[None]:
    """Keep `count` processes busy."""
    started = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(count)]
    try:
        yield
    finally:
        for process in started:
            process.kill()
            process.wait()


def main() -> None:
    """Measure and print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help=f"{SHORT} samples in place of {FULL}")
    parser.add_argument("--rate", type=float, default=RATE, help=f"samples a second (default {RATE:g})")
    arguments = parser.parse_args()
    found = measure(
        short=arguments.short, progress=lambda line: print(line, file=sys.stderr, flush=True), rate=arguments.rate
    )
    print(json.dumps(found.as_dict(), indent=1))


if __name__ == "__main__":
    main()
