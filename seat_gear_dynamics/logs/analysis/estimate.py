"""Forces, section and warnings of a log that holds none: its speed and load through the monitor's own session."""

from __future__ import annotations

import numpy as np

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs.analysis.batches import (
    FORCE_COLUMNS,
    STATE_COLUMNS,
    Array,
    Batch,
    Recent,
    Warned,
    empty,
)
from seat_gear_dynamics.logs.analysis.seam import Phase, Seam
from seat_gear_dynamics.sensing import AlarmSettings, BandSource, Change, Reading, RejectedSampleError, Session

_FORCE_PERIOD = 0.02  # s, the monitor's default
_WARNING_PERIOD = 0.1  # s, likewise
MAX_GAP = 0.5
"""s between samples from which the model restarts, the monitor's default."""


class Estimate:
    """Feeds a drive to a session and gathers what the monitor would have published at its default rates.

    Limit: silence is not seen, so a gap shows as a restart of the model and not as a STALE warning.
    """

    def __init__(
        self,
        train: GearTrain,
        settings: AlarmSettings | None = None,
        *,
        bands: BandSource | None = None,
        max_gap: float = MAX_GAP,
    ) -> None:
        """Begin at rest; warnings are judged by `bands`, by the published ones without."""
        self._train = train
        self._session = Session(train, settings=settings, bands=bands, max_gap=max_gap)
        self._recent = Recent()
        self._forces_due = self._warning_due = -np.inf

    def begin(self, first: Array, phase: float) -> None:
        """Put the train at rest at a row of `Batch.drive` and a mesh phase of P12 in periods; go on from there."""
        self._session.feed(*first[:3].tolist())
        state = self._session.sensor.state
        assert state is not None, "a sample was fed"
        self._session.resume(Phase(self._train).set(state, phase))

    @property
    def seam(self) -> Seam | None:
        """Where the session stands; None before a sample."""
        state, reading, verdict = self._session.sensor.state, self._session.reading, self._session.verdict
        if state is None or reading is None:
            return None
        return Seam(state, self._session.section, int(verdict.level), verdict.in_band, reading.regime.name)

    def extend(self, batch: Batch, *, last: bool = False) -> None:
        """Fill force, state, section, warnings and restarts of a batch that holds only a drive.

        With `last` the forces since the last full window are a shorter one, so that nothing is left over.
        """
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
                self._read(t, change.reading, forces, states)
        if last and self._session.reading is not None and len(batch.drive):
            self._read(float(batch.drive[-1, 0]), self._session.reading, forces, states)
        batch.force = np.array(forces) if forces else empty(FORCE_COLUMNS)
        batch.state = np.array(states) if states else empty(STATE_COLUMNS)
        points = np.concatenate(sections) if sections else np.empty((0, 3))
        self._recent.extend(batch.drive)
        batch.section = self._recent.placed(points[:, [2, 0, 1]])

    def cut(self) -> None:
        """Drop what has been gathered since the last force: what comes next begins here."""
        self._session.take_windows()
        self._forces_due = self._warning_due = -np.inf

    def _warn(self, t: float, change: Change, batch: Batch) -> None:
        if not change.changed and t < self._warning_due:
            return
        self._warning_due = t + _WARNING_PERIOD
        verdict = change.verdict
        batch.warnings.append(Warned(t, int(verdict.level), verdict.reason, change.reading.regime.name))

    def _read(
        self, t: float, reading: Reading, forces: list[tuple[float, ...]], states: list[tuple[float, ...]]
    ) -> None:
        windows = self._session.take_windows()
        if windows[0].duration == 0:
            return
        self._forces_due = t + _FORCE_PERIOD * (1 - 1e-9)
        statistics = [value for w in windows for value in (w.mean, w.min, w.max, w.rms)]
        forces.append((t, *statistics, reading.speed, reading.load))
        contacts = [value for c in reading.contacts for value in (c.deflection, c.rate, c.force)]
        states.append((t, *contacts))
