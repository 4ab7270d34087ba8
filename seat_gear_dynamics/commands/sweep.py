"""`seat-gear sweep`: a bifurcation diagram, written row by row."""

import argparse
import csv
import json
from collections import Counter
from collections.abc import Generator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.output import PICTURE_ENDINGS, path_ending_in
from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from seat_gear_dynamics.motion import System
    from seat_gear_dynamics.regimes.sweep import Row, Sweep

TEXTS = {
    "sweep": Texts(
        "bifurcation diagram over one quantity, as CSV and picture",
        "seat-gear sweep --over load --start 100 --stop 600 --points 6 --frequency 0.5 --output sweep.csv",
    )
}
COLUMNS = (
    "value",
    "regime",
    "period",
    "lyapunov",
    "contact_loss",
    "force_min",
    "force_max",
    "force_mean",
    "force_rms",
    "direction",
)
"""Of the CSV: forces in N, of s1_s2; a field is empty where there is nothing to say."""
POINT_COLUMNS = ("value", "direction", "delta", "rate")
"""Of the CSV of section points: delta in units of b_c, its rate per unit of dimensionless time."""
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
    parser.set_defaults(wrong_use=parser.error)


def run(arguments: argparse.Namespace) -> int:
    """Sweep, write each row as it is found, draw, and sum up."""
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.regimes.sweep import Sweep, row_count, sweep_rows

    fixed = _fixed(arguments)
    try:
        rows = sweep_rows(
            _fixed_system(arguments.system, fixed),
            over=_quantity(arguments),
            start=arguments.start,
            stop=arguments.stop,
            points=arguments.points,
            direction=arguments.direction,
            transient=arguments.transient,
            periods=arguments.periods,
        )
    except ValueError as error:
        raise CommandError(str(error)) from error
    written = _write(arguments, rows, row_count(arguments.points, arguments.direction))
    found = Sweep(_quantity(arguments), tuple(written))
    if arguments.plot:
        _draw(found, arguments.plot)
    values = _summary(arguments, found)
    print(json.dumps(values) if arguments.json else "\n".join(_lines(arguments, found, values)))
    return 0


def points_path(table: Path) -> Path:
    """Return where the section points of the sweep in `table` go."""
    return table.with_name(f"{table.stem}_points.csv")


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


def _write(arguments: argparse.Namespace, rows: "Generator[Row, None, None]", total: int) -> "list[Row]":
    """Write the rows as they come, each flushed, so that an interrupted sweep leaves whole rows; return them."""
    from seat_gear_dynamics.commands.progress import progress

    written: list[Row] = []
    with ExitStack() as open_files:
        table, cloud = (
            open_files.enter_context(path.open("w", newline="", encoding="utf-8"))
            for path in (arguments.output, points_path(arguments.output))
        )
        tell = open_files.enter_context(progress(f"sweep over {arguments.over}", quiet=arguments.json))
        open_files.enter_context(closing(rows))
        row_writer, point_writer = (csv.writer(file, lineterminator="\n") for file in (table, cloud))
        row_writer.writerow(COLUMNS)
        point_writer.writerow(POINT_COLUMNS)
        for row in rows:
            # The points go first, so that every row of the table has its points.
            point_writer.writerows((row.value, row.direction, *point) for point in row.section.tolist())
            cloud.flush()
            values = row.as_dict()
            row_writer.writerow(values[name] for name in COLUMNS)  # None is written as an empty field
            table.flush()
            written.append(row)
            tell(len(written), total)
    return written


def _draw(found: "Sweep", path: Path) -> None:
    from seat_gear_dynamics.views.figures.bifurcation import bifurcation_figure
    from seat_gear_dynamics.views.figures.style import save

    save(bifurcation_figure(found), path)


def _summary(arguments: argparse.Namespace, found: "Sweep") -> dict[str, Any]:
    from seat_gear_dynamics.regimes.sweep import UNITS, intervals

    return {
        "over": arguments.over,
        "unit": UNITS[found.over],
        "direction": arguments.direction,
        "rows": [row.as_dict() for row in found.rows],
        "regimes": dict(Counter(row.regime.name for row in found.rows)),
        "chaotic": intervals(found, "chaotic"),
        "coexisting": found.coexisting(),
        "diverged": [row.value for row in found.rows if row.force is None],
        "output": str(arguments.output),
        "section_points": str(points_path(arguments.output)),
        "plot": None if arguments.plot is None else str(arguments.plot),
    }


def _lines(arguments: argparse.Namespace, found: "Sweep", values: dict[str, Any]) -> list[str]:
    unit = "" if values["unit"] == "1" else f" {values['unit']}"
    ranges = ", ".join(f"{low:.6g} to {high:.6g}{unit}" for low, high in values["chaotic"])
    lines = [
        f"{len(found.rows)} rows over {arguments.over}, {arguments.start:g} to {arguments.stop:g}{unit}: "
        + ", ".join(f"{count} {name}" for name, count in values["regimes"].items()),
        f"chaotic: {ranges or 'nowhere'} (ends uncertain by one step)",
    ]
    if arguments.direction == "both":
        apart = ", ".join(f"{value:.6g}" for value in values["coexisting"])
        lines.append(f"up and down on different motions at: {apart or 'no value'}")
    if values["diverged"]:
        lines.append("diverged at: " + ", ".join(f"{value:.6g}" for value in values["diverged"]))
    pictures = [f"picture: {arguments.plot}"] if arguments.plot else []
    return [*lines, f"table:   {values['output']}", f"points:  {values['section_points']}", *pictures]
