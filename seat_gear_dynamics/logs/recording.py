"""The recorder's behaviour without ROS: start, stop, pause, resume, split, and a snapshot of the last seconds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal

from seat_gear_dynamics.logs.batch import Batch
from seat_gear_dynamics.logs.counters import Counters
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.snapshot import EventTrigger, Ring
from seat_gear_dynamics.logs.space import Space, SpaceWatch
from seat_gear_dynamics.logs.topics import Qos
from seat_gear_dynamics.logs.writer import BagWriter

State = Literal["stopped", "recording", "paused", "failed"]
MakeWriter = Callable[[Path], BagWriter]

_LEVEL = 4  # where a DiagnosticStatus has its level: the first byte behind the CDR header
_RING_BYTES = 200_000_000


class Recording:
    """Takes serialized messages and keeps them in a bag while recording; times are arguments.

    `topics` maps absolute name to (type, quality of service); `add_topic` adds to them. The first start writes
    `directory`; each later one `directory` with `_run2`, `_run3`, … A snapshot of the last `ring_seconds` goes to
    `directory` with `_snapshot1`, …; with a `trigger`, also by itself after the warning on `trigger_topic` has begun.
    A log that fails is reported once by `LogError` and leaves the state `failed`; messages are then counted as lost.
    """

    def __init__(
        self,
        directory: Path,
        make_writer: MakeWriter,
        topics: Mapping[str, tuple[str, Qos]],
        *,
        ring_seconds: float,
        ring_bytes: int = _RING_BYTES,
        trigger: EventTrigger | None = None,
        trigger_topic: str = "",
        space: SpaceWatch | None = None,
    ) -> None:
        self.directory = directory
        self.state: State = "stopped"
        self.received: Counter[str] = Counter()
        self.not_recorded: Counter[str] = Counter()
        """Messages that came while stopped, paused or failed, or before the clock ran, per topic."""
        self.lost: Counter[str] = Counter()
        """Messages that were overwritten before they could be received, per topic."""
        self.datagrams = 0
        self.space: Space | None = None
        self.snapshots: list[Path] = []
        self._make_writer = make_writer
        self._topics: dict[str, tuple[str, Qos]] = {}
        self._ring = Ring(ring_seconds, ring_bytes)
        self._trigger, self._trigger_topic = trigger, trigger_topic if trigger else ""
        self._space_watch = space
        self._writer: BagWriter | None = None
        self._stopped_because: str | None = None
        self._past: dict[str, Counters] = {}
        self._lost_here: Counter[str] = Counter()
        self._runs = self._tried = 0
        for name, (kind, qos) in topics.items():
            self.add_topic(name, kind, qos)

    @property
    def counters(self) -> dict[str, Counters]:
        """Per topic of the present bag: received, written, dropped."""
        return self._writer.counters if self._writer else {}

    @property
    def totals(self) -> dict[str, Counters]:
        """Per topic of all bags so far: received (while not recording too), written, dropped."""
        now = self.counters
        totals = {}
        for name in self._topics:
            past, present = self._past.get(name, _NONE), now.get(name, _NONE)
            written, dropped = past.written + present.written, past.dropped + present.dropped
            totals[name] = Counters(self.received[name], written, dropped)
        return totals

    @property
    def files(self) -> tuple[Path, ...]:
        """The files of the present bag."""
        return self._writer.files if self._writer else ()

    @property
    def failure(self) -> str | None:
        """Why the present bag failed or was ended before it was told to, or None."""
        return self._stopped_because or (self._writer.failure if self._writer else None)

    def add_topic(self, name: str, type: str, qos: Qos) -> None:
        """Record the absolute topic `name` from now on; raises `LogError` for a type that a log cannot describe."""
        schema(type)
        self._topics[name] = (type, qos)
        if qos.durability == "transient_local":
            self._ring.latch(name)
        if self._writer is not None and self.state in ("recording", "paused"):
            with _Failing(self):
                self._writer.add_topic(name, type, qos)

    def receive(self, topic: str, data: bytes, log_ns: int, publish_ns: int) -> None:
        """Take one message; raises LogError once when the disk refuses it."""
        self.received[topic] += 1
        self._ring.add(topic, data, log_ns, publish_ns)
        if self.state == "recording" and self._writer is not None:
            try:
                self._writer.write(topic, data, log_ns, publish_ns)
            except LogError:
                self._note_failure()
                raise
        else:
            self.not_recorded[topic] += 1
        if topic == self._trigger_topic:
            self._warned(data, log_ns)

    def receive_batch(self, batch: Batch) -> None:
        """Take messages as `receive` would one after the other; raises LogError once when the disk refuses them."""
        if not len(batch):
            return
        counts = batch.counts()
        self.received.update(counts)
        self._ring.add_batch(batch)
        for kept in batch.of(frozenset((self._trigger_topic,))):
            self._warned(kept.data, kept.log_ns)
        if self.state != "recording" or self._writer is None:
            self.not_recorded.update(counts)
            return
        with _Failing(self):
            self._writer.write_batch(batch)

    def _warned(self, status: bytes, log_ns: int) -> None:
        if self._trigger is not None and len(status) > _LEVEL:
            self._trigger.update(status[_LEVEL], log_ns)

    def ignore(self, topic: str, count: int = 1) -> None:
        """Count messages that cannot be recorded because their time is not known."""
        self.received[topic] += count
        self.not_recorded[topic] += count

    def note_lost(self, totals: Mapping[str, int], datagrams: int = 0) -> dict[str, int]:
        """Take how many messages of each topic were lost so far before they could be received; return what is new.

        `datagrams` are those that the system dropped so far, of whatever topic. What is lost while recording stands
        in the bag as `lost unread of TOPIC` and `datagrams dropped by the system`.
        """
        news = {name: total - self.lost[name] for name, total in totals.items() if total > self.lost[name]}
        here = {f"lost unread of {name}": count for name, count in news.items()}
        if datagrams > self.datagrams:
            here["datagrams dropped by the system"] = datagrams - self.datagrams
        self.lost.update(news)
        self.datagrams = max(datagrams, self.datagrams)
        if self.state == "recording" and self._writer is not None:
            self._lost_here.update(here)
            self._writer.custom_data.update({key: str(self._lost_here[key]) for key in here})
        return news

    def start(self) -> Path:
        """Begin a bag and return its directory."""
        if self.state in ("recording", "paused"):
            raise LogError(
                f"The recorder is {self.state} already ({self.directory}); stop it before starting another log."
            )
        if self.space is not None and self.space.room == "full":
            raise LogError(f"The disk of {self.directory} is full ({self.space.text}); make room, then start.")
        self._runs += 1
        directory = self._named("run", self._runs) if self._runs > 1 else self.directory
        writer = self._open(directory)
        self._past = {n: _sum(self._past.get(n, _NONE), c) for n, c in self.counters.items()} | {
            n: c for n, c in self._past.items() if n not in self.counters
        }
        self._writer, self._stopped_because = writer, None
        self._lost_here.clear()
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

    def snapshot(self, why: str = "asked for") -> tuple[Path, int]:
        """Write the ring to a bag of its own; return its directory and how many messages it holds."""
        parts = self._ring.parts()
        if not parts:
            raise LogError("There is nothing to snapshot: no message has come yet. Wait for one.")
        self._tried += 1
        directory = self._named("snapshot", self._tried)
        with self._open(directory) as writer:
            writer.custom_data["snapshot"] = why
            for part in parts:
                if isinstance(part, Batch):
                    writer.write_batch(part)
                else:
                    writer.write(*part)
            count = sum(counters.received for counters in writer.counters.values())
        self.snapshots.append(directory)
        return directory, count

    def take_due_snapshot(self, now_ns: int, *, ending: bool = False) -> Path | None:
        """Write the snapshot of a warning that began, if one is due (at the recorder's end: waits) and return it."""
        trigger = self._trigger
        if trigger is None or not (trigger.due(now_ns) or (ending and trigger.waiting)):
            return None
        trigger.taken(now_ns)
        return self.snapshot("a warning began")[0]

    def watch_space(self, t: float, free: int) -> None:
        """Take the free bytes of the disk at `t` (s, steady); at the reserve the bag ends, with a `LogError`."""
        if self._space_watch is None:
            return
        self.space = self._space_watch.update(t, free)
        if self.space.room != "full" or self._writer is None or self.state not in ("recording", "paused"):
            return
        text = f"The log {self._writer.directory} was ended because its disk is full ({self.space.text}); make room."
        self._stopped_because = self._writer.custom_data["failure"] = text
        self.stop()
        self.state = "failed"
        raise LogError(text)

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

    def _note_failure(self) -> None:
        if self._writer is not None and self._writer.failure is not None:
            self.state = "failed"


_NONE = Counters(0, 0, 0)


def _sum(one: Counters, other: Counters) -> Counters:
    return Counters(*(a + b for a, b in zip(one, other, strict=True)))


class _Failing:
    """Marks the recording as failed when the disk refuses, and lets the error through."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if isinstance(error, LogError):
            self._recording._note_failure()
