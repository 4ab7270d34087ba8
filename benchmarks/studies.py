"""What questions about many points cost: `python -m benchmarks.studies` prints one JSON object.

- `diagram`: a bifurcation diagram of 192 frequencies, 500 mesh periods each (300 run in, 200 sampled), with exponents
  and regimes, all processors; meant to take less than 2 s.
- `map`: the regime map of 200 speeds and 60 loads with exponents, 600 periods each, all processors; less than 60 s. The
  short form takes every tenth of the speeds and of the loads.

Both are timed by the wall's clock, and also told in calibrations: the calibration loop runs right before and right
after each repeat.
"""

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.calibration import calibration_seconds
from benchmarks.ratio import Findings, Ratio
from benchmarks.timing import seconds_of
from seat_gear_dynamics import RegimeMap, load_system, sweep
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System

DIAGRAM_REACH, MAP_REACH = 2.0, 60.0
REPEATS = 5


def diagram(system: System) -> object:
    """Compute the diagram of 192 frequencies."""
    return sweep(system, over="frequency", start=0.1, stop=2.01, points=192, transient=300, periods=200)


def regime_map(system: System, every: int = 1) -> object:
    """Compute the map of 200 × 60 points, or of every so many of its speeds and loads."""
    speeds = np.linspace(105.0, 2100.0, 200 // every) * RPM
    return RegimeMap.compute(system, speeds, np.linspace(50.0, 1230.0, 60 // every), transient=400, periods=200)


def measure(*, short: bool = False, progress: Callable[[str], None] | None = None) -> Findings:
    """Measure diagram and map."""
    system, tell = load_system(), progress or (lambda _: None)
    sweep(system, over="frequency", start=0.5, stop=1.5, points=2, transient=2, periods=60)  # compiles
    tell("bifurcation diagram, 192 points")
    seconds, calibrations = repeated(lambda: diagram(system), REPEATS)
    ratios = _ratios("diagram", seconds, calibrations, DIAGRAM_REACH)
    every = 10 if short else 1
    points = (200 // every) * (60 // every)
    tell(f"regime map, {points} points")
    seconds_map, calibrations_map = repeated(lambda: regime_map(system, every), REPEATS if short else 3)
    if short:
        ratios |= _ratios("small_map", seconds_map, calibrations_map, None)
    else:
        ratios |= _ratios("map", seconds_map, calibrations_map, MAP_REACH)
    figures: dict[str, Any] = {
        "diagram": {"points": 192, "periods": 500, "seconds": min(seconds)},
        "map": {"points": points, "periods": 600, "seconds": min(seconds_map)},
    }
    return Findings(figures, ratios)


def repeated(action: Callable[[], object], repeats: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the seconds of each repeat, and the same over what a calibration takes around it."""
    seconds, calibrations = [], []
    before = calibration_seconds()
    for _ in range(repeats):
        seconds.append(seconds_of(action))
        after = calibration_seconds()
        calibrations.append(seconds[-1] / ((before + after) / 2))
        before = after
    return tuple(seconds), tuple(calibrations)


def _ratios(
    name: str, seconds: tuple[float, ...], calibrations: tuple[float, ...], reach: float | None
) -> dict[str, Ratio]:
    return {
        f"{name}_seconds": Ratio(seconds, "seconds with all processors", better="lower", reach=reach),
        f"{name}_in_calibrations": Ratio(calibrations, "calibrations in the same time", better="lower"),
    }


if __name__ == "__main__":
    print(json.dumps(measure().as_dict(), indent=1))
