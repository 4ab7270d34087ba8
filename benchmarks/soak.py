"""A long run of the monitor in simulated time: `python -m benchmarks.soak [--minutes M]` prints one JSON object.

The monitor runs as a process with `use_sim_time`, and this process is bench and clock: the simulated bench's up-down
profile at 50 Hz, round after round, each sample with its /clock, the next as soon as the monitor has taken the last. So
an hour takes some minutes, and lasts exactly an hour of the model. Looked at are resident memory, whose slope after the
first tenth is to be flat (a slope by Theil and Sen: the median of all slopes, which no single step moves), deadline
misses and restarts as the node counts them itself, and samples that went unanswered.

Limit: what wears out with real time alone (sockets, leases, the system's clock) is not seen.
"""

import argparse
import json
import random
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from benchmarks import machine
from benchmarks.node import memory, processor_seconds
from benchmarks.processes import monitor
from benchmarks.ratio import Findings, Ratio

MINUTES, SHORT_MINUTES = 60.0, 10.0
RATE = 50
PROFILE = "up-down"
SETTINGS = ("use_sim_time:=true", "input:=joint_states")  # whose stamps cannot overtake their clock
LOST = 2.0  # s after which a sample counts as unanswered
PATIENCE = 120.0
EVERY = 10.0  # simulated s between two looks at the memory
FLAT = 5.0  # MB an hour


def measure(
    *, short: bool = False, minutes: float | None = None, progress: Callable[[str], None] | None = None
) -> Findings:
    """Return memory over simulated time, deadline misses and restarts."""
    lasting = minutes or (SHORT_MINUTES if short else MINUTES)
    if progress is not None:
        progress(f"soak, {lasting:g} simulated minutes")
    domain = random.SystemRandom().randrange(1, 100)
    with (
        tempfile.TemporaryDirectory(prefix="seat_gear_soak_") as folder,
        monitor(domain, Path(folder), SETTINGS) as process,
        Bench(domain) as bench,
    ):
        begin, spent = monotonic(), processor_seconds(process.pid)
        rows = bench.play(lasting * 60.0, lambda: memory(process.pid)["VmRSS"])
        figures: dict[str, Any] = {
            "machine": machine.description(),
            "simulated_minutes": lasting,
            "took_seconds": monotonic() - begin,
            "processor_seconds": processor_seconds(process.pid) - spent,
            "samples": bench.sent,
            "unanswered": bench.unanswered,
            **memory_figures(rows),
            "node": bench.health(),
        }
    slope = float(figures["megabytes_per_hour"])
    meaning = "growth of the monitor's resident memory in simulated time, MB an hour"
    return Findings(figures, {"memory_growth": Ratio((slope,), meaning, better="lower", reach=FLAT)})


def memory_figures(rows: list[tuple[float, float]]) -> dict[str, float]:
    """Return first, last, most (MB) and slope (MB an hour) of (simulated s, MB), without the first tenth."""
    kept = np.array(rows[len(rows) // 10 :])
    t, megabytes = kept.T
    first, second = np.triu_indices(len(kept), k=1)
    slopes = (megabytes[second] - megabytes[first]) / (t[second] - t[first])
    return {
        "megabytes_first": float(megabytes[0]),
        "megabytes_last": float(megabytes[-1]),
        "megabytes_most": float(megabytes.max()),
        "megabytes_per_hour": float(np.median(slopes)) * 3600.0,
    }


class Bench:
    """Clock and bench in this process."""

    def __init__(self, domain: int) -> None:
        import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)

        # isort: split
        import rclpy

        self._rclpy, self._domain = rclpy, domain
        self.sent = self.unanswered = 0
        self._taken = 0
        self._health: dict[str, tuple[int, str, dict[str, str]]] = {}
        self._worst: dict[str, int] = {}

    def __enter__(self) -> "Bench":
        from diagnostic_msgs.msg import DiagnosticArray
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from rclpy.qos import QoSProfile
        from rclpy.signals import SignalHandlerOptions
        from rosgraph_msgs.msg import Clock
        from sensor_msgs.msg import JointState

        from seat_gear_dynamics.logs import topics

        self._rclpy.init(args=[], domain_id=self._domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node: Any = Node("benchmark_soak")
        self._executor: Any = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._state, self._time = JointState, Clock
        qos = QoSProfile(depth=10)
        self._clock = self._node.create_publisher(Clock, "/clock", qos)
        self._joint = self._node.create_publisher(JointState, topics.JOINT_STATES.name, qos)
        self._node.create_subscription(JointState, topics.MODEL_INPUT.name, self._on_input, qos)
        self._node.create_subscription(DiagnosticArray, topics.DIAGNOSTICS.name, self._on_diagnostics, qos)
        return self

    def __exit__(self, *error: object) -> None:
        self._node.destroy_node()
        self._rclpy.try_shutdown()

    def _on_input(self, message: Any) -> None:
        self._taken = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec

    def _on_diagnostics(self, message: Any) -> None:
        for status in message.status:
            part, level = status.name.partition(": ")[2], status.level[0]
            self._health[part] = (level, status.message, {value.key: value.value for value in status.values})
            self._worst[part] = max(self._worst.get(part, 0), level)

    def play(self, seconds: float, look: Callable[[], float]) -> list[tuple[float, float]]:
        """Play so many simulated seconds; return (simulated s, what `look` saw), every EVERY seconds."""
        from seat_gear_dynamics.bench.drive import SimulatedBench
        from seat_gear_dynamics.bench.profiles import profile

        played = profile(PROFILE)
        begin, rows, samples = 10**12, list[tuple[float, float]](), round(seconds * RATE)
        self._ready(begin)
        bench = SimulatedBench(played, sample_time=1.0 / RATE, seed=0)
        for k in range(samples):
            if k % round(EVERY * RATE) == 0:
                rows.append((k / RATE, look()))
            sample = bench.step()
            self._sample(begin + (k + 1) * 10**9 // RATE, sample.speed, sample.load)
        return rows

    def _ready(self, now: int) -> None:
        """Repeat the sample before the first until the monitor takes it; raises RuntimeError when it never does."""
        start = monotonic()
        while self._taken != now:
            self._send(now, 0.0, 600.0)
            self._executor.spin_once(timeout_sec=0.05)
            if monotonic() - start > PATIENCE:
                raise RuntimeError(f"The monitor took no sample in {PATIENCE:g} s.")

    def _sample(self, now: int, speed: float, load: float) -> None:
        self._send(now, speed, load)
        self.sent += 1
        start = monotonic()
        while self._taken != now and monotonic() - start < LOST:
            self._executor.spin_once(timeout_sec=0.1)
        self.unanswered += self._taken != now

    def _send(self, now: int, speed: float, load: float) -> None:
        clock = self._time()
        clock.clock.sec, clock.clock.nanosec = divmod(now, 10**9)
        self._clock.publish(clock)
        joint = self._state(name=["seat_height"], velocity=[speed], effort=[load])
        joint.header.stamp = clock.clock
        self._joint.publish(joint)

    def health(self) -> dict[str, Any]:
        """Return what the node said of itself at last, and the worst level of each part."""
        found = {
            key: float(self._health[part][2][key])
            for part, keys in (
                ("solver", ("publish deadlines missed", "restarts, gap", "restarts, diverged")),
                ("input", ("samples accepted", "refused, late", "refused, duplicate")),
            )
            for key in keys
        }
        return {**found, "worst_level": dict(self._worst)}


def main() -> None:
    """Measure and print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=MINUTES, help=f"of simulated time (default {MINUTES:g})")
    arguments = parser.parse_args()
    found = measure(minutes=arguments.minutes, progress=lambda line: print(line, file=sys.stderr, flush=True))
    print(json.dumps(found.as_dict(), indent=1))


if __name__ == "__main__":
    main()
