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
from seat_gear_dynamics.sensing.evidence import Level, scatter_of
from seat_gear_dynamics.sensing.reading import Accepted, ForceWindow, Reading
from seat_gear_dynamics.sensing.virtual_sensor import VirtualSensor

Array = NDArray[np.float64]

SETTLING = 1.5
"""s after the model was put at rest in which its motion is no evidence: one second, some 400 mesh periods of the fast
drives where chaos is met, which a map runs in too, and the half second of record that a judgement looks back on, which
must hold none of them. Limit: transients that last longer are taken for motion of the machine."""


@dataclass(frozen=True)
class Judgement:
    """What must not wait for the model: a sample's verdict, and whether level or trip signal moved with it."""

    sample: Accepted
    verdict: Verdict
    changed: bool


@dataclass(frozen=True)
class Change(Judgement):
    """All that one sample brought."""

    reading: Reading


class Session:
    """Feeds samples to alarm and sensor and gathers their results between two publications.

    The node, the command line and a replay all go through here, so that they agree bit for bit. A sample is judged
    before the model is advanced to it, so that a warning does not wait for the model: where the drive is and where it
    is heading are this sample's, what its motion says is that of the samples before.
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
        self.sample: Accepted | None = None
        """The last one that was judged; None before any."""
        self.reading: Reading | None = None
        """Of the last one that the model was advanced to; None before any."""
        self.section: Array = np.empty((0, 3))
        """The last section points, at most `section_points`, shape (n, 3): δ/b_c, dimensionless rate, t in s."""
        self.verdict = self.alarm.stale("no input yet")
        self._room = section_points
        self._scatter: float | None = None
        self._began = -inf
        self._windows = (ForceWindow(), ForceWindow())

    def feed(self, t: float, speed: float, load: float) -> Change:
        """Take a sample (s, rad/s of s1, N·m); raises RejectedSampleError where the sensor refuses it."""
        judged = self.judge(t, speed, load)
        return Change(judged.sample, judged.verdict, judged.changed, self.advance(judged.sample))

    def judge(self, t: float, speed: float, load: float) -> Judgement:
        """Take a sample as `feed` does, but leave the model where it is: `advance` is to follow, once."""
        sample = self.sensor.accept(t, speed, load)
        if sample.event != "running":
            self._begin(t)
        settled = t - self._began >= SETTLING
        verdict = self.alarm.update(t, speed, load, sample.regime, self._scatter, settled=settled)
        changed = (verdict.level, verdict.in_band) != (self.verdict.level, self.verdict.in_band)
        self.sample, self.verdict = sample, verdict
        return Judgement(sample, verdict, changed)

    def advance(self, sample: Accepted) -> Reading:
        """Advance the model to the sample that was judged last; returns what happened since the one before."""
        reading = self.sensor.advance(sample)
        if reading.event == "diverged":
            self._begin(sample.t)
        first, second = (a.merged(b) for a, b in zip(self._windows, reading.windows, strict=True))
        self._windows = (first, second)
        if len(reading.section):
            self.section = np.concatenate([self.section, reading.section])[-self._room :]
            undecided = reading.regime.name == "undecided" and reading.regime.lyapunov is not None
            self._scatter = scatter_of(self.section) if undecided else None
        self.reading = reading
        return reading

    def silence(self, reason: str) -> bool:
        """Tell the alarm that inputs are missing; return True if this changed level or trip signal."""
        before = (self.verdict.level, self.verdict.in_band)
        if self.verdict.level != Level.STALE or self.verdict.reason != reason:
            self.verdict = self.alarm.stale(reason)
        return before != (self.verdict.level, self.verdict.in_band)

    def reset(self) -> None:
        """Start over: the next sample puts the train at rest. Counts are kept."""
        self.sensor.reset()
        self._forget("reset, waiting for input")

    def resume(self, state: Array) -> None:
        """Go on from a sensor's `state`, as taken when force windows had just been taken.

        From there on the same samples give the same force windows bit for bit. Regime, section and alarm start anew.
        Raises ValueError for what is no such state.
        """
        self.sensor.state = state
        self._forget("set to a state, waiting for input")

    def take_windows(self) -> tuple[ForceWindow, ForceWindow]:
        """Return the force windows gathered since this was last called, and start new ones."""
        gathered, self._windows = self._windows, (ForceWindow(), ForceWindow())
        return gathered

    def _begin(self, t: float) -> None:
        """Begin a motion at rest: what was seen of the one before is no evidence any more."""
        self._began = t
        self.section = np.empty((0, 3))
        self._scatter = None

    def _forget(self, reason: str) -> None:
        self.verdict = self.alarm.stale(reason)
        self.sample = self.reading = None
        self.section = np.empty((0, 3))
        self._scatter = None
        self._windows = (ForceWindow(), ForceWindow())


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
