"""The recorder node: the contract's topics, serialized as they come, into a bag; started and stopped by services."""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosidl_runtime_py.utilities import get_message
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from seat_gear_dynamics import __version__
from seat_gear_dynamics.gears import DescriptionError, load_train
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.recording import Recording
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.parameters import Parameter, declare
from seat_gear_dynamics.nodes.process import StartError, run
from seat_gear_dynamics.sensing import Level

NAME = "bench_recorder"

PARAMETERS = (
    Parameter("output", "", "directory of the log, must not exist; empty: seat_gear_log_<date and time>"),
    Parameter("system", "", "system description kept in the log; empty: the packaged height adjuster"),
    Parameter("autostart", True, "record from the beginning; false: wait for ~/start"),
    Parameter("compression", "zstd", "of the chunks: zstd, lz4 or none"),
    Parameter("chunk_bytes", 1_000_000, "size at which a chunk is closed", 1_000, 100_000_000),
    Parameter("sync_interval", 1.0, "most that a crash can lose, s", 0.05, 60.0),
    Parameter("split_bytes", 0, "size at which a new file begins; 0: never", 0, 2**62),
    Parameter("split_seconds", 0.0, "duration after which a new file begins; 0: never", 0.0, 1e9),
    Parameter("snapshot_seconds", 10.0, "length of the ring that ~/snapshot writes", 0.1, 600.0),
)

_DEPTH = 1000  # an fsync may take a while; what comes meanwhile waits here
_ADAPT_PERIOD = 1.0


class Recorder(Node):
    """Subscribes to the declared topics and hands their bytes to a recording."""

    def __init__(self) -> None:
        super().__init__(NAME)
        self._settings = declare(self, PARAMETERS)
        self._qos: dict[str, QoSProfile] = {}
        self._subscriptions_by_topic: dict[str, Any] = {}
        self._types = {self.resolve_topic_name(topic.name): topic for topic in topics.TOPICS}
        self._recording = self._make_recording()
        for name, topic in self._types.items():
            self._subscribe(name, topic, ReliabilityPolicy.RELIABLE)
        self._services_on()
        self._diagnostics = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS.name, QoSProfile(depth=10))
        self.create_timer(self._settings["sync_interval"], self._on_sync)
        self.create_timer(_ADAPT_PERIOD, self._on_adapt)
        self.create_timer(1.0, self._on_diagnostics)
        if self._settings["autostart"]:
            self.get_logger().info(f"recording to {self._start()}")
        self._on_diagnostics()

    def close(self) -> None:
        """Finish the log."""
        if self._recording.state in ("recording", "paused"):
            self._guard(self._recording.stop)

    def _make_recording(self) -> Recording:
        get = self._settings.__getitem__
        try:
            train = load_train(get("system") or None)
        except DescriptionError as error:
            raise StartError(str(error)) from error

        def make_writer(directory: Path) -> BagWriter:
            return BagWriter(
                directory,
                system_text=train.text,
                system_hash=sha256(train.text.encode()).hexdigest(),
                software_version=__version__,
                chunk_size=get("chunk_bytes"),
                compression=get("compression"),
                sync_interval_s=get("sync_interval"),
                max_size_bytes=get("split_bytes") or None,
                max_duration_s=get("split_seconds") or None,
            )

        output = get("output") or f"seat_gear_log_{datetime.now():%Y%m%d_%H%M%S}"
        declared = {name: (topic.type, topic.qos) for name, topic in self._types.items()}
        return Recording(Path(output).absolute(), make_writer, declared, ring_seconds=get("snapshot_seconds"))

    def _start(self) -> Path:
        try:
            return self._recording.start()
        except LogError as error:
            raise StartError(str(error)) from error

    def _subscribe(self, name: str, topic: topics.Topic, reliability: ReliabilityPolicy) -> None:
        latched = topic.durability == "transient_local"
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        qos = QoSProfile(depth=_DEPTH, reliability=reliability, durability=durability)
        old = self._subscriptions_by_topic.pop(name, None)
        if old is not None:
            self.destroy_subscription(old)
        receive = partial(self._on_message, name)

        def callback(data: bytes, info: Mapping[str, int]) -> None:  # rclpy counts a plain function's arguments
            receive(data, info)

        self._subscriptions_by_topic[name] = self.create_subscription(
            get_message(topic.type), name, callback, qos, raw=True
        )
        self._qos[name] = qos

    def _services_on(self) -> None:
        actions: dict[str, Callable[[], str]] = {
            "start": lambda: f"recording to {self._recording.start()}",
            "stop": lambda: self._told(self._recording.stop, "stopped"),
            "pause": lambda: self._told(self._recording.pause, "paused"),
            "resume": lambda: self._told(self._recording.resume, "recording"),
            "split": self._split,
            "snapshot": self._snapshot,
        }
        for name, action in actions.items():
            self.create_service(Trigger, f"~/{name}", partial(self._on_service, action))

    def _on_service(self, action: Callable[[], str], request: Any, response: Any) -> Any:
        try:
            response.success, response.message = True, action()
        except LogError as error:
            response.success, response.message = False, str(error)
        self.get_logger().info(response.message)
        self._on_diagnostics()
        return response

    def _told(self, action: Callable[[], None], text: str) -> str:
        action()
        return text

    def _split(self) -> str:
        path = self._recording.split(self._now())
        return f"now writing {path}" if path else "nothing to split: the present file holds no message yet"

    def _snapshot(self) -> str:
        directory, count = self._recording.snapshot()
        return f"{count} messages in {directory}"

    def _on_message(self, topic: str, data: bytes, info: Mapping[str, int]) -> None:
        received = int(info["received_timestamp"]) or self._now()
        published = int(info["source_timestamp"]) or received
        self._guard(partial(self._recording.receive, topic, bytes(data), received, published))

    def _on_sync(self) -> None:
        self._guard(partial(self._recording.sync, self._now()))

    def _on_adapt(self) -> None:
        """Follow publishers that offer only best effort: a reliable subscription would not hear them."""
        for name, topic in self._types.items():
            if self._qos[name].reliability != ReliabilityPolicy.RELIABLE:
                continue
            offers = [p.qos_profile.reliability for p in self.get_publishers_info_by_topic(name)]
            if ReliabilityPolicy.BEST_EFFORT in offers:
                self.get_logger().info(f"{name} is offered best effort; recording it so")
                self._subscribe(name, topic, ReliabilityPolicy.BEST_EFFORT)

    def _on_diagnostics(self) -> None:
        recording = self._recording
        counters = recording.counters.values()
        values: dict[str, object] = {
            "state": recording.state,
            "file": recording.files[-1] if recording.files else "none",
            "received": recording.received.total(),
            "written": sum(c.written for c in counters),
            "dropped": sum(c.dropped for c in counters),
            "came while not recording": recording.not_recorded.total(),
            **{f"{topic.name} received": recording.received[name] for name, topic in self._types.items()},
        }
        level = Level.ERROR if recording.state == "failed" else Level.OK
        text = recording.failure or recording.state
        status = messages.status(level, f"{self.get_name()}: recording", text, values)
        self._diagnostics.publish(DiagnosticArray(header=Header(stamp=messages.stamp(self._now())), status=[status]))

    def _guard(self, action: Callable[[], object]) -> None:
        """Run a disk action; a refusal is reported and ends the log, not the node."""
        try:
            action()
        except LogError as error:
            self.get_logger().error(str(error), throttle_duration_sec=5.0)

    def _now(self) -> int:
        return int(self.get_clock().now().nanoseconds)


def main(args: Sequence[str] | None = None) -> int:
    """Run the recorder; returns its exit code."""
    return run(Recorder, args)


if __name__ == "__main__":
    raise SystemExit(main())
