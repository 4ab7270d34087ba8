"""The recorder's behaviour without ROS: start, stop, pause, resume, split, and a snapshot of the last seconds."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal, NamedTuple

from seat_gear_dynamics.logs.counters import Counters
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.topics import Qos
from seat_gear_dynamics.logs.writer import BagWriter

State = Literal["stopped", "recording", "paused", "failed"]
MakeWriter = Callable[[Path], BagWriter]


class _Kept(NamedTuple):
    topic: str
    data: bytes
    log_ns: int
    publish_ns: int


class Recording:
    """Takes serialized messages and keeps them in a bag while recording; times are arguments.

    `topics` maps absolute name to (type, quality of service). The first start writes `directory`; each later one
    `directory` with `_run2`, `_run3`, … A snapshot of the last `ring_seconds` goes to `directory` with `_snapshot1`, ….
    A log that fails is reported once by `LogError` and leaves the state `failed`; messages are then counted as lost.
    """

    def __init__(
        self, directory: Path, make_writer: MakeWriter, topics: Mapping[str, tuple[str, Qos]], *, ring_seconds: float
    ) -> None:
        self.directory = directory
        self.state: State = "stopped"
        self.received: Counter[str] = Counter()
        self.not_recorded: Counter[str] = Counter()
        """Messages that came while stopped, paused or failed, per topic."""
        self._make_writer = make_writer
        self._topics = dict(topics)
        self._ring: deque[_Kept] = deque()
        self._ring_ns = int(ring_seconds * 1e9)
        self._writer: BagWriter | None = None
        self._runs = self._snapshots = 0

    @property
    def counters(self) -> dict[str, Counters]:
        """Per topic of the present bag: received, written, dropped."""
        return self._writer.counters if self._writer else {}

    @property
    def files(self) -> tuple[Path, ...]:
        """The files of the present bag."""
        return self._writer.files if self._writer else ()

    @property
    def failure(self) -> str | None:
        """Why the present bag failed, or None."""
        return self._writer.failure if self._writer else None

    def receive(self, topic: str, data: bytes, log_ns: int, publish_ns: int) -> None:
        """Take one message; raises LogError once when the disk refuses it."""
        self.received[topic] += 1
        self._ring.append(_Kept(topic, data, log_ns, publish_ns))
        while self._ring and self._ring[0].log_ns < log_ns - self._ring_ns:
            self._ring.popleft()
        if self.state != "recording" or self._writer is None:
            self.not_recorded[topic] += 1
            return
        with _Failing(self):
            self._writer.write(topic, data, log_ns, publish_ns)

    def start(self) -> Path:
        """Begin a bag and return its directory."""
        if self.state in ("recording", "paused"):
            raise LogError(
                f"The recorder is {self.state} already ({self.directory}); stop it before starting another log."
            )
        self._runs += 1
        directory = self._named("run", self._runs) if self._runs > 1 else self.directory
        self._writer = self._open(directory)
        self.state = "recording"
        return directory

    def stop(self) -> None:
        """Finish the bag."""
        self._demand("stopped", "recording", "paused")
        assert self._writer is not None
        self.state = "stopped"
        with _Failing(self):
            self._writer.close()

    def pause(self) -> None:
        """Keep the bag open but record nothing until resumed."""
        self._demand("paused", "recording")
        self.state = "paused"

    def resume(self) -> None:
        """Go on recording after a pause."""
        self._demand("resumed", "paused")
        self.state = "recording"

    def split(self, now_ns: int) -> Path | None:
        """Begin the next file of the bag and return it; None when the present one holds nothing yet."""
        self._demand("split", "recording", "paused")
        assert self._writer is not None
        with _Failing(self):
            return self._writer.split(now_ns)

    def snapshot(self) -> tuple[Path, int]:
        """Write the ring to a bag of its own; return its directory and how many messages it holds."""
        if not self._ring:
            raise LogError("There is nothing to snapshot: no message has come yet. Wait for one.")
        self._snapshots += 1
        directory = self._named("snapshot", self._snapshots)
        with self._open(directory) as writer:
            for kept in self._ring:
                writer.write(*kept)
        return directory, len(self._ring)

    def sync(self, now_ns: int) -> None:
        """Bring what is written to the disk; call it regularly, topics may be silent."""
        if self._writer is not None and self.state in ("recording", "paused"):
            with _Failing(self):
                self._writer.sync(now_ns)

    def _open(self, directory: Path) -> BagWriter:
        writer = self._make_writer(directory)
        for name, (kind, qos) in self._topics.items():
            writer.add_topic(name, kind, qos)
        return writer

    def _named(self, kind: str, number: int) -> Path:
        return self.directory.with_name(f"{self.directory.name}_{kind}{number}")

    def _demand(self, verb: str, *states: State) -> None:
        if self.state not in states:
            raise LogError(f"The recorder is {self.state} and cannot be {verb}; it has to be {' or '.join(states)}.")


class _Failing:
    """Marks the recording as failed when the disk refuses, and lets the error through."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if isinstance(error, LogError) and self._recording.failure is not None:
            self._recording.state = "failed"
