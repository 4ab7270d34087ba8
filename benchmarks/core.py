"""The march of one motion and the virtual sensor on it: `python -m benchmarks.core` prints one JSON object.

- `march`: steps a second of `motion.March`, which always marches the whole train with its tangent, for pairs apart and
  coupled by a shaft; over the calibration loop's steps a second as `march_over_calibration`.
- `sensor`: seconds of a bench that the virtual sensor goes through in a second of one core at 2060 r/min and 600 N·m,
  samples at 100 Hz: with the published time scale and pairs apart, and with the derived one ((15), natural frequency
  near 18 kHz) and the coupled train. The same over what a calibration takes, to compare between machines.

Times are the processor's: all of it runs in one thread.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import pi
from typing import Any

from benchmarks.calibration import UNIT, calibration_run
from benchmarks.ratio import Findings, Ratio, quotients
from benchmarks.timing import Array, Work, best_in_groups, in_turn
from seat_gear_dynamics import VirtualSensor, load_system
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import Inputs, March

SHAFT = 2.6e4
"""Stiffness of a steel shaft of 16 mm by 20 mm, N·m/rad."""
SPEED, LOAD, SAMPLE = 2060 * RPM, 600.0, 0.01
PERIODS = 10


def coupled(train: GearTrain) -> GearTrain:
    """Return `train` with a shaft and the time scale of (15)."""
    model = replace(train.model, time_scale=train.derived_time_scale)
    return replace(train.with_shaft(SHAFT), model=model)


def march_run(train: GearTrain, frequency: float = 1.0) -> Work:
    """Return what marches one motion from rest through PERIODS mesh periods and returns its steps."""
    march, drive = March(train, load=LOAD), Inputs(frequency, LOAD)

    def run() -> float:
        march.restart(LOAD)
        march.advance((0.0, drive), ((PERIODS - 1e-4) * 2 * pi / frequency, drive))
        return float(march.steps_per_period * PERIODS)

    return run


def sensor_run(train: GearTrain, samples: int) -> Work:
    """Return what feeds `samples` to a sensor that runs on and on, and returns the seconds of the bench in them."""
    sensor, count = VirtualSensor(train), _counting()
    sensor.update(0.0, SPEED, LOAD)

    def run() -> float:
        for _ in range(samples):
            sensor.update(SAMPLE * next(count), SPEED, LOAD)
        return SAMPLE * samples

    return run


def _counting() -> Iterator[int]:
    n = 0
    while True:
        n += 1
        yield n


def measure(*, short: bool = False, progress: Callable[[str], None] | None = None) -> Findings:
    """Measure march and sensor; `short` takes fewer rounds."""
    if progress is not None:
        progress("march and sensor")
    train = load_system().train
    runs: dict[str, Work] = {
        "calibration": calibration_run,
        "pair": march_run(train),
        "coupled": march_run(train.with_shaft(SHAFT)),
        "sensor_published": sensor_run(train, 20),
        "sensor_derived_coupled": sensor_run(coupled(train), 5),
    }
    found = best_in_groups(in_turn(runs, 15 if short else 50))
    return Findings(_figures(found), _ratios(found))


def _figures(found: dict[str, Array]) -> dict[str, Any]:
    return {
        "march_million_steps_per_second": {name: found[name].max() / 1e6 for name in ("pair", "coupled")},
        "calibration_seconds": UNIT / found["calibration"].max(),
    }


def _ratios(found: dict[str, Array]) -> dict[str, Ratio]:
    calibrations = found["calibration"] / UNIT
    ratios = {
        f"march_{name}_over_calibration": Ratio(
            quotients(found[name], found["calibration"]), "march steps in the time of a step of the calibration loop"
        )
        for name in ("pair", "coupled")
    }
    for name, reach in (("published", 20.0), ("derived_coupled", 3.0)):
        rate = found[f"sensor_{name}"]
        ratios[f"sensor_{name}_times_real_time"] = Ratio(tuple(rate.tolist()), "bench seconds in a second", reach=reach)
        ratios[f"sensor_{name}_per_calibration"] = Ratio(
            quotients(rate, calibrations), "bench seconds in the time of a calibration"
        )
    return ratios


if __name__ == "__main__":
    print(json.dumps(measure().as_dict(), indent=1))
