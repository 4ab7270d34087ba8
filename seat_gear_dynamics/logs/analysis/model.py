"""The model beside the log: motions of its dwells, a sweep over its speeds, a regime map over its speeds and loads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis.dwells import Dwell
from seat_gear_dynamics.logs.analysis.order_spectrum import OrderSpectrum, order_spectrum
from seat_gear_dynamics.motion import Inputs, March, System, integrate
from seat_gear_dynamics.motion.history import history
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.regimes import Regime, RegimeMap, Sweep, classify, sweep

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

HARMONICS = 4
"""Mesh harmonics of s1_s2 that an order spectrum shows."""
_PER_PERIOD = 34  # samples of force in a mesh period, which divide its steps; the stiffness has 8 harmonics
_REVOLUTIONS = 40  # of s1, for a spectrum
_LEAST_SPEED = 40 * RPM  # sweeps and maps begin here: slower drives take long and are calm
_LOAD_MARGIN = 25.0  # N·m around the recorded loads
_LOAD_STEP = 150.0  # N·m


@dataclass(frozen=True)
class ModelSettings:
    """How much of the model is computed beside a log; the defaults take some 20 s on two cores."""

    dwells: int = 6
    """Longest dwells whose motion is computed."""
    sweep_points: int = 48
    """Speeds of the bifurcation diagram, up and down each."""
    map_speeds: int = 36
    """Speeds of the regime map."""
    transient: int = 150
    """Mesh periods run in at each point of sweep and map."""
    periods: int = 100
    """Mesh periods sampled there."""


@dataclass(frozen=True, eq=False)
class DwellMotion:
    """What the model does at a dwell's mean speed and load, and its force along the dwell's recorded drive."""

    dwell: Dwell
    regime: Regime
    portrait: Array
    """δ/b_c and its rate of s1_s2 over some mesh periods, (n, 2)."""
    section: Array
    """The same at mesh phase 0, (m, 2)."""
    spectra: dict[str, OrderSpectrum]
    """Of each mesh force, by name; empty where the dwell is too short for one."""


def dwell_motion(train: GearTrain, dwell: Dwell, *, transient: int = 300, periods: int = 300) -> DwellMotion | None:
    """Return the model's motion at `dwell`; None where it diverges there.

    Starts at static deflection, so of motions that coexist it shows one, and not always the recorded one.
    """
    system = System(train).at(speed=dwell.speed, load=dwell.load)
    try:
        response = integrate(system, transient=transient, periods=periods)
        interval = 2 * np.pi / abs(system.operating_point.frequency)
        regime = classify(response.section, response.growth[:, 0], interval)
        shown = 3 * (regime.period or 4)
        drawn = history(system, transient=0, periods=min(shown, 24), sampled=1, state=response.state)
        time, angle, force = force_along(train, dwell.drive, response.state)
    except DivergedError:
        return None
    portrait = np.column_stack([drawn.delta[:, 0], drawn.rate[:, 0]])
    return DwellMotion(dwell, regime, portrait, response.section, _spectra(train, angle, force) if len(time) else {})


def force_along(
    train: GearTrain, drive: Array, state: Array, *, revolutions: float = _REVOLUTIONS
) -> tuple[Array, Array, Array]:
    """Return time (n,) s, shaft angle of s1 (n,) rad and both mesh forces (n, 2) N along a recorded drive.

    `drive` (m, 3) is time (s), speed (rad/s, of one sign) and load (N·m), linear between rows; the model starts from
    `state` (24,) at mesh phase 0 and is sampled 34 times a mesh period over at most `revolutions`. Empty where the
    drive has less than two rows. Raises DivergedError.
    """
    if len(drive) < 2:
        return np.empty(0), np.empty(0), np.empty((0, 2))
    mean = float(np.abs(drive[:, 1]).mean())
    step = 2 * np.pi / mean / train.gears[0].teeth / _PER_PERIOD
    end = min(float(drive[-1, 0]), float(drive[0, 0]) + revolutions * 2 * np.pi / mean)
    asked = np.arange(0.0, end - float(drive[0, 0]), step)
    speed, load = (np.interp(asked, drive[:, 0] - drive[0, 0], drive[:, column]) for column in (1, 2))
    march = March(train, load=float(load[0]))
    march.state = state
    tau = asked * train.model.time_scale
    inputs = [Inputs(train.frequency(s), t) for s, t in zip(speed.tolist(), load.tolist(), strict=True)]
    reached, force = np.empty(len(asked)), np.empty((len(asked), 2))
    for k, (at, drives) in enumerate(zip(tau.tolist(), inputs, strict=True)):
        if k:
            march.advance((float(tau[k - 1]), inputs[k - 1]), (at, drives))
        # Steps are made whole: the motion is a little ahead of what was asked.
        reached[k], force[k] = march.tau, march.meshes(drives.frequency)[:, 2]
    time = reached / train.model.time_scale
    there = np.interp(time, asked, speed)
    angle = np.concatenate([[0.0], np.cumsum((there[1:] + there[:-1]) / 2 * np.diff(time))])
    return time, angle, force * march.force_unit


def _spectra(train: GearTrain, angle: Array, force: Array) -> dict[str, OrderSpectrum]:
    highest = (HARMONICS + 0.5) * train.gears[0].teeth
    try:
        return {
            mesh.name: order_spectrum(angle, force[:, i], highest=highest, revolutions=8)
            for i, mesh in enumerate(train.meshes)
        }
    except ValueError:  # too few turns of s1
        return {}


def model_sweep(
    train: GearTrain, speeds: tuple[float, float], load: float, settings: ModelSettings, progress: Progress | None
) -> Sweep | None:
    """Return the model's bifurcation diagram over |speed| (lowest, highest; rad/s) at `load`; None without a range."""
    low, high = max(speeds[0], _LEAST_SPEED) / RPM, speeds[1] / RPM
    if not high > low:
        return None
    return sweep(
        System(train).at(load=load),
        over="speed_rpm",
        start=low,
        stop=high,
        points=settings.sweep_points,
        direction="both",
        transient=settings.transient,
        periods=settings.periods,
        progress=progress,
    )


def model_map(
    train: GearTrain,
    speeds: tuple[float, float],
    loads: tuple[float, float],
    settings: ModelSettings,
    progress: Progress | None,
) -> RegimeMap | None:
    """Return the model's regime map over |speed| (rad/s) and load (N·m) ranges; None without a range of speeds."""
    low, high = max(speeds[0], _LEAST_SPEED), speeds[1]
    if not high > low:
        return None
    least, most = loads[0] - _LOAD_MARGIN, loads[1] + _LOAD_MARGIN
    rows = int(np.clip(np.ceil((most - least) / _LOAD_STEP) + 1, 2, 6))
    return RegimeMap.compute(
        System(train),
        np.linspace(low, high, settings.map_speeds),
        np.linspace(least, most, rows),
        progress,
        transient=settings.transient,
        periods=settings.periods,
    )
