"""`seat-gear map`: the regime map over speed and load, and the forbidden bands at each load."""

import argparse
import csv
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.computing import add_computing_arguments, interruptible, workers
from seat_gear_dynamics.commands.map_files import MapFiles
from seat_gear_dynamics.commands.output import PICTURE_ENDINGS, path_ending_in
from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from seat_gear_dynamics.cluster.build import Build
    from seat_gear_dynamics.commands.journal import Journal
    from seat_gear_dynamics.gears import GearTrain
    from seat_gear_dynamics.regimes.regime_map import RegimeMap
    from seat_gear_dynamics.regimes.workers import Workers

TEXTS = {
    "map": Texts(
        "regime map over speed and load, and the forbidden bands at each load",
        "seat-gear map --speed-rpm 1200 2100 10 --load 300 600 2 --output map.npz",
    )
}
COLUMNS = (
    "load",
    "speed_rpm",
    "regime",
    "period",
    "lyapunov",
    "contact_loss",
    "force_max",
    "chaos_probability",
    "chaos_low",
    "chaos_high",
)
"""Of the CSV: load in N·m, force of s1_s2 in N; the last two are the 95 % interval of the probability."""
_RANGE = ("A", "B", "N")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument(
        "--output", type=path_ending_in(".npz", ".csv"), required=True, metavar="F", help="F.npz, or a table F.csv"
    )
    parser.add_argument(
        "--speed-rpm",
        nargs=3,
        type=float,
        metavar=_RANGE,
        help="speeds of s1: N from A to B r/min (default: 80 up to the covered speed)",
    )
    parser.add_argument(
        "--load", nargs=3, type=float, default=(100.0, 700.0, 7.0), metavar=_RANGE, help="loads (default 100 700 7)"
    )
    parser.add_argument(
        "--samples", type=int, default=0, metavar="N", help="machines drawn within tolerances (default 0: nominal)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="of the machines drawn (default 0)")
    parser.add_argument(
        "--threshold", type=float, default=0.5, metavar="P", help="probability of chaos to forbid (default 0.5)"
    )
    parser.add_argument("--transient", type=int, default=400, metavar="N", help="mesh periods run in (default 400)")
    parser.add_argument("--periods", type=int, default=200, metavar="N", help="mesh periods sampled (default 200)")
    parser.add_argument(
        "--plot", type=path_ending_in(*PICTURE_ENDINGS), metavar="F.png", help="draw the map (PNG, SVG or PDF)"
    )
    add_computing_arguments(parser)
    parser.set_defaults(wrong_use=parser.error)


def run(arguments: argparse.Namespace) -> int:
    """Compute, write, draw, and print the forbidden bands; or go on with an interrupted run of the same."""
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.journal import Journal
    from seat_gear_dynamics.motion import load_system

    if not 0 < arguments.threshold <= 1:
        arguments.wrong_use(f"--threshold is {arguments.threshold:g}, expected more than 0 and at most 1")
    if arguments.samples < 0 or arguments.seed < 0:
        arguments.wrong_use("--samples and --seed are whole numbers of at least 0")
    train = load_system(arguments.system).train
    try:
        files = _files(arguments, train)
    except ValueError as error:
        raise CommandError(str(error)) from error
    paths = (files.nodes, files.machines)
    with (
        workers(arguments) as (by, build),
        Journal(arguments.output, paths, _identity(arguments, train, build), restart=arguments.restart) as journal,
    ):
        _compute(arguments, files, by, journal)
        found = files.regime_map(arguments.samples)
        _write(found, arguments.output)
        if arguments.plot:
            _draw(found, arguments.threshold, arguments.plot)
        values = _summary(arguments, found)
        print(json.dumps(values) if arguments.json else "\n".join(_lines(values)))
        journal.finish()
        files.remove()
    return 0


def _files(arguments: argparse.Namespace, train: "GearTrain") -> MapFiles:
    """Return the files of the map that was asked for; raises ValueError for impossible grids and lengths."""
    import numpy as np

    from seat_gear_dynamics.gears.units import RPM
    from seat_gear_dynamics.regimes.map_nodes import MapGrid

    covered = train.model.covered_speed / RPM
    rpm = _grid(arguments, "--speed-rpm", arguments.speed_rpm or (covered / 80, covered, 80.0))
    speeds, loads = [each * RPM for each in rpm], _grid(arguments, "--load", arguments.load)
    grid = MapGrid(np.array(speeds), np.array(loads), arguments.transient, arguments.periods)
    return MapFiles(arguments.output, train, grid)


def _identity(arguments: argparse.Namespace, train: "GearTrain", build: "Build") -> dict[str, dict[str, Any]]:
    """Return what the numbers of the map depend on."""
    from seat_gear_dynamics.regimes.regime_map import fingerprint

    names = ("speed_rpm", "load", "samples", "seed", "transient", "periods")
    asked = {name: getattr(arguments, name) for name in names}
    own = {"fingerprint": fingerprint(train), "covered speed": train.model.covered_speed}
    return {"the map's": asked, "the system's": own, "the program's": dict(build)}


def _compute(arguments: argparse.Namespace, files: MapFiles, by: "Workers", journal: "Journal") -> None:
    """Find what the journal does not hold yet: the nominal machine's nodes, then those of machines drawn."""
    from seat_gear_dynamics.commands.progress import progress

    reached, machines = journal.reached, f"{arguments.samples} machines"
    nodes, weights = int(reached.get("nodes", 0)), int(reached.get("weights", 0))
    with interruptible(lambda: _standing(files, journal)):
        with progress("regime map", quiet=arguments.json, begun=nodes) as tell:
            files.find_nodes(journal, by, tell)
        if arguments.samples:
            with progress(machines, quiet=arguments.json, begun=weights) as tell:
                files.find_machines(journal, by, arguments.samples, arguments.seed, tell)
    journal.flush()


def _standing(files: MapFiles, journal: "Journal") -> str:
    nodes, weights = (journal.reached.get(name, 0) for name in ("nodes", "weights"))
    drawn = f" and machine {weights // files.grid.nodes + 1}" if weights else ""
    return f"node {nodes} of {files.grid.nodes}{drawn}"


def _grid(arguments: argparse.Namespace, option: str, given: tuple[float, float, float]) -> list[float]:
    """Return the values that A B N stand for; one value where N is 1."""
    first, last, count = given
    if not count.is_integer() or count < 1 or (count == 1 and first != last):
        arguments.wrong_use(
            f"{option} asks for {count:g} values from {first:g} to {last:g}; "
            f"expected a whole number of at least 1, and for 1 the same value twice"
        )
    steps = max(int(count) - 1, 1)
    return [first + (last - first) * k / steps for k in range(int(count))]


def _write(found: "RegimeMap", path: Path) -> None:
    if path.suffix.lower() == ".npz":
        with path.open("wb") as file:
            found.save(file)
        return
    with path.open("w", newline="", encoding="utf-8") as table:
        writer = csv.writer(table, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(_rows(found))


def _rows(found: "RegimeMap") -> Iterator[tuple[Any, ...]]:
    from math import isnan

    from seat_gear_dynamics.gears.units import RPM
    from seat_gear_dynamics.regimes.bands import wilson_interval
    from seat_gear_dynamics.regimes.regime_map import NAMES

    rpm = (found.speeds / RPM).tolist()
    for row, load in enumerate(found.loads.tolist()):
        chaos = found.chaos[row]
        bounds = wilson_interval(chaos, found.samples) if found.samples else (chaos, chaos)
        measured = zip(
            *(each[row].tolist() for each in (found.lyapunov, found.contact_loss, found.force_max)), strict=True
        )
        judged = zip(rpm, found.codes[row].tolist(), found.period[row].tolist(), measured, strict=True)
        shares = zip(*(each.tolist() for each in (chaos, *bounds)), strict=True)
        for (speed, code, period, numbers), probability in zip(judged, shares, strict=True):
            known = (None if isnan(each) else each for each in numbers)
            yield load, speed, NAMES[code], period or None, *known, *probability


def _draw(found: "RegimeMap", threshold: float, path: Path) -> None:
    from seat_gear_dynamics.views.figures.regime_map import regime_map_figure
    from seat_gear_dynamics.views.figures.style import save

    save(regime_map_figure(found, threshold=threshold), path)


def _summary(arguments: argparse.Namespace, found: "RegimeMap") -> dict[str, Any]:
    from seat_gear_dynamics.gears.units import RPM
    from seat_gear_dynamics.regimes.regime_map import NAMES

    return {
        "speed_rpm": (found.speeds / RPM).tolist(),
        "load": found.loads.tolist(),
        "regimes": {name: sum(int((row == code).sum()) for row in found.codes) for code, name in enumerate(NAMES)},
        "samples": found.samples,
        "threshold": arguments.threshold,
        "bands": [
            {"load": load, "bands": [_band(band) for band in found.bands(load, arguments.threshold)]}
            for load in found.loads.tolist()
        ],
        "fingerprint": found.fingerprint,
        "output": str(arguments.output),
        "plot": None if arguments.plot is None else str(arguments.plot),
    }


def _band(band: Any) -> dict[str, Any]:
    from seat_gear_dynamics.gears.units import RPM

    names = ("low", "high", "low_error", "high_error")
    speeds = {f"{name}_rpm": getattr(band, name) / RPM for name in names}
    return {**speeds, "open_low": band.open_low, "open_high": band.open_high}


def _lines(values: dict[str, Any]) -> list[str]:
    machines = f"{values['samples']} machines within tolerances" if values["samples"] else "the nominal machine"
    lines = [
        "nodes: " + ", ".join(f"{count} {name}" for name, count in values["regimes"].items() if count),
        f"forbidden bands of s1, r/min: probability of chaos of {machines} at least {values['threshold']:g}",
    ]
    lines += [
        f"  T4 = {at['load']:g} N·m: " + ("; ".join(map(_band_words, at["bands"])) or "none") for at in values["bands"]
    ]
    pictures = [f"picture: {values['plot']}"] if values["plot"] else []
    return [*lines, f"map:     {values['output']}", *pictures]


def _band_words(band: dict[str, Any]) -> str:
    low = f"{'from below ' if band['open_low'] else ''}{band['low_rpm']:.0f} ± {band['low_error_rpm']:.0f}"
    high = f"{'beyond ' if band['open_high'] else ''}{band['high_rpm']:.0f} ± {band['high_error_rpm']:.0f}"
    return f"{low} to {high}"
