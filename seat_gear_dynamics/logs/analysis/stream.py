"""From a bag to batches: every message once, in order of log time, in memory that does not grow with the log."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.batches import (
    FORCE_COLUMNS,
    FORCE_NAMES,
    MESHES,
    STATE_COLUMNS,
    Array,
    Batch,
    Direction,
    Recent,
    Warned,
    empty,
)
from seat_gear_dynamics.logs.analysis.message_bytes import JointDecoder
from seat_gear_dynamics.logs.analysis.side_by_side import SideBySide, Stretches
from seat_gear_dynamics.logs.analysis.sources import Read, Source, holds, readers
from seat_gear_dynamics.logs.analysis.what_if import BANDS_KEY
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.flows import Flows
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.run import CloudPoints
from seat_gear_dynamics.logs.schemas import Decoder
from seat_gear_dynamics.sensing import BandSource

BATCH_SECONDS = 10.0
_TURN = 15 * RPM  # rad/s that |speed| has to move for its direction to be believed: beyond Hall steps and noise
_OTHER_CLOCK = 10_000_000_000  # ns between stamp and log time from which stamps are of another clock (simulated time)
_MOST_LABELS = 8  # of bands that are kept: a monitor that takes one map after the other is not met
_WORTH_IT = 180.0  # s of log from which the start of further processes pays
Handle = Callable[[int, bytes], None]


class Stream:
    """Reads a bag once, batch by batch; afterwards `flows` knows every topic.

    Drive, forces and section stand at their stamps, warnings at their log time. Stamps of another clock than the
    log's (simulated time) are shifted by what the first one is off.
    """

    def __init__(
        self,
        bag: Bag,
        train: GearTrain,
        source: Source | None = None,
        *,
        bands: BandSource | None = None,
        seconds: float = BATCH_SECONDS,
        workers: int = 1,
    ) -> None:
        """Choose the topics; raises `LogError` where the bag has no speed or no load, and for less than one worker.

        Outputs that a log does not hold are computed, warnings by `bands` (None: the published ones), those of a long
        log by `workers` processes; how many changes no bit of them.
        """
        if workers < 1:
            raise LogError(f"The number of processes is {workers}, expected at least 1.")
        self.bag = bag
        self.flows = Flows(bag.topics)
        self.estimated = not holds(bag, topics.MESH_FORCE.name)
        """Whether forces, section and warnings are computed here, because the log has none."""
        length = (bag.end_ns - bag.start_ns) * 1e-9
        workers = workers if length > _WORTH_IT else 1
        self._estimated = SideBySide(train, bands=bands, workers=workers) if self.estimated else None
        self._seconds = seconds
        self._drive_readers = readers(bag, source or Source())
        self._handlers: dict[str, Handle] = {}
        self._choose_handlers()
        self._force_joints, self._state_joints = JointDecoder(), JointDecoder()
        self._decoder = Decoder({})
        self._points = CloudPoints()
        self._direction, self._recent = Direction(_TURN), Recent()
        self._shift: int | None = None
        self._speed: float | None = None
        self._load: float | None = None
        self._last = -np.inf
        self._stated: dict[str, None] = {}
        self._clear()

    @property
    def stretches(self) -> Stretches | None:
        """In how many stretches outputs were computed, and how many of them in a row; None where they were logged."""
        return self._estimated.stretches if self._estimated is not None else None

    @property
    def stated_bands(self) -> tuple[str, ...]:
        """Labels of the bands that the warnings read so far name, in the order in which they came; the first few."""
        return tuple(self._stated)

    @property
    def drive_topics(self) -> tuple[str, ...]:
        """Where speed and load came from."""
        return tuple(self._drive_readers)

    def batches(self, progress: Callable[[int, int], None] | None = None) -> Iterator[Batch]:
        """Yield the batches; `progress` is told (messages read, messages in all) after each that was read."""
        recorded = self._recorded(progress)
        return recorded if self._estimated is None else self._estimated.batches(recorded)

    def _recorded(self, progress: Callable[[int, int], None] | None) -> Iterator[Batch]:
        """Yield what the log itself holds."""
        due, total, done = self.bag.start_ns + self._seconds * 1e9, self.bag.message_count, 0
        for message in self.bag.messages():
            topic, log_ns, publish_ns, data = message
            done += 1
            self.flows.add(topic, publish_ns)
            if log_ns >= due:
                yield self._flush()
                due = log_ns + self._seconds * 1e9
                if progress is not None:
                    progress(done, total)
            read = self._drive_readers.get(topic)
            if read is not None:
                self._take_drive(read, log_ns, publish_ns, data)
            handle = self._handlers.get(topic)
            if handle is not None:
                handle(log_ns, data)
        yield self._flush()
        if progress is not None:
            progress(done, total)

    def _choose_handlers(self) -> None:
        if self.estimated:
            return
        handlers: dict[str, Handle] = {
            topics.MESH_FORCE.name: self._take_force,
            topics.MESH_STATE.name: self._take_state,
            topics.POINCARE.name: self._take_cloud,
            topics.CHAOS_WARNING.name: self._take_warning,
        }
        self._handlers = {self.bag.resolve(name): h for name, h in handlers.items() if holds(self.bag, name)}

    def _take_drive(self, read: Read, log_ns: int, publish_ns: int, data: bytes) -> None:
        stamp_ns, speed, load = read(data)
        self._load = load if load is not None and np.isfinite(load) else self._load
        if speed is None or not np.isfinite(speed) or self._load is None:
            return
        # A Float64 has no stamp: the moment it was published is free of transport, where the bag knows it.
        t = self._time(stamp_ns if stamp_ns is not None else publish_ns or log_ns, log_ns)
        if t > self._last:  # a repeated or late sample; the monitor refuses it too
            self._last = t
            self._drive.append((t, speed, self._load))
        elif t < self._last - 1.0:  # the clock stepped back: follow it, or all that comes would be refused
            self._last = t

    def _take_force(self, log_ns: int, data: bytes) -> None:
        joint = self._force_joints.decode(data)
        values = joint.effort
        if joint.names != FORCE_NAMES:
            effort = dict(zip(joint.names, values, strict=False))
            values = tuple(effort.get(name, np.nan) for name in FORCE_NAMES)
        self._force.append((self._time(joint.stamp_ns, log_ns), *values))

    def _take_state(self, log_ns: int, data: bytes) -> None:
        joint = self._state_joints.decode(data)
        if joint.names != MESHES or not len(joint.position) == len(joint.velocity) == len(joint.effort) == 2:
            return
        values = (v for row in zip(joint.position, joint.velocity, joint.effort, strict=True) for v in row)
        self._state.append((self._time(joint.stamp_ns, log_ns), *values))

    def _take_cloud(self, log_ns: int, data: bytes) -> None:
        points = self._points.fresh(self._decoder.decode(data, topics.POINT_CLOUD), self.bag.path)
        if len(points):
            start = (self.bag.start_ns - (self._shift or 0)) * 1e-9
            self._sections.append(np.column_stack([points[:, 2] - start, points[:, :2]]))

    def _take_warning(self, log_ns: int, data: bytes) -> None:
        message: Any = self._decoder.decode(data, topics.DIAGNOSTIC_STATUS)
        values = {value.key: value.value for value in message.values}
        if BANDS_KEY in values and len(self._stated) < _MOST_LABELS:
            self._stated[values[BANDS_KEY]] = None
        t = (log_ns - self.bag.start_ns) * 1e-9
        self._warnings.append(Warned(t, int(message.level), message.message, values.get("regime", "undecided")))

    def _time(self, stamp_ns: int, log_ns: int) -> float:
        if self._shift is None:
            self._shift = log_ns - stamp_ns if abs(log_ns - stamp_ns) > _OTHER_CLOCK else 0
        return (stamp_ns + self._shift - self.bag.start_ns) * 1e-9

    def _flush(self) -> Batch:
        """Return what has come since the last flush."""
        batch = Batch(warnings=self._warnings)
        if self._drive:
            drive = np.array(self._drive)
            batch.drive = np.column_stack([drive, self._direction.follow(drive[:, 1])])
            self._recent.extend(batch.drive)
        batch.force, batch.state = self._forces(), np.array(self._state) if self._state else empty(STATE_COLUMNS)
        if self._sections:
            batch.section = self._recent.placed(np.concatenate(self._sections))
        self._clear()
        return batch

    def _forces(self) -> Array:
        if not self._force:
            return empty(FORCE_COLUMNS)
        force = np.array(self._force)
        return np.column_stack([force, self._recent.at(force[:, 0], "speed"), self._recent.at(force[:, 0], "load")])

    def _clear(self) -> None:
        self._drive: list[tuple[float, ...]] = []
        self._force: list[tuple[float, ...]] = []
        self._state: list[tuple[float, ...]] = []
        self._sections: list[Array] = []
        self._warnings: list[Warned] = []
