"""`seat-gear harmonic`: response curves of s1_s2 by harmonic balance, and their agreement with integration."""

import argparse
import json
from itertools import count as counter
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.operating_point import add_mesh_arguments, system_at
from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from seat_gear_dynamics.commands.progress import TellStage
    from seat_gear_dynamics.motion import System
    from seat_gear_dynamics.studies.harmonic_balance import Agreement, ResponseCurve

TEXTS = {
    "harmonic": Texts(
        "response curve of s1_s2 by harmonic balance: branches through folds, stability, jumps",
        "seat-gear harmonic --load 600 --output curve --compare 20",
    )
}

# name of --over -> (parameter of the study, factor to SI, default range)
PARAMETERS: dict[str, tuple[str, float, tuple[float, float] | None]] = {
    "frequency": ("frequency", 1.0, (0.1, 2.01)),
    "load": ("load", 1.0, None),
    "damping": ("damping_ratio", 1.0, None),
    "backlash-um": ("backlash", 1e-6, None),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("--over", choices=tuple(PARAMETERS), default="frequency", help="parameter (default frequency)")
    parser.add_argument("--start", type=float, metavar="A", help="where the parameter begins (frequency: default 0.1)")
    parser.add_argument("--stop", type=float, metavar="B", help="where it ends (frequency: default 2.01)")
    parser.add_argument("--frequency", type=float, default=0.5, metavar="Ω", help="frequency elsewhere (default 0.5)")
    parser.add_argument("--load", type=float, default=600.0, metavar="T4", help="load torque, N·m (default 600)")
    add_mesh_arguments(parser)
    parser.add_argument(
        "--harmonics", type=int, default=32, metavar="H", help="harmonics of the mesh frequency kept (default 32)"
    )
    parser.add_argument(
        "--subharmonics",
        type=int,
        default=1,
        metavar="n",
        help="also motions whose period divides n mesh periods (default 1)",
    )
    parser.add_argument(
        "--compare", type=int, metavar="N", help="integrate at N values, up and down, and report the difference"
    )
    parser.add_argument("--output", metavar="DIR", help="folder for response_curve.csv and response_curve.png")


def run(arguments: argparse.Namespace) -> int:
    """Follow the motions, write what was asked for, and print."""
    from pathlib import Path

    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.progress import stages
    from seat_gear_dynamics.motion.march import DivergedError
    from seat_gear_dynamics.studies.harmonic_balance import NoSolutionError

    try:
        system = system_at(arguments)
        with stages(quiet=arguments.json) as tell:
            curve = _curve(system, arguments, tell)
            agreements = _agreements(curve, arguments.compare, tell)
    except (ValueError, NoSolutionError, DivergedError) as error:
        raise CommandError(str(error)) from error
    files = [] if arguments.output is None else _write(curve, agreements, Path(arguments.output))
    scale = PARAMETERS[arguments.over][1]
    summary = _summary(curve, agreements, arguments.over, scale) | {"files": files}
    if arguments.json:
        print(json.dumps(summary))
    else:
        _print(summary)
    return 0


def _curve(system: "System", arguments: argparse.Namespace, tell: "TellStage") -> "ResponseCurve":
    from seat_gear_dynamics.studies.harmonic_balance import response_curve

    parameter, scale, usual = PARAMETERS[arguments.over]
    low = arguments.start if arguments.start is not None or usual is None else usual[0]
    high = arguments.stop if arguments.stop is not None or usual is None else usual[1]
    if low is None or high is None:
        raise ValueError(f"Following {arguments.over} needs a range; give both --start and --stop.")

    farthest = 0

    def follow(value: float) -> None:
        nonlocal farthest  # a branch turns back at folds: progress is the farthest it came
        farthest = max(farthest, min(100, round(100 * (value - low * scale) / ((high - low) * scale))))
        tell(f"following {arguments.over}, %", farthest, 100)

    return response_curve(
        system,
        low * scale,
        high * scale,
        parameter=parameter,
        harmonics=arguments.harmonics,
        subharmonics=arguments.subharmonics,
        progress=follow,
    )


def _agreements(curve: "ResponseCurve", count: int | None, tell: "TellStage") -> "list[Agreement]":
    """Return the comparison at `count` values evenly across the range, its ends left out."""
    if count is None:
        return []
    if count < 1:
        raise ValueError(f"--compare is {count}, expected 1 or more values.")
    import numpy as np

    from seat_gear_dynamics.studies.harmonic_balance import compare

    integrated = counter(1)
    values = [float(v) for v in np.linspace(curve.low, curve.high, count + 2)[1:-1]]
    tell("integrating", 0, 2 * count)  # up and down
    return compare(curve, values, progress=lambda value: tell("integrating", next(integrated), 2 * count))


def _write(curve: "ResponseCurve", agreements: "Sequence[Agreement]", folder: "Path") -> list[str]:
    """Write CSV and picture into `folder` and return their paths; raises OSError where that cannot be."""
    import csv

    from seat_gear_dynamics.studies.harmonic_balance import COLUMNS, rows
    from seat_gear_dynamics.views.figures.response_curve import response_curve_figure
    from seat_gear_dynamics.views.figures.style import save

    folder.mkdir(parents=True, exist_ok=True)
    table, picture = folder / "response_curve.csv", folder / "response_curve.png"
    with table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows(curve))
    save(response_curve_figure(curve, agreements)[0], picture)
    return [str(table), str(picture)]


def _summary(curve: "ResponseCurve", agreements: "Sequence[Agreement]", over: str, scale: float) -> dict[str, Any]:
    """Return what was found as plain values; those of the parameter in the unit of --over."""
    return {
        "over": over,
        "start": curve.low / scale,
        "stop": curve.high / scale,
        "branches": [
            {
                "period": b.subharmonics,
                "motions": len(b.motions),
                "stable_share": float(b.stable.mean()),
                "from": b.motions[0].parameter / scale,
                "to": b.motions[-1].parameter / scale,
                "ended": b.ended,
            }
            for b in curve.branches
        ],
        "bifurcations": [
            {
                "kind": e.kind,
                "value": e.parameter / scale,
                "period": e.motion.orbit.balance.subharmonics,
                "delta_rms": e.motion.rms * e.motion.orbit.balance.pair.length_unit,
                "contact": e.motion.contact_state,
            }
            for e in curve.bifurcations
        ],
        "coexistence": [[low / scale, high / scale] for low, high in curve.coexistence()],
        "comparison": [
            {
                "value": a.value / scale,
                "direction": a.direction,
                "integrated_period": a.period,
                "period": None if a.motion is None else a.motion.orbit.balance.subharmonics,
                "difference": a.difference,
                "comparable": a.comparable,
            }
            for a in agreements
        ],
    }


def _print(summary: dict[str, Any]) -> None:
    print(f"s1_s2 over {summary['over']} from {summary['start']:g} to {summary['stop']:g}")
    for b in summary["branches"]:
        print(
            f"branch of period {b['period']}: {b['motions']} motions from {b['from']:.5g} to {b['to']:.5g}, "
            f"{b['stable_share']:.0%} of them stable; ended: {b['ended']}"
        )
    for e in summary["bifurcations"]:
        print(f"{e['kind']:16s} at {e['value']:.5f}, period {e['period']}, {e['contact']}")
    for low, high in summary["coexistence"]:
        print(f"two or more stable motions from {low:.5f} to {high:.5f}")
    _print_comparison(summary["comparison"])
    for file in summary["files"]:
        print(f"wrote {file}")


def _print_comparison(items: list[dict[str, Any]]) -> None:
    """Print how many integrated motions were held against the curve, and the worst; then those that could not be."""
    if not items:
        return
    held = [a for a in items if a["comparable"]]
    print(f"integrated {len(items)} motions; {len(held)} are of the period of a stable motion of the curve")
    if held:
        worst = max(held, key=lambda a: a["difference"])
        print(
            f"δ of these differs by at most {worst['difference']:.1e} of its range, at {worst['value']:.5g} "
            f"going {worst['direction']}"
        )
    for a in items:
        if not a["comparable"]:
            motion = "no period looked for" if a["integrated_period"] is None else f"period {a['integrated_period']}"
            known = "none stable" if a["period"] is None else f"period {a['period']}"
            print(f"  at {a['value']:.5g} going {a['direction']}: integrated {motion}, curve {known}")
