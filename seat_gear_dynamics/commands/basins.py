"""`seat-gear basins`: the motions that coexist at one operating point, and which start leads to which."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.operating_point import add_mesh_arguments, system_at
from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from seat_gear_dynamics.regimes.basins import Basins

TEXTS = {
    "basins": Texts(
        "motions that coexist at one operating point, and the starts that lead to each",
        "seat-gear basins --frequency 0.5 --load 600 --output basins",
    )
}
_RANGE = ("A", "B", "N")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    drive = parser.add_mutually_exclusive_group(required=True)
    drive.add_argument("--speed-rpm", type=float, metavar="N", help="speed of s1, r/min")
    drive.add_argument("--frequency", type=float, metavar="Ω", help="dimensionless mesh frequency of s1_s2")
    parser.add_argument("--load", type=float, required=True, metavar="T4", help="load torque on s4, N·m")
    add_mesh_arguments(parser)
    for option, what, default in (
        ("--deflection", "initial δ of s1_s2, in b_c", (-4.0, 6.0, 61.0)),
        ("--rate", "its initial rate, b_c per τ", (-3.0, 3.0, 49.0)),
    ):
        shown = " ".join(f"{each:g}" for each in default)
        text = f"{what}: N values from A to B (default {shown})"
        parser.add_argument(option, nargs=3, type=float, default=default, metavar=_RANGE, help=text)
    parser.add_argument("--transient", type=int, default=600, metavar="N", help="mesh periods run in (default 600)")
    parser.add_argument("--periods", type=int, default=200, metavar="N", help="mesh periods sampled (default 200)")
    parser.add_argument("--output", type=Path, metavar="DIR", help="folder for basins.csv and basins.png")
    parser.set_defaults(wrong_use=parser.error)


def run(arguments: argparse.Namespace) -> int:
    """Find the motions, write what was asked for, and print."""
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.progress import progress
    from seat_gear_dynamics.regimes.basins import basins

    deflections, rates = (_values(arguments, option) for option in ("deflection", "rate"))
    try:
        with progress("starts", quiet=arguments.json) as tell:
            found = basins(
                system_at(arguments),
                deflections,
                rates,
                transient=arguments.transient,
                periods=arguments.periods,
                progress=tell,
            )
    except ValueError as error:
        raise CommandError(str(error)) from error
    files = [] if arguments.output is None else _write(found, arguments.output)
    values = _summary(found) | {"files": files}
    print(json.dumps(values) if arguments.json else "\n".join(_lines(values)))
    return 0


def _values(arguments: argparse.Namespace, option: str) -> list[float]:
    """Return the values that A B N stand for."""
    first, last, count = getattr(arguments, option)
    if not (float(count).is_integer() and count >= 2 and first < last):
        arguments.wrong_use(
            f"--{option} asks for {count:g} values from {first:g} to {last:g}; "
            f"expected a whole number of at least 2, and A below B"
        )
    return [first + (last - first) * k / (count - 1) for k in range(int(count))]


def _write(found: "Basins", folder: Path) -> list[str]:
    """Write table and picture into `folder` and return their paths; raises OSError where that cannot be."""
    from seat_gear_dynamics.views.figures.basins import basins_figure
    from seat_gear_dynamics.views.figures.style import save

    folder.mkdir(parents=True, exist_ok=True)
    table, picture = folder / "basins.csv", folder / "basins.png"
    found.to_csv(table)
    save(basins_figure(found), picture)
    return [str(table), str(picture)]


def _summary(found: "Basins") -> dict[str, Any]:
    """Return what was found as plain values."""
    from seat_gear_dynamics.regimes.attractors import LOST

    motions = []
    for index, each in enumerate(found.attractors):
        share, regime = found.share(index), each.regime
        motions.append(
            {
                "regime": regime.name,
                "period": regime.period,
                "label": regime.label,
                "lyapunov": regime.lyapunov,
                "reason": regime.reason,
                "contact_loss": each.force.contact_loss,
                "share": share.value,
                "share_error": share.error,
            }
        )
    return {"starts": found.labels.size, "motions": motions, "diverged": found.share(LOST).value}


def _lines(values: dict[str, Any]) -> list[str]:
    """Return the summary in words."""
    count = len(values["motions"])
    lines = [f"{values['starts']} starts settle on {count} motion{'s' if count != 1 else ''} of s1_s2"]
    for each in values["motions"]:
        share = f"{each['share']:.1%} ± {each['share_error']:.1%}"
        lines.append(f"{share} of the starts: {each['label']}, contact lost {each['contact_loss']:.1%} of the time")
        lines.append(f"    {each['reason']}")
    if values["diverged"]:
        lines.append(f"{values['diverged']:.1%} of the starts diverged")
    return [*lines, *(f"wrote {file}" for file in values["files"])]
