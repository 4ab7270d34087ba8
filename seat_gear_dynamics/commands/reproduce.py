"""`seat-gear reproduce`: the paper's claims C1-C15 and figures, as this model gives them."""

import argparse
import json
from typing import TYPE_CHECKING

from seat_gear_dynamics.commands.output import path_ending_in
from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from pathlib import Path

    from seat_gear_dynamics.studies.reproduction.run import Reproduction

TEXTS = {
    "reproduce": Texts(
        "the paper's claims C1-C15: expected, found, verdict and why (minutes)",
        "seat-gear reproduce --output reproduction.md",
    )
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument(
        "--output",
        type=path_ending_in(".md"),
        metavar="F.md",
        help="write the page to F.md, its figures to the folder F beside it, and all numbers to F.json",
    )


def run(arguments: argparse.Namespace) -> int:
    """Compute, print, and write the page."""
    from time import perf_counter

    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.progress import stages
    from seat_gear_dynamics.motion import load_system
    from seat_gear_dynamics.motion.march import DivergedError
    from seat_gear_dynamics.studies.reproduction.run import reproduce

    system = load_system(arguments.system)
    begin = perf_counter()
    try:
        with stages(quiet=arguments.json) as progress:
            found = reproduce(system, progress)
    except DivergedError as error:
        raise CommandError(str(error)) from error
    if arguments.output is not None:
        write(found, arguments.output)
    if arguments.json:
        print(json.dumps(as_dict(found)))
        return 0
    from rich.console import Console

    from seat_gear_dynamics.views.reproduction import table

    Console().print(table(found.claims))
    print(f"{perf_counter() - begin:.0f} s" + (f"; written to {arguments.output}" if arguments.output else ""))
    return 0


def as_dict(found: "Reproduction") -> dict[str, object]:
    """Return claims and errata as plain values for JSON."""
    from dataclasses import asdict

    from seat_gear_dynamics import __version__
    from seat_gear_dynamics.regimes.regime_map import fingerprint

    return {
        "system": found.system.train.name,
        "fingerprint": fingerprint(found.system.train),
        "version": __version__,
        "load_scale": found.system.train.model.load_scale,
        "claims": [claim.as_dict() for claim in found.claims],
        "errata": [asdict(erratum) for erratum in found.errata],
    }


def write(found: "Reproduction", page: "Path") -> None:
    """Write the page, its figures and its numbers; raises OSError where they cannot be written."""
    from seat_gear_dynamics.studies.reproduction.survey import PERIODS, TRANSIENT
    from seat_gear_dynamics.views.figures.paper import paper_figures
    from seat_gear_dynamics.views.figures.style import save
    from seat_gear_dynamics.views.reproduction import markdown

    folder = page.with_suffix("")
    folder.mkdir(exist_ok=True)
    pictures = {}
    for name, (caption, figure) in paper_figures(found).items():
        save(figure, folder / f"{name}.png")
        pictures[caption] = f"{folder.name}/{name}.png"
    train = found.system.train
    setting = (
        f"Model: {train.name}, load scale {train.model.load_scale:.4g} (mesh force over the static force of the stated "
        f"torque), b_c {train.model.displacement_scale * 1e6:.3g} µm; every motion from rest at static deflection, "
        f"{TRANSIENT} mesh periods run in, {PERIODS} judged."
    )
    text = markdown(
        found.claims,
        found.errata,
        setting=setting,
        pictures=pictures,
        command=f"seat-gear reproduce --output {page.name}",
    )
    page.write_text(text, encoding="utf-8")
    page.with_suffix(".json").write_text(json.dumps(as_dict(found), indent=1) + "\n", encoding="utf-8")
