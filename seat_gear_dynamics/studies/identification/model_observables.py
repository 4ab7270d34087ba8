"""The same observables of the model: many trains at the drives of all dwells at once, in the lanes."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import lcm

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.stats import norm

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes import LanePoints, respond_trains
from seat_gear_dynamics.studies.identification.observables import statistics
from seat_gear_dynamics.studies.identification.parameters import Candidate
from seat_gear_dynamics.studies.identification.waveform import STEPS, Sensor, waveform

Array = NDArray[np.float64]

TRANSIENT, JUDGED = 1160, 40
"""Mesh periods of P12 run in, and looked at for recurrence; less run-in leaves ripples over the parameters."""
RECORDED = 12
"""Mesh periods whose waveform is taken: whole cycles of motions of period 1, 2, 3, 4, 6 and 12."""
_RECURRENCE = 0.02  # of b_c: told from chaos, which wanders by tenths; slow transients may still be dying away
_FINER = 8
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

    Each motion starts at rest under its load and runs in for 1160 mesh periods; statistics are then of its waveform
    over 12. White noise of the sensor widens spread and quantiles by convolution with 15 nodes of equal probability.
    Limits: one motion a drive, that which rest leads to, where the bench may be on another branch; the drive is held
    at the dwell's mean; a chaotic motion's 12 periods are a sample, not its statistics.
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
    return [
        Predicted(_values(c, drives, sensor, r.state, r.diverged), _recurs(r.section))
        for c, r in zip(candidates, found, strict=True)
    ]


def observables_of(wave: Array, orders: int, noise: float) -> Array:
    """Return the observables of a waveform (n,) over RECORDED whole mesh periods with white `noise`, (4 + orders,)."""
    lines = 2 * np.abs(np.fft.rfft(wave)) / len(wave)
    amplitudes = lines[RECORDED * np.arange(1, orders + 1)]
    # Quantiles of the few samples of a short cycle would be coarse: those of a curve through them are not.
    fine = CubicSpline(np.arange(len(wave)), wave)(np.arange((len(wave) - 1) * _FINER) / _FINER)
    if not noise:
        found = statistics(fine)
    else:
        found = statistics(np.add.outer(fine[:: _FINER // 2], noise * _NOISE_NODES).ravel())
    found[:2] = wave.mean(), np.hypot(wave.std(), noise)  # the nodes alone are a little narrower than the noise
    return np.concatenate([found, amplitudes])


def _run_in(train: GearTrain) -> int:
    """Return the run-in that ends at mesh phase 0 of both meshes: whole cycles of s2's and s3's teeth."""
    s2, s3 = train.gears[1].teeth, train.gears[2].teeth
    cycle = lcm(s2, s3) // s3
    return -(-(TRANSIENT + JUDGED) // cycle) * cycle - JUDGED


def _frequency(train: GearTrain, drives: Drives) -> Array:
    return train.meshes[0].driver.teeth * drives.speed / train.model.time_scale


def _values(c: Candidate, drives: Drives, sensor: Sensor, state: Array, diverged: NDArray[np.bool_]) -> Array:
    parts = []
    for k, frequency in enumerate(_frequency(c.train, drives)):
        if diverged[k]:
            parts.append(np.full(drives.sizes[k], np.nan))
            continue
        load = float(drives.load[k])
        wave = waveform(c.train, sensor, frequency=float(frequency), load=load, state=state[k], periods=RECORDED)
        parts.append(observables_of(wave, drives.orders[k], c.noise))
    return np.concatenate(parts)


def _recurs(section: Array) -> NDArray[np.bool_]:
    """Return whether each section (d, JUDGED, 2) comes back to itself after 1 to RECORDED periods."""
    least = np.full(len(section), np.inf)
    for period in range(1, RECORDED + 1):
        apart = np.abs(section[:, period:] - section[:, :-period])[:, -RECORDED:].max(axis=(1, 2))
        least = np.fmin(least, apart)
    return least < _RECURRENCE
