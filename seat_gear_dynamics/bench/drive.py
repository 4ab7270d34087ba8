"""What the bench answers: a motor that lags its command, a Hall sensor that counts, noise with a seed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from seat_gear_dynamics.bench.errors import BenchError
from seat_gear_dynamics.bench.profiles import RPM, Profile

MOTOR_TIME_CONSTANT = 0.08  # s; a small DC gear motor with its controller
HALL_PULSES_PER_REVOLUTION = 3000  # increments per revolution of s1: ±2 r/min at 100 Hz
SPEED_NOISE = 0.5 * RPM  # rad/s rms
LOAD_NOISE = 5.0  # N·m rms, under 1 % of the nominal 600 N·m


class BenchSample(NamedTuple):
    """One sample: time (s), measured speed (rad/s) and load (N·m), and what they truly were."""

    t: float
    speed: float
    load: float
    true_speed: float
    true_load: float


class SimulatedBench:
    """Plays a profile sample by sample; time is counted in samples, no clock is read.

    Motor: first order, τ dω/dt = ω_c - ω, with the command held at its mean of the sample, so that
    ω[k+1] = c + (ω[k] - c) e^(-T/τ) and the angle grows by c T + (ω[k] - c) τ (1 - e^(-T/τ)), both exact for
    a command that stands still and of second order in T for a ramp. τ = 0 is a motor without lag.

    Hall sensor: n = floor(θ[k+1] N / 2π) - floor(θ[k] N / 2π) increments pass in a sample, and the measured
    speed is n 2π / (N T): the mean speed over the sample, so about T/2 old. It comes in steps of 60 / (N T)
    r/min and is wrong by less than one step; what one sample cuts off counts in the next, so its mean is not
    biased. N = 3000 (a Hall angle sensor with interpolation) and T = 10 ms give steps of 2 r/min, so less
    than ±2 r/min. A shaft at rest gives exactly 0.

    Noise: Gaussian, `speed_noise` (rad/s rms) and `load_noise` (N·m rms), from PCG64 with `seed`: the same
    arguments give the same sequence, bit for bit. At rest the speed carries no noise, as no increment passes.
    """

    def __init__(
        self,
        profile: Profile,
        *,
        sample_time: float = 0.01,
        motor_time_constant: float = MOTOR_TIME_CONSTANT,
        hall_pulses_per_revolution: int = HALL_PULSES_PER_REVOLUTION,
        speed_noise: float = SPEED_NOISE,
        load_noise: float = LOAD_NOISE,
        seed: int = 0,
    ) -> None:
        """Start at 0 s with the shaft already at the profile's first speed; raises `BenchError`."""
        _demand("sample_time", sample_time, "above 0 s", sample_time > 0.0)
        _demand("motor_time_constant", motor_time_constant, "0 s or more", motor_time_constant >= 0.0)
        _demand("speed_noise", speed_noise, "0 rad/s or more", speed_noise >= 0.0)
        _demand("load_noise", load_noise, "0 N·m or more", load_noise >= 0.0)
        pulses = hall_pulses_per_revolution
        _demand("hall_pulses_per_revolution", pulses, "a whole number from 1 up", pulses % 1 == 0 and pulses >= 1)
        _demand("seed", seed, "a whole number, 0 or more", seed % 1 == 0 and seed >= 0)
        self.profile = profile
        self.sample_time = sample_time
        self._noise = np.random.Generator(np.random.PCG64(int(seed)))
        self._deviations = (speed_noise, load_noise)
        self._pulses = int(pulses)
        self._lag = motor_time_constant
        self._decay = math.exp(-sample_time / motor_time_constant) if motor_time_constant > 0.0 else 0.0
        self._index = 0
        self._speed = profile.speed(0.0)
        self._edges = 0.5  # since the last whole increment, in [0, 1); not on the border, where rounding would count

    @property
    def speed_step(self) -> float:
        """The step of the measured speed, 2π/(N T), in rad/s."""
        return 2.0 * math.pi / (self._pulses * self.sample_time)

    def step(self) -> BenchSample:
        """Advance by one sample time and return the sample at its end; the first one is at `sample_time`."""
        begin = self._index * self.sample_time
        self._index += 1
        t = self._index * self.sample_time  # no sum of many small steps, so no drift
        count = self._count(self._turn(self.profile.speed(0.5 * (begin + t))))
        load = self.profile.load(t)
        # Drawn even when unused, so that the sequence does not depend on where the shaft stood still.
        speed_noise, load_noise = self._noise.normal(size=2) * self._deviations
        measured = count * self.speed_step + float(speed_noise) if count else 0.0
        return BenchSample(t, measured, load + float(load_noise), self._speed, load)

    def _turn(self, command: float) -> float:
        """Advance the motor by one sample under `command` (rad/s) and return the angle turned (rad)."""
        gap = self._speed - command
        angle = command * self.sample_time + gap * self._lag * (1.0 - self._decay)
        self._speed = command + gap * self._decay
        return angle

    def _count(self, angle: float) -> int:
        """Return the increments passed while turning by `angle` (rad), negative backwards."""
        edges = self._edges + angle * self._pulses / (2.0 * math.pi)
        whole = math.floor(edges)
        self._edges = edges - whole
        return whole


def _demand(name: str, value: float, expected: str, fulfilled: bool) -> None:
    if not (math.isfinite(value) and fulfilled):
        raise BenchError(f"{name} is {value}; expected {expected}.")
