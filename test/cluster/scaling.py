"""What points cost here and through Dask on loopback: `PYTHONPATH=test/support python test/cluster/scaling.py`
prints JSON, part by part.

Figures of docs/scaling.md. `core`: processor time of a point and its parts, and the bytes that come back. `loopback`:
processor time that worker, scheduler and client spend on a point, for several block sizes, and on a block of no work;
processor time hardly sees what else the machine does. `wall`: points a second of wall time by threads and by workers,
which does see it: `load_average` says how much that was.
"""

import json
import math
import os
import pickle
import sys
import tempfile
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from time import perf_counter, process_time, sleep, thread_time
from typing import Any

import numpy as np
from dask_cluster import Cluster

from seat_gear_dynamics import load_system
from seat_gear_dynamics.cluster.build import build
from seat_gear_dynamics.cluster.dask_workers import DaskWorkers, connected
from seat_gear_dynamics.commands.journal import Journal
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes.map_nodes import MapGrid, map_nodes
from seat_gear_dynamics.regimes.points import answers, regime_of
from seat_gear_dynamics.regimes.sweep import sweep_each
from seat_gear_dynamics.regimes.sweep_plan import Plan
from seat_gear_dynamics.regimes.sweep_table import Lines, lines
from seat_gear_dynamics.regimes.workers import Threads

POINTS = 1024
ROUNDS = 2
LOAD = 600.0
TICK = 1 / os.sysconf("SC_CLK_TCK")


def spent(work: Callable[[], Any]) -> float:
    """Return the least processor time of some rounds, ms a point; a first round warms up."""
    work()
    best = math.inf
    for _ in range(ROUNDS):
        begin = thread_time()
        work()
        best = min(best, thread_time() - begin)
    return round(1e3 * best / POINTS, 4)


def core(system: System, transient: int, periods: int) -> dict[str, float]:
    """Return what a point costs one core: the march, the judgement, the text of its row, and what travels."""
    plan = Plan("frequency", 0.5, 2.0, POINTS, transient=transient, periods=periods)
    points = [plan.point(system, value) for value in plan.values("cold", range(POINTS))]

    def marched() -> list[Any]:
        return [found for first in range(0, POINTS, 32) for found in answers(system.train, points[first : first + 32])]

    motions = marched()
    rows = list(sweep_each(system, plan, _itself))
    texts = [lines(row) for row in rows]
    return {
        "march_ms": spent(marched),
        "judgement_ms": spent(lambda: [regime_of(found) for found in motions]),
        "text_ms": spent(lambda: [lines(row) for row in rows]),
        "row_bytes": round(len(pickle.dumps(texts)) / POINTS),
        "disk_bytes": round(sum(len(text.table) + len(text.points) for text in texts) / POINTS),
        "write_ms": spent(lambda: written(texts)),
    }


def written(texts: list[Lines]) -> None:
    """Write rows as the command does."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / "f.csv", Path(folder) / "f_points.csv"]
        with Journal(paths[0], paths, {}) as journal:
            for number, text in enumerate(texts):
                journal.add((text.table, text.points), {"rows": number})
                journal.flush()


def _itself(row: Any) -> Any:
    return row


def map_points(system: System, workers: Any) -> int:
    side = math.isqrt(POINTS)
    speeds = np.array([system.train.speed(frequency) for frequency in np.linspace(0.5, 2.0, side)])
    grid = MapGrid(speeds, np.linspace(100.0, 700.0, side))
    return sum(len(block) for block in map_nodes(system.train, grid, workers=workers))


def sweep_points(system: System, workers: Any) -> int:
    plan = Plan("frequency", 0.5, 2.0, POINTS)
    return sum(1 for _ in sweep_each(system, plan, lines, workers=workers))


def chain_points(system: System, workers: Any) -> int:
    plan = Plan("frequency", 0.5, 2.0, 32, "both")
    return sum(1 for _ in sweep_each(system, plan, lines, workers=workers))


def empty_blocks(workers: DaskWorkers) -> int:
    with closing(workers.compute(math.sqrt, map(float, range(1000)))) as found:
        return sum(1 for _ in found)


def processor_time(cluster: Cluster) -> tuple[float, float, float]:
    """Return what the workers, the scheduler and this process have spent, s."""
    others = [[worker.process.pid for worker in cluster.workers], [cluster.scheduler.process.pid]]
    workers, scheduler = (sum(map(_of_process, numbers)) for numbers in others)
    return workers, scheduler, process_time()


def _of_process(number: int) -> float:
    fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
    return TICK * (int(fields[11]) + int(fields[12]))


def idle(cluster: Cluster) -> tuple[float, float, float]:
    """Return the processor time a second of wall time that workers, scheduler and client spend on nothing."""
    before, begin = processor_time(cluster), perf_counter()
    sleep(4)
    passed, after = perf_counter() - begin, processor_time(cluster)
    workers, scheduler, client = ((b - a) / passed for a, b in zip(before, after, strict=True))
    return workers, scheduler, client


def shares(cluster: Cluster, nothing: tuple[float, float, float], work: Callable[[], int]) -> dict[str, float]:
    """Return processor time of workers, scheduler and client a piece, ms, and pieces a second of wall time.

    Without what they spend on `nothing`, which grows with time and not with pieces.
    """
    work()
    before, begin = processor_time(cluster), perf_counter()
    done = sum(work() for _ in range(ROUNDS))
    passed, after = perf_counter() - begin, processor_time(cluster)
    times = zip(("workers_ms", "scheduler_ms", "client_ms"), before, after, nothing, strict=True)
    found = {name: round(1e3 * (b - a - base * passed) / done, 4) for name, a, b, base in times}
    return found | {"a_second": round(done / passed, 1)}


def loopback(system: System, count: int) -> dict[str, Any]:
    """Return what `count` workers of one thread each do."""
    with tempfile.TemporaryDirectory() as folder:
        cluster = Cluster(Path(folder))
        try:
            cluster.start(count)
            with connected(cluster.address) as found:
                nothing = idle(cluster)
                measure = partial(shares, cluster, nothing)
                report: dict[str, Any] = {"idle": nothing, "empty": measure(partial(empty_blocks, found))}
                for block in (16, 64, 256):
                    sized = DaskWorkers(found._client, cluster.address, block=block)
                    report[f"map {block}"] = measure(partial(map_points, system, sized))
                    report[f"sweep {block}"] = measure(partial(sweep_points, system, sized))
                found._client.direct_to_workers = False
                report["sweep 256 through the scheduler"] = measure(partial(sweep_points, system, sized))
                report["both"] = measure(partial(chain_points, system, found))
                return report
        finally:
            cluster.close()


def threads(system: System, count: int) -> dict[str, float]:
    """Return points a second of wall time by threads of this process."""
    report = {}
    for name, work in (("map", map_points), ("sweep", sweep_points), ("both", chain_points)):
        work(system, Threads(count))
        begin = perf_counter()
        done = sum(work(system, Threads(count)) for _ in range(ROUNDS))
        report[name] = round(done / (perf_counter() - begin), 1)
    return report


def main() -> None:
    """Measure what the arguments name, default everything."""
    system = load_system().at(load=LOAD)
    parts: dict[str, Callable[[], Any]] = {
        "build": lambda: dict(build()),
        "core 400+200": lambda: core(system, 400, 200),
        "core 600+400": lambda: core(system, 600, 400),
        **{f"threads {count}": partial(threads, system, count) for count in (1, 2)},
        **{f"loopback {count}": partial(loopback, system, count) for count in (1, 2)},
    }
    for name, part in parts.items():
        if not sys.argv[1:] or name in sys.argv[1:]:
            print(json.dumps({name: part(), "load_average": os.getloadavg()[0]}), flush=True)


if __name__ == "__main__":
    main()
