"""The recorder node: topics, serialized as they come, into a bag; started and stopped by services."""

import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from seat_gear_dynamics import __version__
from seat_gear_dynamics.gears import DescriptionError, GearTrain, load_train
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.batch import Batch
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.presets import preset
from seat_gear_dynamics.logs.recording import Recording
from seat_gear_dynamics.logs.snapshot import EventTrigger
from seat_gear_dynamics.logs.space import SpaceWatch
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.parameters import Parameter, declare
from seat_gear_dynamics.nodes.process import StartError, run
from seat_gear_dynamics.nodes.recorder_datagrams import Datagrams
from seat_gear_dynamics.nodes.recorder_intake import make_intake
from seat_gear_dynamics.nodes.recorder_report import RecorderReport
from seat_gear_dynamics.nodes.recorder_topics import Subscriptions, choose

NAME = "bench_recorder"

PARAMETERS = (
    Parameter("output", "", "directory of the log, must not exist; empty: seat_gear_log_<date and time>"),
    Parameter("system", "", "system description kept in the log; empty: the packaged height adjuster"),
    Parameter("autostart", True, "record from the beginning; false: wait for ~/start"),
    Parameter("topics", "contract", "contract, all, or names separated by blanks; contract may be among them"),
    Parameter("pattern", "", "regular expression; topics whose absolute name it finds are recorded too"),
    Parameter("exclude", "", "regular expression; topics whose absolute name it finds are not recorded"),
    Parameter("preset", "zstd_fast", "how chunks are packed: none, fastwrite, zstd_fast or zstd_small"),
    Parameter("compression", "", "of the chunks: zstd, lz4 or none; empty: the preset's"),
    Parameter("chunk_bytes", 0, "size at which a chunk is closed; 0: the preset's", 0, 100_000_000),
    Parameter("sync_interval", 1.0, "most that a crash can lose, s", 0.05, 60.0),
    Parameter("split_bytes", 0, "size at which a new file begins; 0: never", 0, 2**62),
    Parameter("split_seconds", 0.0, "duration after which a new file begins; 0: never", 0.0, 1e9),
    Parameter("keep_files", 0, "files kept, the oldest go first; 0: all", 0, 1_000_000),
    Parameter("keep_bytes", 0, "bytes of finished files kept, the oldest go first; 0: all", 0, 2**62),
    Parameter("snapshot_seconds", 10.0, "length of the ring that a snapshot writes", 0.1, 600.0),
    Parameter("snapshot_bytes", 200_000_000, "memory that the ring may take", 100_000, 2**40),
    Parameter("snapshot_on", "error", "level of the chaos warning that takes a snapshot by itself: error, warn, never"),
    Parameter("snapshot_after", 2.0, "time from a warning's beginning to its snapshot, s", 0.0, 600.0),
    Parameter("snapshot_limit", 20, "most snapshots that warnings take in one run of the node", 0, 100_000),
    Parameter("disk_reserve_bytes", 100_000_000, "free bytes of the disk at which the log is ended", 0, 2**62),
    Parameter("disk_warn_seconds", 600.0, "WARN when the reserve is reached within this time, s", 0.0, 1e9),
    Parameter("queue_depth", 10_000, "messages of a topic that may wait while the disk is busy", 1, 1_000_000),
)

_THRESHOLDS = {"warn": 1, "error": 2}
_PERIOD = 1.0  # s between two looks at the network and the disk
_DRAIN = 2.0  # s at most for what waits in the queues when the end is asked for


class Recorder(Node):
    """Hands the bytes of the chosen topics to a recording; decides nothing itself."""

    def __init__(self) -> None:
        super().__init__(NAME)
        self._settings = declare(self, PARAMETERS)
        self._sim_time = bool(self.get_parameter("use_sim_time").value)
        self._recording = self._make_recording()
        get = self._settings.__getitem__
        choice = choose(self, get("topics"), get("pattern"), get("exclude"))
        self._datagrams = Datagrams()
        self._intake = make_intake(self, self._on_message, self._on_batch)
        self._subscriptions_kept = Subscriptions(
            self, choice, get("queue_depth"), self._intake, self._recording.add_topic
        )
        names = {self.resolve_topic_name(topic.name): topic.name for topic in topics.TOPICS}
        self._report = RecorderReport(self._recording, self._subscriptions_kept, names)
        self._services_on()
        self._diagnostics = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS.name, QoSProfile(depth=10))
        self._on_space()
        # Disk and network go on while a simulated clock stands.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(get("sync_interval"), self._on_sync, clock=steady)
        self.create_timer(_PERIOD, self._on_period, clock=steady)
        if get("autostart"):
            self.get_logger().info(f"recording to {self._start()}")
        self._on_diagnostics()

    def close(self) -> None:
        """Record what still waits in the queues, take a snapshot that waits, and finish the log."""
        if not self._intake.drain(_DRAIN):
            self.get_logger().warning(f"the queues could not be emptied in {_DRAIN:g} s; what is left in them is lost")
        self._on_losses()
        self._guard(partial(self._recording.take_due_snapshot, self._now(), ending=True))
        if self._recording.state in ("recording", "paused"):
            self._guard(self._recording.stop)

    def _make_recording(self) -> Recording:
        get = self._settings.__getitem__
        try:
            make_writer = self._writer_maker(load_train(get("system") or None))
        except (DescriptionError, LogError) as error:
            raise StartError(str(error)) from error
        output = get("output") or f"seat_gear_log_{datetime.now():%Y%m%d_%H%M%S}"
        return Recording(
            Path(output).absolute(),
            make_writer,
            {},
            ring_seconds=get("snapshot_seconds"),
            ring_bytes=get("snapshot_bytes"),
            trigger=self._make_trigger(),
            trigger_topic=self.resolve_topic_name(topics.CHAOS_WARNING.name),
            space=SpaceWatch(reserve=get("disk_reserve_bytes"), warn_seconds=get("disk_warn_seconds")),
        )

    def _writer_maker(self, train: GearTrain) -> Callable[[Path], BagWriter]:
        get = self._settings.__getitem__
        packing = preset(get("preset"))
        return partial(
            BagWriter,
            system_text=train.text,
            system_hash=sha256(train.text.encode()).hexdigest(),
            software_version=__version__,
            chunk_size=get("chunk_bytes") or packing.chunk_size,
            compression=get("compression") or packing.compression,
            level=packing.level,
            sync_interval_s=get("sync_interval"),
            max_size_bytes=get("split_bytes") or None,
            max_duration_s=get("split_seconds") or None,
            keep_files=get("keep_files") or None,
            keep_bytes=get("keep_bytes") or None,
        )

    def _make_trigger(self) -> EventTrigger | None:
        get = self._settings.__getitem__
        level = get("snapshot_on")
        if level == "never":
            return None
        if level not in _THRESHOLDS:
            raise StartError(f"The parameter snapshot_on is {level!r}, expected 'error', 'warn' or 'never'.")
        spacing, after = get("snapshot_seconds"), get("snapshot_after")
        return EventTrigger(_THRESHOLDS[level], after=after, spacing=spacing, limit=get("snapshot_limit"))

    def _start(self) -> Path:
        try:
            return self._recording.start()
        except LogError as error:
            raise StartError(str(error)) from error

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
        arrived = time.time_ns()
        published = int(info["source_timestamp"]) or arrived
        self._report.heard(arrived - published)
        if self._sim_time:
            log_ns = self._now()
            if log_ns == 0:  # /clock has not begun: a log time of 1970 would spoil the log
                self._recording.ignore(topic)
                return
        else:
            log_ns = int(info["received_timestamp"]) or arrived
        try:
            self._recording.receive(topic, bytes(data), log_ns, published)
        except LogError as error:
            self._say(error)

    def _on_batch(self, batch: Batch) -> None:
        published = np.where(batch.publish_ns > 0, batch.publish_ns, batch.log_ns)
        self._report.heard(time.time_ns() - int(published.min()))
        log_ns = batch.log_ns
        if self._sim_time:
            now = self._now()
            if now == 0:  # as in _on_message
                for topic, count in batch.counts().items():
                    self._recording.ignore(topic, count)
                return
            log_ns = np.full(len(batch), now)
        self._guard(partial(self._recording.receive_batch, replace(batch, log_ns=log_ns, publish_ns=published)))

    def _on_losses(self) -> None:
        news = self._recording.note_lost(self._intake.lost(), self._datagrams.dropped())
        if news:
            text = ", ".join(f"{count} of {topic}" for topic, count in news.items())
            self.get_logger().warning(f"lost before they were read: {text}", throttle_duration_sec=5.0)

    def _on_sync(self) -> None:
        now = self._now()
        self._guard(partial(self._recording.sync, now))
        self._guard(partial(self._take_snapshot, now))

    def _take_snapshot(self, now_ns: int) -> None:
        path = self._recording.take_due_snapshot(now_ns)
        if path is not None:
            self.get_logger().warning(f"a warning began: the last seconds are in {path}")

    def _on_period(self) -> None:
        self._subscriptions_kept.look()
        self._on_losses()
        self._on_space()
        self._on_diagnostics()

    def _on_space(self) -> None:
        folder = next(parent for parent in self._recording.directory.parents if parent.exists())
        try:
            free = shutil.disk_usage(folder).free
        except OSError:
            return  # a disk that cannot be asked is one that writing will soon say the same of
        self._guard(partial(self._recording.watch_space, time.monotonic(), free))

    def _on_diagnostics(self) -> None:
        status = self._report.status(f"{self.get_name()}: recording")
        self._diagnostics.publish(DiagnosticArray(header=Header(stamp=messages.stamp(self._now())), status=[status]))

    def _guard(self, action: Callable[[], object]) -> None:
        """Run a disk action; a refusal is reported and ends the log, not the node."""
        try:
            action()
        except LogError as error:
            self._say(error)

    def _say(self, error: LogError) -> None:
        self.get_logger().error(str(error), throttle_duration_sec=5.0)

    def _now(self) -> int:
        return int(self.get_clock().now().nanoseconds)


def main(args: Sequence[str] | None = None) -> int:
    """Run the recorder; returns its exit code."""
    return run(Recorder, args)


if __name__ == "__main__":
    raise SystemExit(main())
