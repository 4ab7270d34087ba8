"""What the lane kernel costs, as ratios within one run: `python benchmarks/lanes.py` prints one JSON object.

Rates are Runge-Kutta steps of one lane in a second on one core. Every figure is the best of many short runs taken in
turn, so that what else the machine does falls on all alike and mostly drops out; `load_average` says how much that was.

- `pair`, `coupled`: P12 alone, and the train with a shaft. `full` has tangent and force statistics, `bare` neither.
- `over_single_lane`: over the same generated code with blocks of one lane. `over_march`: over `motion.March`, which
  always marches the whole train with tangent and statistics.
- `steps_per_calibration_flop`: over the operations a second of a plain compiled multiply-add loop, one after the other:
  the figure to compare between machines.
- `share_of_peak`: floating-point operations a second over those of independent multiply-adds in vectors from a
  first-level cache, measured in the same run. Additions that are fused with no product can come on top of that.
- `all_threads`: the public call on many points, in steps a second of the whole machine.
"""

import ast
import json
from collections.abc import Callable
from dataclasses import replace
from os import cpu_count, getloadavg
from time import perf_counter
from typing import Any

import numpy as np
from numba import njit

from seat_gear_dynamics import load_system
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March
from seat_gear_dynamics.motion.lanes import WIDTH, respond_lanes
from seat_gear_dynamics.motion.lanes.batch import entry, rows
from seat_gear_dynamics.motion.lanes.block import Run, aligned, march_block
from seat_gear_dynamics.motion.lanes.excitation import grid
from seat_gear_dynamics.motion.lanes.kernel import kernel, kernel_source
from seat_gear_dynamics.motion.lanes.points import LanePoints, checked
from seat_gear_dynamics.motion.lanes.source import advance_source
from seat_gear_dynamics.motion.lanes.structure import Structure, structure_of

SHAFT = 2.6e4
ROUNDS = 150
PERIODS = 10
CHAIN, ROOM = 8, 1024  # long enough to hide latency, small enough for a first-level cache


def multiply_add_source() -> str:
    chain = "".join("            x = x * a + b\n" for _ in range(CHAIN))
    head = (
        f"def vector_multiply_add(values, a, b, count):\n    for _ in range(count):\n        for i in range({ROOM}):\n"
    )
    return f"{head}            x = values[i]\n{chain}            values[i] = x\n"


def _multiply_add(x: float, count: int) -> float:
    for _ in range(count):
        x = x * 0.999999 + 1e-6
    return x


multiply_add: Any = njit(_multiply_add)


def operations(structure: Structure) -> int:
    """Return additions, multiplications, minima and maxima of one lane's step; indexing is none of them."""
    count = 0
    for line in advance_source(structure, WIDTH).splitlines():
        if "lane in range" in line or " = " not in line or not line.startswith("            "):
            continue
        for node in ast.walk(ast.parse(line.strip())):
            if isinstance(node, ast.BinOp):
                count += not (isinstance(node.right, ast.Name) and node.right.id == "lane")
            elif isinstance(node, ast.Call):
                count += 1
    return count


def block_run(train: GearTrain, width: int, *, full: bool) -> Callable[[], float]:
    """Return what marches one block through PERIODS and returns its steps."""
    points = checked(LanePoints(np.linspace(0.4, 2.0, width), 600.0))
    ready = entry(train, points, meshes=None, target_steps=256, longest_step=0.1)
    ((company, lanes),) = ready.companies()
    table, half_step = rows(company.structure, [(ready, lanes)])
    shared = grid(company.excitation, company.level, company.direction)
    compiled = kernel(replace(company.structure, tangent=full, statistics=full), width=width)
    run = Run(0, PERIODS, compiled, compiled)

    def march() -> float:
        march_block(table, half_step, shared, run)
        return float(shared.steps * PERIODS * width)

    return march


def march_run(train: GearTrain) -> Callable[[], float]:
    """Return what marches one trajectory by the production march through PERIODS and returns its steps."""
    march, drive = March(train, load=600.0), Inputs(1.0, 600.0)

    def run() -> float:
        march.restart(600.0)
        march.advance((0.0, drive), ((PERIODS - 1e-4) * 2 * np.pi, drive))
        return float(march.steps_per_period * PERIODS)

    return run


def rates(runs: dict[str, Callable[[], float]]) -> dict[str, float]:
    """Return what each run does in a second, the best of ROUNDS rounds in which all take their turn."""
    best = dict.fromkeys(runs, 0.0)
    for run in runs.values():
        run()
    for _ in range(ROUNDS):
        for name, run in runs.items():
            begin = perf_counter()
            done = run()
            best[name] = max(best[name], done / (perf_counter() - begin))
    return best


def peak_run() -> Callable[[], float]:
    module: dict[str, Any] = {}
    exec(multiply_add_source(), module)
    vector_multiply_add: Any = njit(fastmath={"contract"})(module["vector_multiply_add"])
    values = aligned(ROOM)
    values[:] = 1.0

    def run() -> float:
        vector_multiply_add(values, 0.999, 1e-3, 100)
        return 2.0 * 100 * CHAIN * ROOM

    return run


def calibration_run() -> float:
    multiply_add(0.5, 100_000)  # 1.0 would be a fixed point, at which a compiler may stop
    return 2e5


def vectors_used(train: GearTrain) -> dict[str, int]:
    """Return how many instructions of the full kernel's step use vector registers of each width."""
    module: dict[str, Any] = {}
    structure = structure_of(train, meshes=2 if train.shaft.couples else 1)
    exec(kernel_source(structure, WIDTH, cache=False), module)  # code from a cache cannot be looked at
    text = "".join(module["advance"].inspect_asm().values()).splitlines()
    return {register: sum(register in line for line in text) for register in ("zmm", "ymm", "xmm")}


def everything(train: GearTrain) -> float:
    """Return million steps a second of the public call, sampling all of 2048 points, with all threads."""
    frequency = np.linspace(0.4, 2.0, 2048)
    best = 0.0
    for _ in range(3):
        begin = perf_counter()
        respond_lanes(train, frequency, 600.0, transient=0, periods=60)
        best = max(best, 272 * 60 * 2048 / (perf_counter() - begin))
    return best / 1e6


def main() -> None:
    pair, coupled = load_system().train, load_system().train.with_shaft(SHAFT)
    runs: dict[str, Callable[[], float]] = {"calibration": calibration_run, "peak": peak_run()}
    for name, train in (("pair", pair), ("coupled", coupled)):
        runs[f"{name} march"] = march_run(train)
        for full in (True, False):
            for width in (WIDTH, 1):
                runs[f"{name} {'full' if full else 'bare'} {width}"] = block_run(train, width, full=full)
    found = rates(runs)
    report: dict[str, Any] = {"load_average": getloadavg()[0], "width": WIDTH, "processors": cpu_count()}
    for name, train in (("pair", pair), ("coupled", coupled)):
        report[name] = {}
        for kind in ("full", "bare"):
            meshes = 2 if train.shaft.couples else 1
            structure = structure_of(train, meshes=meshes, tangent=kind == "full", statistics=kind == "full")
            rate = found[f"{name} {kind} {WIDTH}"]
            report[name][kind] = {
                "million_steps_per_second": rate / 1e6,
                "over_single_lane": rate / found[f"{name} {kind} 1"],
                "over_march": rate / found[f"{name} march"],
                "steps_per_calibration_flop": rate / found["calibration"],
                "operations_per_step": operations(structure),
                "gigaflops": rate * operations(structure) / 1e9,
                "share_of_peak": rate * operations(structure) / found["peak"],
            }
        report[name]["instructions_with_vectors"] = vectors_used(train)
        report[name]["all_threads_million_steps_per_second"] = everything(train)
    for kind in ("full", "bare"):
        report[f"coupled_over_pair_{kind}"] = found[f"coupled {kind} {WIDTH}"] / found[f"pair {kind} {WIDTH}"]
    report["march_million_steps_per_second"] = found["pair march"] / 1e6
    report["peak_gigaflops"] = found["peak"] / 1e9
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
