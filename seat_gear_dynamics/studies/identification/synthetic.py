"""A record that a bench of known parameters would leave: to plan a measurement, and to test an identification."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes import respond_lanes
from seat_gear_dynamics.studies.identification.observables import Dwell
from seat_gear_dynamics.studies.identification.waveform import STEPS, Sensor, waveform

Array = NDArray[np.float64]

_TRANSIENT = 2000


def synthetic_dwells(
    train: GearTrain,
    drives: Sequence[tuple[float, float]],
    sensor: Sensor,
    *,
    seconds: float = 2.0,
    rate: float = 2000.0,
    noise: float = 0.0,
    seed: int = 1,
) -> list[Dwell]:
    """Return what `sensor` would show of `train` at each of `drives`: (rad/s of s1, N·m), run in before.

    `rate` samples a second for `seconds`, at a phase drawn from `seed`, with white `noise` in the sensor's unit. The
    motion is one continuous march, so a chaotic dwell is chaotic. Raises ValueError where a motion diverges. Limits:
    the drive is perfectly steady, and samples are interpolated between 544 a mesh period.
    """
    random = np.random.default_rng(seed)
    speed, load = np.array(drives, dtype=float).T
    frequency = train.meshes[0].driver.teeth * speed / train.model.time_scale
    found = respond_lanes(
        train, frequency, load, transient=_TRANSIENT, periods=1, target_steps=STEPS, tangent=False, statistics=False
    )
    if found.diverged.any():
        bad = int(np.flatnonzero(found.diverged)[0])
        raise ValueError(f"The motion at {speed[bad]:.4g} rad/s and {load[bad]:.4g} N·m diverges; drive elsewhere.")
    time = np.arange(int(seconds * rate)) / rate
    dwells = []
    for k in range(len(speed)):
        angle = speed[k] * time + random.uniform(0, 2 * np.pi)
        phase = np.abs(angle) * train.meshes[0].driver.teeth / (2 * np.pi)
        phase += 1.0 - np.floor(phase.min())
        wave = waveform(
            train, sensor, frequency=float(frequency[k]), load=float(load[k]), state=found.state[k],
            periods=int(phase.max()) + 2,
        )  # fmt: skip
        per_period = len(wave) // (int(phase.max()) + 2)
        value = CubicSpline(np.arange(len(wave)), wave)(phase * per_period)
        dwells.append(Dwell(speed[k], load[k], time, angle, value + noise * random.standard_normal(len(time))))
    return dwells
