"""The same observables of the model: many trains at the drives of all dwells at once, in the lanes."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import lcm

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes import LanePoints, respond_trains
from seat_gear_dynamics.studies.identification.observables import statistics
from seat_gear_dynamics.studies.identification.parameters import Candidate
from seat_gear_dynamics.studies.identification.waveform import STEPS, Sensor, waveform

Array = NDArray[np.float64]

TRANSIENT, JUDGED = 1160, 40
"""Mesh periods of P12 run in, and looked at for recurrence; less run-in leaves ripples over the parameters."""
LONGEST = 12
"""Mesh periods after which a regular motion has come back to itself at the latest."""
_RECURRENCE = 0.02  # of b_c: told from chaos, which wanders by tenths; slow transients may still be dying away
_SAME = 1e-5  # of b_c: one period stands for all that follow
_BETWEEN = 4  # places of a straight line between samples: quantiles of samples alone are steps
_NOISE_NODES = norm.ppf((np.arange(15) + 0.5) / 15)


@dataclass(frozen=True, eq=False)
class Drives:
    """The drives of all dwells and what is looked at in each."""

    speed: Array
    """rad/s of s1, (d,)."""
    load: Array
    """N·m, (d,)."""
    orders: tuple[int, ...]
    """Mesh orders looked at in each dwell."""

    @property
    def sizes(self) -> tuple[int, ...]:
        """Observables of each dwell."""
        return tuple(4 + count for count in self.orders)


@dataclass(frozen=True, eq=False)
class Predicted:
    """What one candidate says of every dwell."""

    value: Array
    """Observables of all dwells one after the other, (sum of sizes,); NaN where the motion diverged."""
    regular: NDArray[np.bool_]
    """Dwells whose section recurs within 12 mesh periods, (d,)."""


def predict(candidates: Sequence[Candidate], drives: Drives, sensor: Sensor) -> list[Predicted]:
    """Return what each of `candidates` says of all dwells, in order.

    Each motion starts at rest under its load and runs in for 1160 mesh periods and 40 more that are judged; statistics
    are then of its waveform over as many periods as it takes to come back to itself, 12 where it does not. White noise
    of the sensor widens spread and quantiles by convolution with 15 nodes of equal probability. Limits: one motion a
    drive, that which rest leads to, where the bench may be on another branch; the drive is held at the dwell's mean; a
    chaotic motion's 12 periods are a sample, not its statistics.
    """
    asked = [(c.train, LanePoints(_frequency(c.train, drives), drives.load)) for c in candidates]
    found = respond_trains(
        asked,
        transient=_run_in(candidates[0].train),
        periods=JUDGED,
        target_steps=STEPS,
        tangent=False,
        statistics=False,
    )
    said = []
    for c, r in zip(candidates, found, strict=True):
        apart = _apart(r.section)
        same = apart < _SAME
        periods = np.where(same.any(axis=0), same.argmax(axis=0) + 1, LONGEST) * ~r.diverged
        regular = np.asarray((apart < _RECURRENCE).any(axis=0))
        said.append(Predicted(_values(c, drives, sensor, r.state, periods), regular))
    return said


def observables_of(wave: Array, periods: int, orders: int, noise: float) -> Array:
    """Return the observables of a waveform (n,) over whole mesh `periods` with white `noise`, (4 + orders,)."""
    lines = 2 * np.abs(np.fft.rfft(wave)) / len(wave)
    amplitudes = lines[periods * np.arange(1, orders + 1)]
    between = np.arange(len(wave) * _BETWEEN) / _BETWEEN
    fine = np.interp(between, np.arange(len(wave) + 1), np.append(wave, wave[0]))
    found = statistics(np.add.outer(fine, noise * _NOISE_NODES).ravel() if noise else fine)
    found[:2] = wave.mean(), np.hypot(wave.std(), noise)  # the nodes alone are a little narrower than the noise
    return np.concatenate([found, amplitudes])


def _run_in(train: GearTrain) -> int:
    """Return the run-in that ends at mesh phase 0 of both meshes: whole cycles of s2's and s3's teeth."""
    s2, s3 = train.gears[1].teeth, train.gears[2].teeth
    cycle = lcm(s2, s3) // s3
    return -(-(TRANSIENT + JUDGED) // cycle) * cycle - JUDGED


def _frequency(train: GearTrain, drives: Drives) -> Array:
    return train.meshes[0].driver.teeth * drives.speed / train.model.time_scale


def _values(c: Candidate, drives: Drives, sensor: Sensor, state: Array, periods: NDArray[np.int64]) -> Array:
    """Return all observables; NaN for dwells of no `periods`, which have diverged."""
    parts = [np.full(size, np.nan) for size in drives.sizes]
    for k in np.flatnonzero(periods):
        load, frequency, count = float(drives.load[k]), float(_frequency(c.train, drives)[k]), int(periods[k])
        wave = waveform(c.train, sensor, frequency=frequency, load=load, state=state[k], periods=count)
        if np.isfinite(wave).all():
            parts[k] = observables_of(wave, count, drives.orders[k], c.noise)
    return np.concatenate(parts)


def _apart(section: Array) -> Array:
    """Return how far sections (d, JUDGED, 2) are from themselves 1 to LONGEST periods before, (LONGEST, d)."""
    return np.array(
        [np.abs(section[:, p:] - section[:, :-p])[:, -LONGEST:].max(axis=(1, 2)) for p in range(1, LONGEST + 1)]
    )
