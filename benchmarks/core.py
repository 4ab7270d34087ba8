"""What the core costs, as ratios within one run: `python benchmarks/core.py` prints one JSON object.

- `march_over_scipy`: a mesh period by the march against one by SciPy's RK45 on the public derivative, at the error that
  the march has against a converged solution.
- `sensor_times_real_time`: the virtual sensor at 2060 r/min and 600 N·m, samples at 100 Hz, published time scale.
- `steps_per_calibration_flop`: march steps a second over a plain compiled multiply-add loop's operations a second, the
  figure to compare between machines.
"""

import json
from collections.abc import Callable
from math import pi
from time import perf_counter
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from seat_gear_dynamics import VirtualSensor, load_system
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import Inputs, March, integrate

PERIODS = 40


def _multiply_add(count: int) -> float:
    x = 1.0
    for _ in range(count):
        x = x * 0.999999 + 1e-6
    return x


multiply_add: Any = njit(_multiply_add)


def best_of(action: Callable[[], object], repeats: int = 3) -> float:
    """Return the shortest time of an action, s: the one that was disturbed least."""
    times = []
    for _ in range(repeats):
        begin = perf_counter()
        action()
        times.append(perf_counter() - begin)
    return min(times)


def main() -> None:
    system = load_system().at(frequency=0.5, load=600.0)
    start, end = system.static_state(), PERIODS * 2 * pi / 0.5
    exact = integrate(system, transient=0, periods=PERIODS, target_steps=8192).state
    found = integrate(system, transient=0, periods=PERIODS)
    march, drive = March(system.train), Inputs(0.5, 600.0)

    def run() -> None:
        march.restart(600.0)
        march.advance((0.0, drive), (end, drive))

    march_time = best_of(run)
    march_error = float(np.abs(found.state - exact).max())
    scipy_time, scipy_error, tolerance = 0.0, np.inf, 1e-4
    while scipy_error > march_error and tolerance > 1e-12:
        begin = perf_counter()
        solution = solve_ivp(system.derivative, (0.0, end), start, method="RK45", rtol=tolerance, atol=tolerance * 1e-2)
        scipy_time = perf_counter() - begin
        scipy_error = float(np.abs(solution.y[:, -1] - exact).max())
        tolerance /= 10

    sensor = VirtualSensor(system)
    sensor.update(0.0, 2060 * RPM, 600.0)
    begin = perf_counter()
    for k in range(1, 301):
        sensor.update(0.01 * k, 2060 * RPM, 600.0)
    sensor_time = perf_counter() - begin

    multiply_add(1)
    loop_time = best_of(lambda: multiply_add(10_000_000))
    steps = 272 * PERIODS / march_time
    print(
        json.dumps(
            {
                "march_over_scipy": scipy_time / march_time,
                "march_error": march_error,
                "scipy_error": scipy_error,
                "sensor_times_real_time": 3.0 / sensor_time,
                "million_steps_per_second": steps / 1e6,
                "steps_per_calibration_flop": steps / (2e7 / loop_time),
            }
        )
    )


if __name__ == "__main__":
    main()
