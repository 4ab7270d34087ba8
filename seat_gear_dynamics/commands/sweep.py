"""`seat-gear sweep`: a bifurcation diagram, written row by row."""

import argparse
import json
from collections import Counter
from collections.abc import Generator
from contextlib import closing
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.computing import add_computing_arguments, interruptible, workers
from seat_gear_dynamics.commands.output import PICTURE_ENDINGS, path_ending_in
from seat_gear_dynamics.commands.sweep_files import coexisting, drawn_rows, points_path, read_rows, thinning
from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from seat_gear_dynamics.cluster.build import Build
    from seat_gear_dynamics.commands.journal import Journal
    from seat_gear_dynamics.motion import System
    from seat_gear_dynamics.regimes.sweep_plan import Plan
    from seat_gear_dynamics.regimes.sweep_table import Lines
    from seat_gear_dynamics.regimes.workers import Workers

TEXTS = {
    "sweep": Texts(
        "bifurcation diagram over one quantity, as CSV and picture",
        "seat-gear sweep --over load --start 100 --stop 600 --points 6 --frequency 0.5 --output sweep.csv",
    )
}
_DRIVES = {"frequency", "speed_rpm"}
_OVER = ("frequency", "speed-rpm", "damping", "backlash-um", "load")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("--over", choices=_OVER, required=True, help="the quantity to vary")
    parser.add_argument("--start", type=float, required=True, metavar="A", help="lowest value")
    parser.add_argument("--stop", type=float, required=True, metavar="B", help="highest value")
    parser.add_argument("--points", type=int, required=True, metavar="N", help="number of values, ends included")
    parser.add_argument(
        "--direction",
        choices=("up", "down", "both", "cold"),
        default="cold",
        help="up, down: each value starts where the last ended; cold: each from rest, as simulate does (default)",
    )
    drive = parser.add_mutually_exclusive_group()
    drive.add_argument("--frequency", type=float, metavar="Ω", help="fixed mesh frequency (default 0.5)")
    drive.add_argument("--speed-rpm", type=float, metavar="N", help="fixed speed of s1, r/min")
    parser.add_argument("--load", type=float, metavar="T4", help="fixed load torque on s4, N·m (default 600)")
    parser.add_argument("--damping", type=float, metavar="ξ", help="fixed mesh damping ratio (default: the system's)")
    parser.add_argument("--backlash-um", type=float, metavar="B", help="fixed backlash, µm (default: the system's)")
    parser.add_argument("--transient", type=int, default=600, metavar="N", help="mesh periods run in (default 600)")
    parser.add_argument("--periods", type=int, default=400, metavar="N", help="mesh periods sampled (default 400)")
    parser.add_argument(
        "--output",
        type=path_ending_in(),
        required=True,
        metavar="F.csv",
        help="the table; section points go to F_points.csv",
    )
    parser.add_argument(
        "--plot", type=path_ending_in(*PICTURE_ENDINGS), metavar="F.png", help="draw the diagram (PNG, SVG or PDF)"
    )
    add_computing_arguments(parser)
    parser.set_defaults(wrong_use=parser.error)


def run(arguments: argparse.Namespace) -> int:
    """Sweep, write each row as it is found, draw, and sum up; or go on with an interrupted run of the same."""
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.journal import Journal

    fixed = _fixed(arguments)
    try:
        plan, system = _plan(arguments), _fixed_system(arguments.system, fixed)
        plan.check(system)
    except ValueError as error:
        raise CommandError(str(error)) from error
    files = (arguments.output, points_path(arguments.output))
    with (
        workers(arguments) as (by, build),
        Journal(arguments.output, files, _identity(plan, system, build), restart=arguments.restart) as journal,
    ):
        _compute(arguments, system, plan, by, journal)
        if arguments.plot:
            _draw(arguments, plan)
        _say(arguments, plan)
        journal.finish()
    return 0


def _plan(arguments: argparse.Namespace) -> "Plan":
    from seat_gear_dynamics.regimes.sweep_plan import Plan

    names = ("start", "stop", "points", "direction", "transient", "periods")
    return Plan(_quantity(arguments), **{name: getattr(arguments, name) for name in names})


def _identity(plan: "Plan", system: "System", build: "Build") -> dict[str, dict[str, Any]]:
    """Return what the numbers of the sweep depend on."""
    from dataclasses import asdict

    from seat_gear_dynamics.regimes.regime_map import fingerprint

    at = system.operating_point
    own = {"fingerprint": fingerprint(system.train), "frequency": at.frequency, "load": at.load}
    return {"the sweep's": asdict(plan), "the system's": own, "the program's": dict(build)}


def _quantity(arguments: argparse.Namespace) -> Any:
    return arguments.over.replace("-", "_")


def _fixed(arguments: argparse.Namespace) -> dict[str, float]:
    """Return the values that stay fixed; ends the program as wrong use where one is also swept."""
    over = _quantity(arguments)
    swept = _DRIVES if over in _DRIVES else {over}
    names = ("frequency", "speed_rpm", "load", "damping", "backlash_um")
    fixed = {name: value for name in names if (value := getattr(arguments, name)) is not None}
    for name in sorted(swept & set(fixed)):
        option = "--" + name.replace("_", "-")
        arguments.wrong_use(f"{option} fixes what the sweep over {arguments.over} varies; leave it out")
    return fixed


def _fixed_system(description: str | None, fixed: dict[str, float]) -> "System":
    """Return the described system with the fixed values; raises ValueError for impossible ones."""
    from dataclasses import replace

    from seat_gear_dynamics.gears.units import RPM
    from seat_gear_dynamics.motion import load_system
    from seat_gear_dynamics.regimes.points import Point

    system = load_system(description)
    rpm, backlash = fixed.get("speed_rpm"), fixed.get("backlash_um")
    system = system.at(
        frequency=fixed.get("frequency"), speed=None if rpm is None else rpm * RPM, load=fixed.get("load")
    )
    at = system.operating_point
    point = Point(
        at.frequency,
        at.load,
        damping_ratio=fixed.get("damping"),
        backlash=None if backlash is None else backlash * 1e-6,
    )
    return replace(system, train=point.applied_to(system.train))


def _compute(arguments: argparse.Namespace, system: "System", plan: "Plan", by: "Workers", journal: "Journal") -> None:
    """Write the rows that the journal does not hold yet, each as it is found."""
    from seat_gear_dynamics.commands.progress import progress
    from seat_gear_dynamics.regimes.sweep_table import heads

    def standing() -> str:
        return f"row {journal.reached.get('rows', 0)} of {plan.rows}"

    with interruptible(standing):
        if not journal.reached:
            journal.add(heads(), {"rows": 0, "states": {}})
        begun = int(journal.reached["rows"])
        with (
            closing(_rows(system, plan, by, journal)) as rows,
            progress(f"sweep over {arguments.over}", quiet=arguments.json, begun=begun) as tell,
        ):
            tell(begun, plan.rows)
            for done, found in enumerate(rows, begun + 1):
                states = {} if plan.direction == "cold" else {**journal.reached["states"], found.direction: found.state}
                journal.add((found.table, found.points), {"rows": done, "states": states})
                journal.flush()
                tell(done, plan.rows)


def _rows(system: "System", plan: "Plan", by: "Workers", journal: "Journal") -> "Generator[Lines, None, None]":
    from seat_gear_dynamics.regimes.sweep import sweep_each
    from seat_gear_dynamics.regimes.sweep_plan import Begun
    from seat_gear_dynamics.regimes.sweep_table import lines

    begun = Begun(journal.reached["rows"], journal.reached["states"])
    return sweep_each(system, plan, lines, workers=by, begun=begun)


def _draw(arguments: argparse.Namespace, plan: "Plan") -> None:
    from seat_gear_dynamics.regimes.sweep import Sweep
    from seat_gear_dynamics.views.figures.bifurcation import bifurcation_figure
    from seat_gear_dynamics.views.figures.style import save

    found = Sweep(plan.over, tuple(drawn_rows(arguments.output, plan)))
    save(bifurcation_figure(found), arguments.plot)


def _say(arguments: argparse.Namespace, plan: "Plan") -> None:
    """Print what was found: as JSON row by row, for there may be more rows than memory."""
    values = _summary(arguments, plan)
    if not arguments.json:
        print("\n".join(_lines(arguments, plan, values)))
        return
    print(json.dumps(values)[:-1], end=', "rows": [')
    for number, row in enumerate(read_rows(arguments.output)):
        print(", " * bool(number) + json.dumps(row.as_dict()), end="")
    print("]}")


def _summary(arguments: argparse.Namespace, plan: "Plan") -> dict[str, Any]:
    from seat_gear_dynamics.regimes.sweep import UNITS

    regimes = Counter(row.regime.name for row in read_rows(arguments.output))
    return {
        "over": arguments.over,
        "unit": UNITS[plan.over],
        "direction": arguments.direction,
        "regimes": dict(regimes),
        "chaotic": _chaotic(arguments, plan),
        "coexisting": list(coexisting(arguments.output, plan)),
        "diverged": [row.value for row in read_rows(arguments.output) if row.force is None],
        "output": str(arguments.output),
        "section_points": str(points_path(arguments.output)),
        "plot": None if arguments.plot is None else str(arguments.plot),
    }


def _chaotic(arguments: argparse.Namespace, plan: "Plan") -> list[tuple[float, float]]:
    """Return the ranges of values over which the motion is chaotic, in one direction or the other."""
    from seat_gear_dynamics.regimes.sweep import Sweep, intervals, stretches

    rows = read_rows(arguments.output)
    if plan.direction == "both":
        return list(intervals(Sweep(plan.over, tuple(rows)), "chaotic"))
    return sorted(stretches((row.value, row.regime.name == "chaotic") for row in rows))


def _lines(arguments: argparse.Namespace, plan: "Plan", values: dict[str, Any]) -> list[str]:
    unit = "" if values["unit"] == "1" else f" {values['unit']}"
    ranges = ", ".join(f"{low:.6g} to {high:.6g}{unit}" for low, high in values["chaotic"])
    lines = [
        f"{plan.rows} rows over {arguments.over}, {arguments.start:g} to {arguments.stop:g}{unit}: "
        + ", ".join(f"{count} {name}" for name, count in values["regimes"].items()),
        f"chaotic: {ranges or 'nowhere'} (ends uncertain by one step)",
    ]
    if arguments.direction == "both":
        apart = ", ".join(f"{value:.6g}" for value in values["coexisting"])
        lines.append(f"up and down on different motions at: {apart or 'no value'}")
    if values["diverged"]:
        lines.append("diverged at: " + ", ".join(f"{value:.6g}" for value in values["diverged"]))
    some = "" if thinning(plan) == 1 else f" (one of {thinning(plan)} values)"
    pictures = [f"picture: {arguments.plot}{some}"] if arguments.plot else []
    return [*lines, f"table:   {values['output']}", f"points:  {values['section_points']}", *pictures]
