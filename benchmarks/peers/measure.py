"""Cost at equal error: `python -m benchmarks.peers` prints one JSON object.

The lane kernel marches both tasks (`task.tasks`) at its default step, without tangent and statistics, which the others
do not have either; its error sets the mark. Across impacts it also does so with fewer steps a period
(`impacts_136_steps` and so on): there it has order two, so steps are saved that buy little. In contact the longest step
allowed is the default one's. Each peer gets the coarsest tolerance, in steps of a quarter decade, whose error is no
larger. Times are of one core, a mesh period of one motion; what is made once for many runs (symbols, compiled code,
tables) is not in them. Each repeat of a ratio times the peer and the kernel one right after the other, by processor
time: all of them use one thread, and a run of seconds is disturbed more often than one of milliseconds.

`scipy_rk45` runs on a compiled right-hand side; `scipy_rk45_public` is the same on `System.derivative`, plain NumPy and
the whole train, at the tolerance found for the first. `jitcode` is the quicker of its two integrators, `heyoka` batch
mode with its own event detection. `kernel_full_microseconds` is the kernel with tangent and force statistics.
"""

from collections.abc import Callable
from math import pi
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.lanes import block_run
from benchmarks.machine import installed
from benchmarks.peers.heyoka_batch import HeyokaBatch
from benchmarks.peers.jitcode_peer import INTEGRATORS, JitCode
from benchmarks.peers.scipy_rk45 import ScipyRk45
from benchmarks.peers.task import Peer, Run, Task, outside_reference, reference, tasks
from benchmarks.ratio import Findings, Ratio
from benchmarks.timing import Work, best_of, seconds_of
from seat_gear_dynamics import load_system
from seat_gear_dynamics.motion import OperatingPoint, System
from seat_gear_dynamics.motion.lanes import WIDTH, respond_lanes
from seat_gear_dynamics.motion.tables import TARGET_STEPS

Array = NDArray[np.float64]

QUARTERS = tuple(10.0 ** (-n / 4) for n in range(12, 45))
"""Tolerances from 1e-3 to 1e-11."""
HALVES = QUARTERS[::2]
REACH = {"scipy_rk45": 1000.0, "jitcode": 100.0, "heyoka": 1.0}
REPEATS = 5
COARSER = {"contact": (), "impacts": (136, 68)}
"""Steps a period that set a mark beside the default ones."""
_IN_SUCCESSION = 2  # settings that have to meet the mark before the search ends: one may do so by luck
_AGAIN = 20  # marches of the kernel for one timing, which then lasts some tens of milliseconds


class Met(NamedTuple):
    """The cheapest setting of a peer whose error is no larger than the mark."""

    setting: float
    error: float
    seconds: float
    run: Run


class Mark(NamedTuple):
    """A task, what is known of it (see `reference`), and the kernel's steps a period that set the mark."""

    name: str
    task: Task
    steps: int
    ends: Array
    changes: Array


def measure(*, short: bool = False, form: str = "printed", progress: Callable[[str], None] | None = None) -> Findings:
    """Measure all peers that are installed; `short`: fewer periods and motions, wider steps of the tolerance."""
    figures: dict[str, Any] = {"form": form}
    ratios: dict[str, Ratio] = {}
    for task in tasks(load_system().train, points=WIDTH, periods=20 if short else 100):
        known = reference(task)
        for steps in (TARGET_STEPS, *(() if short else COARSER[task.name])):
            name = task.name if steps == TARGET_STEPS else f"{task.name}_{steps}_steps"
            mark = Mark(name, task, steps, *known)
            figures[name] = _task(mark, form, ratios, short=short, progress=progress)
    absent = [name for name in ("jitcode", "heyoka") if not installed(name)]
    skipped = f"Not installed, left out: {', '.join(absent)}; pip install '.[peers]' brings them." if absent else None
    return Findings(figures, ratios, skipped)


def _task(
    at: Mark, form: str, ratios: dict[str, Ratio], *, short: bool, progress: Callable[[str], None] | None
) -> dict[str, Any]:
    task, pair = at.task, at.task.pair(form)
    exact = pair.of_whole(at.ends)
    kernel = kernel_run(task, at.steps, full=False)
    kernel()
    mark, unit = kernel_error(task, at.steps, form, exact), 1e6 / task.periods
    own = best_of(kernel, 3, process_time) / _AGAIN / WIDTH
    full = kernel_run(task, at.steps, full=True)
    full()
    figures: dict[str, Any] = {
        "frequencies": task.frequencies.tolist(),
        "load": task.load,
        "periods": task.periods,
        "contact_changes": at.changes.tolist(),
        "kernel_steps": at.steps,
        "error": mark,
        "kernel_microseconds": own * unit,
        "kernel_full_microseconds": best_of(full, 3, process_time) / _AGAIN / WIDTH * unit,
        "peers": {},
    }
    if not short:
        checked = outside_reference(pair, float(task.frequencies[0]), task.periods)
        figures["reference_against_dop853"] = float(np.abs(checked - exact[0]).max())
    for name, own_task, peers in _peers(task, form, short=short):
        if progress is not None:
            progress(f"{name}, {at.name}")
        met = [m for peer in peers if (m := cheapest(peer, _rows(task, own_task, exact), mark)) is not None]
        if not met:
            figures["peers"][name] = {"error": None, "reason": "no tolerance tried meets the mark"}
            continue
        best = min(met, key=lambda m: m.seconds)
        count = len(own_task.frequencies)
        meaning = f"{name} over the lane kernel at equal error, {at.name}"
        times = _in_turn(best.run, count, kernel)
        ratios[f"kernel_over_{name}_{at.name}"] = Ratio(times, meaning, reach=REACH[name])
        figures["peers"][name] = _figures(best, count, unit)
        if name == "scipy_rk45":
            figures["peers"]["scipy_rk45_public"] = _public(task, best.setting)
    return figures


def _figures(best: Met, count: int, unit: float) -> dict[str, float]:
    return {"tolerance": best.setting, "error": best.error, "microseconds": best.seconds / count * unit}


def _peers(task: Task, form: str, *, short: bool) -> list[tuple[str, Task, list[Peer]]]:
    """Return (name, the motions that it runs, its ways) of each peer that is installed."""
    few, settings = task.some(2 if short else 4), HALVES if short else QUARTERS
    found: list[tuple[str, Task, list[Peer]]] = [("scipy_rk45", few, [ScipyRk45(few, settings, form=form)])]
    if installed("jitcode"):
        found.append(("jitcode", few, [JitCode(few, settings, name, form=form) for name in INTEGRATORS]))
    if installed("heyoka"):
        found.append(("heyoka", task, [HeyokaBatch(task, settings, form=form)]))
    return found


def _rows(task: Task, part: Task, exact: Array) -> Array:
    """Return the exact ends of the motions of `part`."""
    return exact[np.searchsorted(task.frequencies, part.frequencies)]


def cheapest(peer: Peer, exact: Array, mark: float) -> Met | None:
    """Return the quickest of the peer's settings whose error is at most `mark`; None where none of them is."""
    met: list[Met] = []
    in_succession = 0
    for setting in peer.settings:
        run = peer.prepare(setting)
        error = float(np.abs(run() - exact).max())
        in_succession = in_succession + 1 if error <= mark else 0
        if error <= mark:
            met.append(Met(setting, error, best_of(run, 3, process_time), run))
        if in_succession == _IN_SUCCESSION:
            break
    return min(met, key=lambda m: m.seconds, default=None)


def _in_turn(run: Run, motions: int, kernel: Work) -> tuple[float, ...]:
    """Return the peer's seconds for a motion over the kernel's, for each repeat."""

    def seconds(action: Callable[[], object]) -> float:
        return best_of(action, 2, process_time)

    return tuple(seconds(run) / motions / (seconds(kernel) / _AGAIN / WIDTH) for _ in range(REPEATS))


def kernel_run(task: Task, steps: int, *, full: bool) -> Work:
    """Return what marches all motions of the task in one block, _AGAIN times over."""
    march = block_run(task.train, WIDTH, full=full, frequency=task.frequencies, periods=task.periods, steps=steps)

    def run() -> float:
        return sum(march() for _ in range(_AGAIN))

    return run


def kernel_error(task: Task, steps: int, form: str, exact: Array) -> float:
    """Return the largest component of the kernel's error at the end of the task."""
    found = respond_lanes(
        task.train,
        task.frequencies,
        task.load,
        transient=0,
        periods=task.periods,
        tangent=False,
        statistics=False,
        meshes=1,
        threads=1,
        target_steps=steps,
    )
    return float(np.abs(task.pair(form).of_whole(found.state) - exact).max())


def _public(task: Task, tolerance: float) -> dict[str, float]:
    """Return what RK45 takes on the public right-hand side for one motion; a part of its periods is enough."""
    frequency, periods = float(task.frequencies[0]), min(task.periods, 20)
    system = System(task.train, OperatingPoint(frequency, task.load))
    end = 2 * pi / frequency * periods

    def run() -> object:
        return solve_ivp(
            system.derivative, (0.0, end), system.static_state(), method="RK45", rtol=tolerance, atol=tolerance
        )

    return {"tolerance": tolerance, "microseconds": seconds_of(run, process_time) / periods * 1e6}
