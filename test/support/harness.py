"""Nodes as real processes, and a node of the test's own that talks to them."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import Any

PATIENCE = 60.0  # s; a first start compiles the model


class Processes:
    """Starts nodes and scripts, and ends whatever still runs when the test is over."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._running: list[subprocess.Popen[bytes]] = []

    def start(self, *command: str) -> subprocess.Popen[bytes]:
        """Start a Python program; its words go to a file that `words` reads."""
        process = subprocess.Popen(
            [sys.executable, *command],
            stdout=(self._folder / f"{len(self._running)}.out").open("wb"),
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            env=os.environ.copy(),
        )
        self._running.append(process)
        return process

    def node(self, name: str, *extra: str, **parameters: object) -> subprocess.Popen[bytes]:
        """Start one of the package's nodes with parameters."""
        flags = [part for key, value in parameters.items() for part in ("-p", f"{key}:={value}")]
        return self.start("-m", f"seat_gear_dynamics.nodes.{name}", "--ros-args", *flags, *extra)

    def words(self, process: subprocess.Popen[bytes]) -> str:
        """Return what a process has printed so far."""
        return (self._folder / f"{self._running.index(process)}.out").read_text()

    def end(self, process: subprocess.Popen[bytes], number: int = signal.SIGINT) -> int:
        """Signal a process and return its exit code."""
        process.send_signal(number)
        return process.wait(PATIENCE)

    def close(self) -> None:
        """Kill what still runs."""
        for process in self._running:
            if process.poll() is None:
                process.kill()
                process.wait()


class Peer:
    """A node of the test's own: publishes inputs and keeps every message of the monitor."""

    def __init__(self) -> None:
        import rclpy
        from rclpy.node import Node
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from rosidl_runtime_py.utilities import get_message

        from seat_gear_dynamics.logs import topics

        self._spin_once = rclpy.spin_once
        self.node: Any = Node("test_peer")
        self.messages: dict[str, list[Any]] = {}
        for topic in topics.TOPICS:
            if topic.direction == "out":
                durability = getattr(DurabilityPolicy, topic.durability.upper())
                self.messages[topic.name] = []
                self.node.create_subscription(
                    get_message(topic.type),
                    topic.name,
                    self.messages[topic.name].append,
                    QoSProfile(depth=1000, durability=durability),
                )
        # Deep enough for a test's whole burst: keep-last drops what a slow reader has not taken.
        self._publishers = {
            topic.name: self.node.create_publisher(get_message(topic.type), topic.name, QoSProfile(depth=1000))
            for topic in topics.TOPICS
            if topic.direction == "in"
        }

    def wait(self, reached: Callable[[], bool], what: str, patience: float = PATIENCE) -> None:
        """Spin until `reached`, or fail."""
        begin = monotonic()
        while not reached():
            self._spin_once(self.node, timeout_sec=0.05)
            assert monotonic() - begin < patience, f"waited {patience} s for {what}"

    def wait_for_subscriber(self, topic: str) -> None:
        """Wait until somebody listens to an input."""
        self.wait(lambda: self._publishers[topic].get_subscription_count() > 0, f"a subscriber of {topic}")

    def publish(self, topic: str, message: Any) -> None:
        """Publish on an input topic."""
        self._publishers[topic].publish(message)

    def drive(self, rpm: float, load: float = 600.0) -> None:
        """Publish one load and one speed."""
        from std_msgs.msg import Float64

        from seat_gear_dynamics.gears.units import RPM

        self.publish("load/torque", Float64(data=load))
        self.publish("motor/speed", Float64(data=rpm * RPM))

    def drive_until(self, rpm: float, reached: Callable[[], bool], what: str, load: float = 600.0) -> None:
        """Publish 100 samples a second until `reached`, or fail."""
        begin = last = monotonic()
        while not reached():
            self._spin_once(self.node, timeout_sec=0.005)
            if monotonic() - last >= 0.01:
                last = monotonic()
                self.drive(rpm, load)
            assert last - begin < PATIENCE, f"waited {PATIENCE} s for {what}"

    def warnings(self) -> list[Any]:
        """Return the warnings heard so far."""
        return self.messages["gear_monitor/chaos_warning"]

    def level(self) -> int | None:
        """Return the level of the last warning heard."""
        return self.warnings()[-1].level[0] if self.warnings() else None

    def text(self) -> str:
        """Return the text of the last warning heard."""
        return str(self.warnings()[-1].message) if self.warnings() else ""
