"""The virtual sensor: mesh forces of a running drive, from its measured speed and load."""

from collections import Counter
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March, System, Window
from seat_gear_dynamics.motion.march import WHOLE_NAMES, DivergedError
from seat_gear_dynamics.sensing.reading import Accepted, Contact, ForceWindow, Reading
from seat_gear_dynamics.sensing.regime_watch import RegimeWatch

Array = NDArray[np.float64]

SENSOR_STATE_NAMES: tuple[str, ...] = (*WHOLE_NAMES, "restarted/s", "sample/s", "sample/frequency", "sample/N·m")
"""What `VirtualSensor.state` holds: the motion, when it last restarted, and time, frequency and load of its sample."""


class RejectedSampleError(ValueError):
    """A sample that was refused and counted; the model is as it was before. `reason` is the key it is counted under."""

    def __init__(self, reason: str, text: str) -> None:
        super().__init__(text)
        self.reason = reason


class VirtualSensor:
    """Runs the gear train beside a bench: feed it samples in time, read forces, contact and regime.

    Between two samples speed and load are taken as linear. What each case does:

    - first sample: the train is put at rest at static deflection under its load (event `started`);
    - zero or creeping speed: the mesh phase stands or creeps, supports and teeth keep vibrating and come to rest;
    - reversal: the mesh phase runs backward; the load keeps its own sign;
    - zero load: the teeth float in their backlash; a negative load rests on the other flank;
    - a gap of more than `max_gap` s, or a clock that steps back by more than that: nothing is invented for it, the
      train restarts at static deflection (events `gap`, `clock stepped back`);
    - a repeated or slightly older time, a number that is not finite or is absurd: refused (RejectedSampleError);
    - a solution that leaves all bounds: restart (event `diverged`).

    `counts` holds how often each happened. Needs no clock, no ROS and no file. Limits: it is a model of the mean
    machine; forces follow its parameters, `load_scale` among them, and are estimates until a bench calibrates it.
    """

    def __init__(self, system: System | GearTrain, *, max_gap: float = 0.5) -> None:
        if not max_gap > 0:
            raise ValueError(f"max_gap is {max_gap!r} s, expected more than 0.")
        self.train = system.train if isinstance(system, System) else system
        self.max_gap = max_gap
        self.counts: Counter[str] = Counter()
        self._march = March(self.train)
        self._watch = RegimeWatch()
        self._last: tuple[float, Inputs] | None = None
        self._origin = 0.0

    def reset(self) -> None:
        """Forget the motion; the next sample starts a new one. Counts are kept."""
        self._last = None

    @property
    def state(self) -> Array | None:
        """All that the forces go on from, shape (58,) in the order of SENSOR_STATE_NAMES; None before a sample.

        Set it on a sensor of the same train and `max_gap`: from there on the same samples give the same forces bit for
        bit. The record of the regime is not part of it and begins anew; counts are kept. Raises ValueError for another
        shape and for numbers that are not finite.
        """
        if self._last is None:
            return None
        t, inputs = self._last
        return np.array([*self._march.whole, self._origin, t, inputs.frequency, inputs.load])

    @state.setter
    def state(self, value: Array) -> None:
        given = np.asarray(value, dtype=float)
        if given.shape != (len(SENSOR_STATE_NAMES),) or not np.isfinite(given).all():
            raise ValueError(
                f"The sensor's state has shape {given.shape} or numbers that are not finite; "
                f"expected ({len(SENSOR_STATE_NAMES)},) finite numbers, as `state` returns them."
            )
        self._march.whole = given[: len(WHOLE_NAMES)]
        self._origin, t, frequency, load = map(float, given[len(WHOLE_NAMES) :])
        self._last = (t, Inputs(frequency, load))
        self._watch.reset("the model was set to a state")

    def update(self, t: float, speed: float, load: float) -> Reading:
        """Advance the model to time `t` (s), where the drive turns at `speed` (rad/s of s1) under `load` (T4, N·m).

        Returns what happened since the sample before. Raises RejectedSampleError for a sample that cannot be used.
        """
        return self.advance(self.accept(t, speed, load))

    def accept(self, t: float, speed: float, load: float) -> Accepted:
        """Take a sample as `update` does, but leave the model where it is: `advance` is to follow, once.

        This takes microseconds where the model may take milliseconds, so a warning need not wait for it. Raises
        RejectedSampleError as `update` does.
        """
        self._check(t, speed, load)
        event = self._event(t)
        if event == "running":
            regime = self._watch.drive(t, self.train.frequency(speed), load)
        else:
            regime = self._watch.reset(f"the model restarted ({event})")
        return Accepted(t, speed, load, event, regime)

    def advance(self, sample: Accepted) -> Reading:
        """Advance the model to the sample that was accepted last; returns what happened since the one before."""
        inputs = Inputs(self.train.frequency(sample.speed), sample.load)
        if sample.event != "running":
            return self._restart(sample, inputs, sample.event)
        assert self._last is not None, "a sample is accepted before the model is advanced to it"
        pieces: list[Array] = []
        start = (self._tau(self._last[0]), self._last[1])
        try:
            windows = self._march.advance(start, (self._tau(sample.t), inputs), pieces.append)
        except DivergedError:
            self._watch.reset("the model restarted (diverged)")
            return self._restart(sample, inputs, "diverged")
        self._last = (sample.t, inputs)
        self.counts["accepted"] += 1
        points = np.concatenate(pieces) if pieces else np.empty((0, 5))
        self._watch.add(points)
        return self._reading(sample, inputs, sample.event, windows, points)

    def _check(self, t: float, speed: float, load: float) -> None:
        model = self.train.model
        for name, value, unit in (("time", t, "s"), ("speed", speed, "rad/s"), ("load", load, "N·m")):
            if not isfinite(value):
                self._reject(
                    "not finite",
                    f"The {name} is {value!r} {unit}, expected a finite number; check its sender.",
                )
        for name, value, limit, unit in (
            ("speed", speed, model.max_speed, "rad/s"),
            ("load", load, model.max_load, "N·m"),
        ):
            if abs(value) > limit:
                self._reject(
                    "absurd",
                    f"The {name} is {value:.6g} {unit}, expected at most {limit:.6g}; check its unit and its sensor.",
                )
        if self._last is not None and self._last[0] - self.max_gap <= t <= self._last[0]:
            reason = "duplicate" if t == self._last[0] else "late"
            self._reject(
                reason,
                f"The sample's time is {t:.9g} s, expected later than {self._last[0]:.9g} s; "
                f"it came twice or too late.",
            )

    def _reject(self, reason: str, text: str) -> None:
        self.counts[reason] += 1
        raise RejectedSampleError(reason, text)

    def _event(self, t: float) -> str:
        if self._last is None:
            return "started"
        if t < self._last[0]:
            return "clock stepped back"
        return "gap" if t - self._last[0] > self.max_gap else "running"

    def _restart(self, sample: Accepted, inputs: Inputs, event: str) -> Reading:
        self.counts[event] += 1
        self._origin = sample.t
        self._march.restart(inputs.load)
        self._last = (sample.t, inputs)
        return self._reading(sample, inputs, event, (Window(), Window()), np.empty((0, 5)))

    def _tau(self, t: float) -> float:
        return (t - self._origin) * self.train.model.time_scale

    def _reading(
        self,
        sample: Accepted,
        inputs: Inputs,
        event: str,
        windows: tuple[Window, Window],
        points: Array,
    ) -> Reading:
        scale, force, length = self.train.model.time_scale, self._march.force_unit, self._march.length_unit
        meshes = self._march.meshes(inputs.frequency)
        contacts = [Contact(d * length, r * length * scale, f * force) for d, r, f, _ in meshes.tolist()]
        section = np.column_stack([points[:, 1], points[:, 2], self._origin + points[:, 0] / scale])
        return Reading(
            sample.t,
            sample.speed,
            sample.load,
            event,
            (
                ForceWindow.from_dimensionless(windows[0], force, scale),
                ForceWindow.from_dimensionless(windows[1], force, scale),
            ),
            (contacts[0], contacts[1]),
            section,
            self._watch.regime,
        )
