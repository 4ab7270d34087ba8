"""One monitored drive: virtual sensor and alarm together, and what to publish since the last time it was asked."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.compiling import Announce, announced
from seat_gear_dynamics.regimes import warm_up as warm_up_judgement
from seat_gear_dynamics.sensing.alarm import Alarm, AlarmSettings, Verdict
from seat_gear_dynamics.sensing.bands import BandSource, PublishedBands
from seat_gear_dynamics.sensing.evidence import Level
from seat_gear_dynamics.sensing.reading import ForceWindow, Reading
from seat_gear_dynamics.sensing.virtual_sensor import VirtualSensor

Array = NDArray[np.float64]

SETTLING = 1.5
"""s after the model was put at rest in which its motion is no evidence: one second, some 400 mesh periods of the fast
drives where chaos is met, which a map runs in too, and the half second of record that a judgement looks back on, which
must hold none of them. Limit: transients that last longer are taken for motion of the machine."""


@dataclass(frozen=True)
class Change:
    """What one sample changed that must not wait: the verdict, and whether level or trip signal moved with it."""

    reading: Reading
    verdict: Verdict
    changed: bool


class Session:
    """Feeds samples to sensor and alarm and gathers their results between two publications.

    The node, the command line and a replay all go through here, so that they agree bit for bit.
    """

    def __init__(
        self,
        train: GearTrain,
        *,
        settings: AlarmSettings | None = None,
        bands: BandSource | None = None,
        max_gap: float = 0.5,
        section_points: int = 256,
    ) -> None:
        """Start a session of `train`; `bands` are the published ones until a source such as `MapBands` is given."""
        self.sensor = VirtualSensor(train, max_gap=max_gap)
        self.alarm = Alarm(bands or PublishedBands.of(train), settings=settings)
        self.reading: Reading | None = None
        self.section: Array = np.empty((0, 3))
        """The last section points, at most `section_points`, shape (n, 3): δ/b_c, dimensionless rate, t in s."""
        self.verdict = self.alarm.stale("no input yet")
        self._room = section_points
        self._began = -inf
        self._windows = (ForceWindow(), ForceWindow())

    def feed(self, t: float, speed: float, load: float) -> Change:
        """Take a sample (s, rad/s of s1, N·m); raises RejectedSampleError where the sensor refuses it."""
        reading = self.sensor.update(t, speed, load)
        if reading.event != "running":
            self.section = np.empty((0, 3))
        if len(reading.section):
            self.section = np.concatenate([self.section, reading.section])[-self._room :]
        first, second = (a.merged(b) for a, b in zip(self._windows, reading.windows, strict=True))
        self._windows = (first, second)
        self.reading = reading
        if reading.event != "running":
            self._began = t
        settled = t - self._began >= SETTLING
        return self._follow(reading, self.alarm.update(t, speed, load, reading.regime, self.section, settled=settled))

    def silence(self, reason: str) -> bool:
        """Tell the alarm that inputs are missing; return True if this changed level or trip signal."""
        before = (self.verdict.level, self.verdict.in_band)
        if self.verdict.level != Level.STALE or self.verdict.reason != reason:
            self.verdict = self.alarm.stale(reason)
        return before != (self.verdict.level, self.verdict.in_band)

    def reset(self) -> None:
        """Start over: the next sample puts the train at rest. Counts are kept."""
        self.sensor.reset()
        self.verdict = self.alarm.stale("reset, waiting for input")
        self.reading = None
        self.section = np.empty((0, 3))
        self._windows = (ForceWindow(), ForceWindow())

    def resume(self, state: Array) -> None:
        """Go on from a sensor's `state`, as taken when force windows had just been taken.

        From there on the same samples give the same force windows bit for bit. Regime, section and alarm start anew.
        Raises ValueError for what is no such state.
        """
        self.sensor.state = state
        self.verdict = self.alarm.stale("set to a state, waiting for input")
        self.reading = None
        self.section = np.empty((0, 3))
        self._windows = (ForceWindow(), ForceWindow())

    def take_windows(self) -> tuple[ForceWindow, ForceWindow]:
        """Return the force windows gathered since this was last called, and start new ones."""
        gathered, self._windows = self._windows, (ForceWindow(), ForceWindow())
        return gathered

    def _follow(self, reading: Reading, verdict: Verdict) -> Change:
        changed = (verdict.level, verdict.in_band) != (self.verdict.level, self.verdict.in_band)
        self.verdict = verdict
        return Change(reading, verdict, changed)


def warm_up(train: GearTrain, *, announce: Announce | None = None) -> None:
    """Run a session and a judgement of its motion for nothing, so that all compiled code is there before it counts.

    Takes seconds the first time on a machine, which `announce` gets a sentence before, then a fraction of one: compiled
    code is kept on disk.
    """
    with announced(announce):
        session = Session(train)
        for k in range(60):  # long enough to come by every path once
            session.feed(0.01 * k, 150.0, 0.0)
        warm_up_judgement()
