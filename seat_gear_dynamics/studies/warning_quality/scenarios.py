"""Labelled runs of a bench, drawn from a seed: ramps, dwells, load steps, noise and coarse sensors around the bands."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from seat_gear_dynamics.bench.drive import HALL_PULSES_PER_REVOLUTION, LOAD_NOISE, SPEED_NOISE, SimulatedBench
from seat_gear_dynamics.bench.profiles import Points, Profile, path
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.sensing import BandSource

ACCELERATIONS = (50.0, 100.0, 200.0, 400.0)
"""Of ramps, r/min per s."""
EDGE_NOISE = 5.0
"""On an edge, r/min rms."""
LOAD_STEP_TIME = 0.05
"""s that a load step takes."""
_BEFORE = 1.6  # s of ramp ahead of a band: more than the alarm looks ahead
_STILL = 1.5  # s at the start, in which the model forgets that it began at rest
_LEAST_SPEED = 200.0  # r/min; below it no run stays


@dataclass(frozen=True)
class Scenario:
    """One run of the bench."""

    family: str
    """Which of FAMILIES."""
    profile: Profile
    acceleration: float = 0.0
    """Of its ramp into a band, r/min per s; 0 where there is none."""
    speed_noise: float = SPEED_NOISE
    """rad/s rms"""
    load_noise: float = LOAD_NOISE
    """N·m rms"""
    pulses: int = HALL_PULSES_PER_REVOLUTION
    sample_time: float = 0.01
    """s"""
    seed: int = 0

    def bench(self) -> SimulatedBench:
        """Return the bench that plays it."""
        return SimulatedBench(
            self.profile,
            sample_time=self.sample_time,
            hall_pulses_per_revolution=self.pulses,
            speed_noise=self.speed_noise,
            load_noise=self.load_noise,
            seed=self.seed,
        )

    @property
    def speed_step(self) -> float:
        """Step of the measured speed, rad/s."""
        return 2 * np.pi / (self.pulses * self.sample_time)


@dataclass(frozen=True)
class Place:
    """A load and one of its bands, r/min and N·m."""

    load: float
    low: float
    high: float
    top: float
    """The highest speed of which anything is known."""
    others: tuple[tuple[float, float], ...]
    """All bands at this load."""

    def free(self, speed: float, clear: float = 0.0) -> bool:
        """Return whether `speed` is outside every band by `clear` and known."""
        apart = all(speed <= low - clear or speed >= high + clear for low, high in self.others)
        return apart and _LEAST_SPEED <= speed <= self.top - 10


def suite(source: BandSource, loads: tuple[float, float], *, seed: int, count: int) -> list[Scenario]:
    """Return `count` runs around the bands of `source`, families in turn, loads (N·m) within `loads`.

    The k-th run of a seed does not depend on how many follow. Raises ValueError where the source has no band at any
    of 1000 loads drawn.
    """
    names = list(FAMILIES)
    return [
        FAMILIES[names[k % len(names)]](np.random.default_rng([seed, k]), source, loads) for k in range(max(count, 0))
    ]


def _place(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Place:
    """Return a load and a band that ends inside what is known on one side at least."""
    top = source.covered_speed / RPM
    for _ in range(1000):
        load = float(generator.uniform(*loads))
        bands = tuple((band.low / RPM, band.high / RPM) for band in source.at(load))
        if bands:
            low, high = bands[int(generator.integers(len(bands)))]
            return Place(load, low, high, top, bands)
    raise ValueError(f"The bands have none between {loads[0]:g} and {loads[1]:g} N·m; give loads where there is one.")


def _entry(generator: np.random.Generator, place: Place) -> tuple[float, float]:
    """Return an edge, r/min, and the direction out of the band there, +1 or -1; upwards only where all is known."""
    out = 1.0 if place.high < place.top - 200 and generator.random() < 0.5 else -1.0
    return (place.high if out > 0 else place.low), out


def _hold(load: float, seconds: float) -> Points:
    return path(load, (load, seconds))


def _made(family: str, speed: Points, load: Points, generator: np.random.Generator, **more: float) -> Scenario:
    profile = Profile(family, family, speed, load)
    chosen = {"pulses": int(more.pop("pulses", HALL_PULSES_PER_REVOLUTION))}
    return Scenario(family, profile, seed=int(generator.integers(2**31)), **chosen, **more)  # type: ignore[arg-type]


def _outside(place: Place, edge: float, out: float, away: float) -> float:
    """Return a speed `away` from an edge, or as far as there is room to the next band, standstill or the end."""
    wanted = edge + out * away
    gaps = [low if out > 0 else high for low, high in place.others if (low - edge) * out > 0 or (high - edge) * out > 0]
    nearest = min((abs(each - edge) for each in gaps if abs(each - edge) > 1e-9), default=np.inf)
    limit = edge + out * nearest / 2
    found = min(wanted, limit, place.top - 10) if out > 0 else max(wanted, limit, 0.0)
    return float(found)


def _ramp(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return a ramp into a band and on through it, or as far as 3 s take it."""
    place = _place(generator, source, loads)
    acceleration = float(generator.choice(ACCELERATIONS))
    edge, out = _entry(generator, place)
    start = _outside(place, edge, out, acceleration * _BEFORE + 60)
    width = min(place.high - place.low + 120, 3 * acceleration)
    end = min(max(edge - out * width, 0.0), place.top - 10)
    seconds = abs(end - start) / acceleration
    speed = path(start, (start, _STILL), (end, seconds), (end, 1.0))
    return _made("ramp", speed, _hold(place.load, _STILL + seconds + 1), generator, acceleration=acceleration)


def _inside(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return a dwell of 0.8 to 4 s inside a band, entered and left at 400 r/min per s."""
    place = _place(generator, source, loads)
    edge, out = _entry(generator, place)
    start = _outside(place, edge, out, 150.0)
    at = edge - out * float(generator.uniform(0.1, 0.9)) * min(place.high - place.low, 300.0)
    seconds, stay = max(abs(at - start) / 400, 0.01), float(generator.uniform(0.8, 4.0))
    speed = path(start, (start, _STILL), (at, seconds), (at, stay), (start, seconds), (start, 1.5))
    return _made("inside", speed, _hold(place.load, speed[-1][0]), generator)


def _beside(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return a dwell of 6 s beside a band, 12 to 150 r/min away, with noise of 0.5 to 2 r/min."""
    place = _place(generator, source, loads)
    edge, out = _entry(generator, place)
    at = _outside(place, edge, out, float(generator.uniform(12, 150)))
    noise = float(generator.uniform(0.5, 2.0)) * RPM
    return _made("beside", path(at, (at, 7.5)), _hold(place.load, 7.5), generator, speed_noise=noise)


def _edge(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return a dwell of 10 s within 3 r/min of an edge, with noise of 5 r/min."""
    place = _place(generator, source, loads)
    edge, _ = _entry(generator, place)
    at = edge + float(generator.uniform(-3, 3))
    speed = path(at, (at, 10.0))
    return _made("edge", speed, _hold(place.load, 10.0), generator, speed_noise=EDGE_NOISE * RPM)


def _load_step(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return a steady speed whose load steps there and back, such that a band comes over the speed where there is one.

    Where the bands do not follow the load, the step changes nothing but the motion.
    """
    place = _place(generator, source, loads)
    at, other = place.low - 60.0, place.load
    for _ in range(200):
        other = float(generator.uniform(*loads))
        bands = source.at(other)
        at = float(generator.uniform(_LEAST_SPEED, place.top - 20))
        if place.free(at, 30.0) and any(b.low + 30 * RPM < at * RPM < b.high - 30 * RPM for b in bands):
            break
    steps = (other, LOAD_STEP_TIME), (other, 2.0), (place.load, LOAD_STEP_TIME), (place.load, 2.5)
    load = path(place.load, (place.load, 3.0), *steps)
    return _made("load step", path(at, (at, load[-1][0])), load, generator)


def _load_ramp(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return a steady speed while the load goes from one end of `loads` to the other at 60 to 150 N·m/s."""
    rate = float(generator.uniform(60, 150))
    first, last = loads if generator.random() < 0.5 else loads[::-1]
    at = float(generator.uniform(0.45, 0.8)) * source.covered_speed / RPM
    load = path(first, (first, 2.0), (last, abs(last - first) / rate), (last, 1.0))
    return _made("load ramp", path(at, (at, load[-1][0])), load, generator)


def _noise(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return a dwell of 10 s anywhere outside the bands by 60 r/min, with noise of 1 to 8 r/min and up to 10 N·m."""
    place = _place(generator, source, loads)
    at = next(
        (v for v in generator.uniform(_LEAST_SPEED, place.top - 50, 200).tolist() if place.free(v, 60.0)), _LEAST_SPEED
    )
    noise = {"speed_noise": float(generator.uniform(1, 8)) * RPM, "load_noise": float(generator.uniform(1, 10))}
    return _made("noise", path(at, (at, 10.0)), _hold(place.load, 10.0), generator, **noise)


def _coarse(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return stays outside and inside a band, seen by a Hall sensor with steps of 2 to 20 r/min."""
    place = _place(generator, source, loads)
    edge, out = _entry(generator, place)
    start = _outside(place, edge, out, 120.0)
    at = edge - out * min((place.high - place.low) / 2, 60.0)
    seconds = max(abs(at - start) / 200, 0.01)
    speed = path(start, (start, 2.0), (at, seconds), (at, 3.0), (start, seconds), (start, 1.5))
    pulses = int(generator.integers(300, 3001))
    return _made("coarse sensor", speed, _hold(place.load, speed[-1][0]), generator, pulses=pulses)


def _stop(generator: np.random.Generator, source: BandSource, loads: tuple[float, float]) -> Scenario:
    """Return a run below every band that stops and turns back."""
    load = float(generator.uniform(*loads))
    lowest = min((band.low / RPM for band in source.at(load)), default=600.0)
    at = float(generator.uniform(0.3, 0.7)) * lowest
    speed = path(at, (at, 2.0), (0.0, at / 300), (0.0, 1.0), (-at, at / 300), (-at, 2.0))
    return _made("stop", speed, _hold(load, speed[-1][0]), generator)


FAMILIES: dict[str, Callable[[np.random.Generator, BandSource, tuple[float, float]], Scenario]] = {
    "ramp": _ramp,
    "inside": _inside,
    "beside": _beside,
    "edge": _edge,
    "load step": _load_step,
    "load ramp": _load_ramp,
    "noise": _noise,
    "coarse sensor": _coarse,
    "stop": _stop,
    "ramp again": _ramp,
}
"""What makes a run of each kind; ramps come twice, for notice before a band is what takes most runs to measure."""
