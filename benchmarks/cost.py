"""What a step costs against lanes, points and threads: `python -m benchmarks.cost [--plot FILE]` prints JSON.

Nanoseconds for a Runge-Kutta step of one motion of the pair, with tangent and force statistics (`full`) or without:

- `lanes`: the kernel alone, in blocks of 1 to 64 lanes, on one core;
- `points`: the public call `respond_lanes` on 1 to 4096 points of 60 periods, on one core and on all;
- `threads`: the same call on 4096 points with 1 to twice as many threads as there are processors.

The limit is what the operations of a step would take if the core's vectors did nothing but multiply-adds: the kernel's
operations over the rate of `lanes.peak_run`, which is the core's vector width at its clock, measured in the same run.
With several threads it is that of as many cores as there are, each as fast as one alone. A core that has pipes for
additions beside those for multiply-adds can pass it: additions that are fused with no product come on top.

Work on one core is timed by the processor's clock, work on several by the wall's.
"""

import argparse
import json
from collections.abc import Callable, Sequence
from os import cpu_count
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from benchmarks.lanes import block_run, operations, peak_run
from benchmarks.ratio import Findings, Ratio, quotients
from benchmarks.timing import Array, Work, best_in_groups, in_turn
from seat_gear_dynamics import load_system
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes import WIDTH, respond_lanes
from seat_gear_dynamics.motion.lanes.structure import structure_of
from seat_gear_dynamics.views.figures.cost import CostCurve, CostPanel, cost_figure
from seat_gear_dynamics.views.figures.style import save

WIDTHS = (1, 2, 4, 8, 16, 32, 64)
POINTS = (1, 4, 16, 64, 256, 1024, 4096)
PERIODS = 60
STEPS = 272
"""Steps of a mesh period at the default target of 256."""


def measure(*, short: bool = False, progress: Callable[[str], None] | None = None) -> Findings:
    """Measure the curves; `short` takes fewer values of each."""
    tell, train = progress or (lambda _: None), load_system().train
    processors = cpu_count() or 1
    widths, points = (WIDTHS[::2], POINTS[:4]) if short else (WIDTHS, POINTS)
    threads = [n for n in (1, 2, 4, 8, 16, 32, 64, 128, 256) if n <= 2 * processors]
    tell("cost against lanes")
    peak, lanes = _lanes(train, widths, rounds=10 if short else 40)
    tell("cost against points and threads")
    rounds = 3 if short else 9
    costs = {
        "lanes": lanes,
        "points": {
            "one": _calls(train, points, [1] * len(points), rounds),
            "all": _calls(train, points, [processors] * len(points), rounds),
        },
        "threads": {"full": _calls(train, [points[-1]] * len(threads), threads, rounds)},
    }
    least = {kind: _operations(train, kind) / peak for kind in ("full", "bare")}
    figures: dict[str, Any] = {
        "values": {"lanes": list(widths), "points": list(points), "threads": threads},
        "nanoseconds": {panel: {k: c.min(axis=1).tolist() for k, c in own.items()} for panel, own in costs.items()},
        "limit_nanoseconds": {kind: 1e9 * seconds for kind, seconds in least.items()},
        "processors": processors,
        "width": WIDTH,
    }
    return Findings(figures, _ratios(costs))


def _operations(train: GearTrain, kind: str) -> int:
    full = kind == "full"
    return operations(structure_of(train, meshes=1, tangent=full, statistics=full))


def _lanes(train: GearTrain, widths: Sequence[int], rounds: int) -> tuple[float, dict[str, Array]]:
    """Return the operations a second of one core's vectors, and ns a step at each width, (widths, groups)."""
    runs: dict[str, Work] = {"peak": peak_run()}
    for kind in ("full", "bare"):
        runs |= {f"{kind} {width}": block_run(train, width, full=kind == "full") for width in widths}
    rates = best_in_groups(in_turn(runs, rounds))
    nanoseconds = {kind: np.array([1e9 / rates[f"{kind} {w}"] for w in widths]) for kind in ("full", "bare")}
    return float(rates["peak"].max()), nanoseconds


def _calls(train: GearTrain, points: Sequence[int], threads: Sequence[int], rounds: int) -> Array:
    """Return ns a step of the public call for each pair of points and threads, all in turn, (pairs, groups)."""
    runs = {str(n): _call(train, *pair) for n, pair in enumerate(zip(points, threads, strict=True))}
    clock = process_time if max(threads) == 1 else perf_counter
    rates = best_in_groups(in_turn(runs, rounds, clock), groups=3)
    return np.array([1e9 / rates[name] for name in runs])


def _call(train: GearTrain, points: int, threads: int) -> Work:
    frequency = np.linspace(0.4, 2.0, points)

    def run() -> float:
        respond_lanes(train, frequency, 600.0, transient=0, periods=PERIODS, threads=threads)
        return float(STEPS * PERIODS * points)

    return run


def _ratios(found: dict[str, dict[str, Array]]) -> dict[str, Ratio]:
    def ratio(costs: Array, meaning: str) -> Ratio:
        return Ratio(quotients(costs[0], costs[-1]), meaning)

    return {
        "lanes_most_over_one": ratio(found["lanes"]["full"], "cost of a step, one lane over the most"),
        "points_most_over_one": ratio(found["points"]["one"], "cost of a step, one point over the most, one core"),
        "threads_most_over_one": ratio(found["threads"]["full"], "cost of a step, one thread over the most"),
    }


def panels(figures: dict[str, Any]) -> list[CostPanel]:
    """Return what `cost_figure` draws of the figures found."""
    limit, processors, values = figures["limit_nanoseconds"], figures["processors"], figures["values"]

    def curve(panel: str, key: str, name: str, kind: str, cores: Sequence[int]) -> CostCurve:
        return CostCurve(name, values[panel], figures["nanoseconds"][panel][key], [limit[kind] / n for n in cores])

    cores = [min(n, processors) for n in values["threads"]]
    ones, of_points = [1] * len(values["lanes"]), len(values["points"])
    return [
        CostPanel(
            "kernel, one core",
            "lanes of a block",
            [
                curve("lanes", "full", "tangent and statistics", "full", ones),
                curve("lanes", "bare", "state alone", "bare", ones),
            ],
        ),
        CostPanel(
            "public call",
            f"points of {PERIODS} periods",
            [
                curve("points", "one", "one core", "full", [1] * of_points),
                curve("points", "all", f"{processors} cores", "full", [processors] * of_points),
            ],
        ),
        CostPanel(
            f"public call, {values['points'][-1]} points",
            f"threads on {processors} processors",
            [curve("threads", "full", "tangent and statistics", "full", cores)],
        ),
    ]


def draw(figures: dict[str, Any], path: Path) -> None:
    """Draw the figures found into a file."""
    save(cost_figure(panels(figures)), path)


def main() -> None:
    """Measure, draw if asked, and print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help="fewer values")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the curves into this file")
    arguments = parser.parse_args()
    found = measure(short=arguments.short)
    if arguments.plot is not None:
        draw(found.figures, arguments.plot)
    print(json.dumps(found.as_dict(), indent=1))


if __name__ == "__main__":
    main()
