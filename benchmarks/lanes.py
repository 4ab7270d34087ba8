"""What the lane kernel costs, as ratios within one run: `python -m benchmarks.lanes` prints one JSON object.

Rates are Runge-Kutta steps of one lane in a second on one core. Short runs are taken in turn, so that what else the
machine does falls on all alike; the best of each fifth of the rounds counts.

- `pair`, `coupled`: P12 alone, and the train with a shaft. `full` has tangent and force statistics, `bare` neither.
- `over_single_lane`: over the same generated code with blocks of one lane. `over_march`: over `motion.March`, which
  always marches the whole train with tangent and statistics.
- `over_calibration`: over the steps a second of the calibration loop, the figure to compare between machines.
- `share_of_peak`: floating-point operations a second over those of independent multiply-adds in vectors from a
  first-level cache, measured in the same run. Additions that are fused with no product can come on top of that.
- `all_threads`: the public call on many points, in steps a second of the whole machine.
"""

import ast
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numba import njit

from benchmarks.calibration import calibration_run
from benchmarks.core import LOAD, SHAFT, march_run
from benchmarks.ratio import Findings, Ratio, quotients
from benchmarks.timing import Array, Work, best_in_groups, best_of, in_turn
from seat_gear_dynamics import load_system
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes import WIDTH, respond_lanes
from seat_gear_dynamics.motion.lanes.batch import entry, rows
from seat_gear_dynamics.motion.lanes.block import Run, aligned, march_block
from seat_gear_dynamics.motion.lanes.excitation import grid
from seat_gear_dynamics.motion.lanes.kernel import kernel, kernel_source
from seat_gear_dynamics.motion.lanes.points import LanePoints, checked
from seat_gear_dynamics.motion.lanes.source import advance_source
from seat_gear_dynamics.motion.lanes.structure import Structure, structure_of
from seat_gear_dynamics.motion.march import LONGEST_STEP
from seat_gear_dynamics.motion.tables import TARGET_STEPS

PERIODS = 10
CHAIN, ROOM = 8, 1024  # long enough to hide latency, small enough for a first-level cache


def multiply_add_source() -> str:
    """Return the source of a loop of multiply-adds that only the machine's arithmetic limits."""
    chain = "".join("            x = x * a + b\n" for _ in range(CHAIN))
    head = (
        f"def vector_multiply_add(values, a, b, count):\n    for _ in range(count):\n        for i in range({ROOM}):\n"
    )
    return f"{head}            x = values[i]\n{chain}            values[i] = x\n"


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


def block_run(
    train: GearTrain,
    width: int,
    *,
    full: bool,
    frequency: Array | None = None,
    periods: int = PERIODS,
    steps: int = TARGET_STEPS,
) -> Work:
    """Return what marches one block from rest at 600 N·m through `periods` and returns its steps.

    `frequency`, (width,), is by default spread over the range of the studies.
    """
    points = checked(LanePoints(np.linspace(0.4, 2.0, width) if frequency is None else frequency, LOAD))
    ready = entry(train, points, meshes=None, target_steps=steps, longest_step=LONGEST_STEP)
    ((company, lanes),) = ready.companies()
    table, half_step = rows(company.structure, [(ready, lanes)])
    shared = grid(company.excitation, company.level, company.direction)
    compiled = kernel(replace(company.structure, tangent=full, statistics=full), width=width)
    run = Run(0, periods, compiled, compiled)

    def march() -> float:
        march_block(table, half_step, shared, run)
        return float(shared.steps * periods * width)

    return march


def peak_run() -> Work:
    """Return what makes multiply-adds in vectors as fast as the core can, and returns its operations."""
    module: dict[str, Any] = {}
    exec(multiply_add_source(), module)
    vector_multiply_add: Any = njit(fastmath={"contract"})(module["vector_multiply_add"])
    values = aligned(ROOM)
    values[:] = 1.0

    def run() -> float:
        vector_multiply_add(values, 0.999, 1e-3, 100)
        return 2.0 * 100 * CHAIN * ROOM

    return run


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
    seconds = best_of(lambda: respond_lanes(train, frequency, 600.0, transient=0, periods=60))
    return 272 * 60 * 2048 / seconds / 1e6


def measure(*, short: bool = False, progress: Callable[[str], None] | None = None) -> Findings:
    """Measure the kernels; `short` takes fewer rounds, one kernel of one lane, no machine code and no threads."""
    if progress is not None:
        progress("lane kernels")
    pair = load_system().train
    trains = {"pair": pair, "coupled": pair.with_shaft(SHAFT)}
    runs: dict[str, Work] = {"calibration": calibration_run, "peak": peak_run()}
    for name, train in trains.items():
        runs[f"{name} march"] = march_run(train)
        for kind in ("full", "bare"):
            for width in (WIDTH, 1) if not short or (name, kind) == ("pair", "full") else (WIDTH,):
                runs[f"{name} {kind} {width}"] = block_run(train, width, full=kind == "full")
    found = best_in_groups(in_turn(runs, 40 if short else 150))
    figures: dict[str, Any] = {"width": WIDTH, "peak_gigaflops": found["peak"].max() / 1e9}
    for name, train in trains.items():
        figures[name] = {kind: _of_kernel(train, found, name, kind) for kind in ("full", "bare")}
        if not short:
            figures[name]["instructions_with_vectors"] = vectors_used(train)
            figures[name]["all_threads_million_steps_per_second"] = everything(train)
    return Findings(figures, _ratios(found))


def _of_kernel(train: GearTrain, found: dict[str, Array], name: str, kind: str) -> dict[str, float]:
    structure = structure_of(
        train, meshes=2 if train.shaft.couples else 1, tangent=kind == "full", statistics=kind == "full"
    )
    rate = float(found[f"{name} {kind} {WIDTH}"].max())
    return {
        "million_steps_per_second": rate / 1e6,
        "over_march": rate / float(found[f"{name} march"].max()),
        "operations_per_step": operations(structure),
        "gigaflops": rate * operations(structure) / 1e9,
        "share_of_peak": rate * operations(structure) / float(found["peak"].max()),
    }


def _ratios(found: dict[str, Array]) -> dict[str, Ratio]:
    ratios = {}
    for kind in ("full", "bare"):
        for name in ("pair", "coupled"):
            rate = found[f"{name} {kind} {WIDTH}"]
            if f"{name} {kind} 1" in found:
                ratios[f"{name}_{kind}_over_single_lane"] = Ratio(
                    quotients(rate, found[f"{name} {kind} 1"]), "over the same code lane by lane", reach=4.0
                )
            ratios[f"{name}_{kind}_over_calibration"] = Ratio(
                quotients(rate, found["calibration"]), "steps in the time of a step of the calibration loop"
            )
        ratios[f"coupled_over_pair_{kind}"] = Ratio(
            quotients(found[f"coupled {kind} {WIDTH}"], found[f"pair {kind} {WIDTH}"]),
            "rate of the coupled train over that of the pair",
            reach=0.45,
        )
    return ratios


if __name__ == "__main__":
    print(json.dumps(measure().as_dict(), indent=1))
