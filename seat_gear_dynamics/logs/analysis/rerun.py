"""A log's inputs through the core again, beside all of its outputs: equal bit for bit, or what would be different."""

from __future__ import annotations

import heapq
from collections import defaultdict, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.batches import FORCE_NAMES, MESHES, Warned
from seat_gear_dynamics.logs.analysis.detection import LevelSpans
from seat_gear_dynamics.logs.analysis.first_window import FirstWindow
from seat_gear_dynamics.logs.analysis.force_totals import ForceTotals
from seat_gear_dynamics.logs.analysis.message_bytes import Joint
from seat_gear_dynamics.logs.analysis.occupancy import LONGEST_HOLD
from seat_gear_dynamics.logs.analysis.rerun_result import Compared, Rerun
from seat_gear_dynamics.logs.analysis.resumption import Resumption, resumption
from seat_gear_dynamics.logs.analysis.setting_changes import SettingChange, apply, setting_changes
from seat_gear_dynamics.logs.analysis.timed import CLOUD, FORCE, INPUT, SETTINGS, STATE, WARNING, sequences
from seat_gear_dynamics.logs.analysis.what_if import MonitorSettings, recorded_bands
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.sensing import ForceWindow, RejectedSampleError, Session

_SILENCE = ("no speed", "no load", "no input", "reset")
"""How a warning begins that came of silence or a reset: inputs alone do not show when."""
_AGO = 1_000_000_000  # ns back to look for the sample that a logged warning speaks of
_LAYOUT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("t", "<f8")])


def rerun(
    path: Path | str,
    train: GearTrain,
    settings: MonitorSettings | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Rerun:
    """Feed what the monitor was fed (`gear_monitor/input`) to a new session and hold it against the logged outputs.

    Forces, mesh states and sections are compared bit for bit, warnings by level and text with what the session said
    within a second before. Equal on the same build where `train` and `settings` are the monitor's, nothing reset it,
    its clock did not step back, and no message is missing but forces before the first in the log (see `Rerun`). Where
    the log holds `/parameter_events`, thresholds that were changed change with the same input; of those that `settings`
    names as given nothing is followed. Memory does not grow with the log. `progress` is told (samples fed, in all).

    Raises LogError where the log holds no such inputs or no forces. Limit: a log that begins amid a run without a
    model state is started at rest, and differs until the motion has forgotten that; chaos never does.
    """
    bag = Bag(path)
    bag.resolve(topics.MODEL_INPUT.name), bag.resolve(topics.MESH_FORCE.name)
    start = resumption(bag)
    changes = setting_changes(bag)
    settings, later = _at_start(bag, settings or MonitorSettings(), changes or [])
    run = _Run(train, settings, start, recorded_bands(bag), bag.start_ns)
    total = bag.topics[bag.resolve(topics.MODEL_INPUT.name)].count
    for stamp, rank, message in heapq.merge(*sequences(bag, later, amid=start.state is not None), key=lambda x: x[:2]):
        if stamp <= start.after_ns and rank not in (WARNING, SETTINGS):
            continue
        run.take(stamp, rank, message)
        if rank == INPUT and progress is not None and run.samples % 500 == 0:
            progress(run.samples, total)
    return run.finish(bag.damage, None if changes is None else len(changes))


def _at_start(
    bag: Bag, settings: MonitorSettings, changes: list[SettingChange]
) -> tuple[MonitorSettings, list[SettingChange]]:
    """Return the settings by which the first input was judged, and the changes behind it."""
    first = next(iter(bag.messages(topics.MODEL_INPUT.name)), None)
    begin = 0 if first is None else first.publish_time_ns or first.log_time_ns
    for change in changes:
        if change.publish_ns < begin:
            settings = apply(settings, change)
    return settings, [change for change in changes if change.publish_ns >= begin]


@dataclass
class _Said:
    """What the replayed session said after a sample."""

    stamp_ns: int
    level: int
    text: str


@dataclass
class _Levels:
    seconds: defaultdict[int, float] = field(default_factory=lambda: defaultdict(float))
    last: tuple[int, int] | None = None

    def take(self, stamp_ns: int, level: int) -> None:
        if self.last is not None and 0 < stamp_ns - self.last[0] <= LONGEST_HOLD * 1e9:
            self.seconds[self.last[1]] += (stamp_ns - self.last[0]) * 1e-9
        self.last = (stamp_ns, level)


class _Run:
    """The session under way and what has been compared so far."""

    def __init__(
        self, train: GearTrain, settings: MonitorSettings, start: Resumption, recorded_bands: str | None, begin_ns: int
    ) -> None:
        self._settings, self._begin_ns = settings, begin_ns
        self._session = Session(
            train,
            settings=settings.alarm,
            bands=settings.bands,
            max_gap=settings.max_gap,
            section_points=settings.section_points,
        )
        self._bands = (recorded_bands, self._session.alarm.source.label)
        self._begins = "first input" if start.state is None else "model state"
        if start.state is not None:
            self._session.resume(start.state)
        self._origin = start.origin_ns
        self.samples = self._silences = 0
        chosen = (topics.MESH_FORCE, topics.MESH_STATE, topics.POINCARE, topics.CHAOS_WARNING)
        self._compared = [Compared(topic.name) for topic in chosen]
        self._forces = (ForceTotals(), ForceTotals())
        self._first: FirstWindow | None = FirstWindow() if start.state is None else None
        self._before_log = 0
        self._said: deque[_Said] = deque()
        self._replayed, self._logged = _Levels(), LevelSpans()
        self._first_ns: int | None = None

    def take(self, stamp: int, rank: int, message: Any) -> None:
        if rank == INPUT:
            self._feed(stamp, message)
        elif rank == FORCE:
            self._force(stamp, message)
        elif rank == SETTINGS:
            self._adopt(apply(self._settings, message))
        elif rank == STATE:
            self._compared[1].take(f"stamp {stamp} ns", self._state(message))
        elif rank == CLOUD:
            self._compared[2].take(f"stamp {stamp} ns", self._cloud(message))
        else:
            self._warning(stamp, message)

    def finish(self, damage: str | None, changes: int | None) -> Rerun:
        logged: defaultdict[int, float] = defaultdict(float)
        for (level, _), seconds in self._logged.seconds.items():
            logged[level] += seconds
        totals = [total.statistics() for total in self._forces]
        return Rerun(
            self.samples,
            self._begins,
            tuple(each for k, each in enumerate(self._compared) if k == 0 or each.messages),
            self._before_log,
            self._silences,
            {mesh: (totals[0][mesh], totals[1][mesh]) for mesh in MESHES},
            (dict(logged), dict(self._replayed.seconds)),
            self._bands,
            damage,
            changes,
        )

    def _adopt(self, settings: MonitorSettings) -> None:
        """Do as the monitor does when its parameters change: the next sample is judged by them, afresh."""
        self._settings = settings
        if settings.alarm != self._session.alarm.settings:
            self._session.alarm.settings = settings.alarm
            self._session.alarm.reset()
        self._session.sensor.max_gap = settings.max_gap

    def _feed(self, stamp: int, joint: Joint) -> None:
        self.samples += 1
        if not joint.velocity or not joint.effort:
            raise LogError(f"An input at stamp {stamp} ns has no velocity or no effort; this log is not the monitor's.")
        try:
            change = self._session.feed((stamp - self._origin) * 1e-9, joint.velocity[0], joint.effort[0])
        except RejectedSampleError:
            return  # the monitor publishes only what it accepted
        if self._first is not None:
            self._first.feed(change.reading.windows)
        verdict = change.verdict
        self._replayed.take(stamp, int(verdict.level))
        self._said.append(_Said(stamp, int(verdict.level), verdict.reason))
        while self._said[0].stamp_ns < stamp - _AGO:
            self._said.popleft()

    def _force(self, stamp: int, joint: Joint) -> None:
        logged = dict(zip(joint.names, joint.effort, strict=False))
        found = _statistics(self._session.take_windows())
        difference = _first(_rows(logged, found))
        later = self._first.later() if self._first is not None and difference is not None else ()
        self._first = None
        if any(_first(_rows(logged, _statistics(windows))) is None for windows in later):
            self._before_log = 1
            return
        for total, values in zip(self._forces, ([logged.get(n, np.nan) for n in FORCE_NAMES], found), strict=True):
            total.add(values)
        self._compared[0].take(f"stamp {stamp} ns", difference)

    def _state(self, joint: Joint) -> str | None:
        reading = self._session.reading
        if reading is None:
            return "the log holds a state before any input"
        rows = []
        for k, (mesh, contact) in enumerate(zip(MESHES, reading.contacts, strict=True)):
            rows.append((f"{mesh} deflection", joint.position[k], contact.deflection, "m"))
            rows.append((f"{mesh} rate", joint.velocity[k], contact.rate, "m/s"))
            rows.append((f"{mesh} force", joint.effort[k], contact.force, "N"))
        return _first(iter(rows))

    def _cloud(self, cloud: Any) -> str | None:
        points = np.frombuffer(bytes(cloud.data), dtype=_LAYOUT)
        section = self._session.section
        if len(points) != len(section):
            return f"{len(points)} section points in the log and {len(section)} replayed"
        found: tuple[tuple[str, NDArray[Any], str], ...] = (
            ("x", section[:, 0].astype(np.float32), "b_c"),
            ("y", section[:, 1].astype(np.float32), "b_c per τ"),
            ("t", section[:, 2] + self._origin * 1e-9, "s"),
        )
        for name, values, unit in found:
            unequal = np.flatnonzero(points[name] != values)
            if len(unequal):
                k = int(unequal[0])
                logged, again = points[name][k], values[k]
                return f"{name} of point {k} is {logged!r} {unit} in the log and {again!r} {unit} replayed"
        return None

    def _warning(self, log_ns: int, status: Any) -> None:
        level, text = int(status.level), str(status.message)
        self._first_ns = log_ns if self._first_ns is None else self._first_ns
        regime = {value.key: value.value for value in status.values}.get("regime", "undecided")
        self._logged.add([Warned((log_ns - self._first_ns) * 1e-9, level, text, regime)])
        if text.startswith(_SILENCE):
            self._silences += 1
            self._session.silence(text)
            return
        if any((said.level, said.text) == (level, text) for said in self._said):
            self._compared[3].take("", None)
            return
        last = self._said[-1] if self._said else None
        again = f"level {last.level}, {last.text!r}" if last else "nothing"
        at = f"log time {log_ns} ns ({(log_ns - self._begin_ns) * 1e-9:.2f} s into the log)"
        self._compared[3].take(at, f"level {level}, {text!r} in the log and {again} replayed")


def _statistics(windows: tuple[ForceWindow, ForceWindow]) -> list[float]:
    """Return what a force message holds of both meshes, in the order of FORCE_NAMES."""
    return [value for w in windows for value in (w.mean, w.min, w.max, w.rms)]


def _rows(logged: dict[str, float], found: list[float]) -> Iterator[tuple[str, float, float, str]]:
    return ((name, logged.get(name, np.nan), value, "N") for name, value in zip(FORCE_NAMES, found, strict=True))


def _first(rows: Iterator[tuple[str, float, float, str]]) -> str | None:
    """Return the first of (name, logged, replayed, unit) that differs in a bit, in words; NaN equals NaN."""
    for name, logged, found, unit in rows:
        if logged != found and not (np.isnan(logged) and np.isnan(found)):
            return f"{name} is {logged!r} {unit} in the log and {found!r} {unit} replayed"
    return None
