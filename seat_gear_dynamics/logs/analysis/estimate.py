"""Forces, section and warnings of a log that holds none: its speed and load through the monitor's own session."""

from __future__ import annotations

import numpy as np

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs.analysis.batches import FORCE_COLUMNS, STATE_COLUMNS, Array, Batch, Warned, empty
from seat_gear_dynamics.sensing import AlarmSettings, Change, RejectedSampleError, Session

_FORCE_PERIOD = 0.02  # s, the monitor's default
_WARNING_PERIOD = 0.1  # s, likewise


class Estimate:
    """Feeds a drive to a session and gathers what the monitor would have published at its default rates.

    Limit: silence is not seen, so a gap shows as a restart of the model and not as a STALE warning.
    """

    def __init__(self, train: GearTrain, settings: AlarmSettings | None = None, *, max_gap: float = 0.5) -> None:
        self._session = Session(train, settings=settings, max_gap=max_gap)
        self._forces_due = self._warning_due = -np.inf

    def extend(self, batch: Batch) -> None:
        """Fill force, state, section, warnings and restarts of a batch that holds only a drive."""
        forces: list[tuple[float, ...]] = []
        states: list[tuple[float, ...]] = []
        sections: list[Array] = []
        for t, speed, load in batch.drive[:, :3].tolist():
            try:
                change = self._session.feed(t, speed, load)
            except RejectedSampleError:
                continue
            if change.reading.event != "running":
                batch.restarts.append((t, change.reading.event))
            sections.append(change.reading.section)
            self._warn(t, change, batch)
            if t >= self._forces_due:
                self._read(t, change, forces, states)
        batch.force = np.array(forces) if forces else empty(FORCE_COLUMNS)
        batch.state = np.array(states) if states else empty(STATE_COLUMNS)
        points = np.concatenate(sections) if sections else np.empty((0, 3))
        nothing = np.full((len(points), 2), np.nan)
        batch.section = np.column_stack([points[:, 2], points[:, :2], nothing])

    def _warn(self, t: float, change: Change, batch: Batch) -> None:
        if not change.changed and t < self._warning_due:
            return
        self._warning_due = t + _WARNING_PERIOD
        verdict = change.verdict
        batch.warnings.append(Warned(t, int(verdict.level), verdict.reason, change.reading.regime.name))

    def _read(self, t: float, change: Change, forces: list[tuple[float, ...]], states: list[tuple[float, ...]]) -> None:
        windows = self._session.take_windows()
        if windows[0].duration == 0:
            return
        self._forces_due = t + _FORCE_PERIOD * (1 - 1e-9)
        statistics = [value for w in windows for value in (w.mean, w.min, w.max, w.rms)]
        forces.append((t, *statistics, change.reading.speed, change.reading.load))
        contacts = [value for c in change.reading.contacts for value in (c.deflection, c.rate, c.force)]
        states.append((t, *contacts))
