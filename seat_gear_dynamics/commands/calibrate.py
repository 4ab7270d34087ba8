"""`seat-gear calibrate`: identify parameters from a measured bench, or from the paper's claims what it leaves open."""

import argparse
import json
import sys

from seat_gear_dynamics.commands import calibrate_log
from seat_gear_dynamics.commands.texts import Texts

TEXTS = {
    "calibrate": Texts(
        "fit the model to a recorded bench, or without a LOG to the paper's claims C1-C5 and C7-C10",
        "seat-gear calibrate --evaluations 160 --seed 1",
    )
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    calibrate_log.add_arguments(parser)
    parser.add_argument("--evaluations", type=int, default=3200, metavar="N", help="sets tried (default 3200)")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of the search (default 1)")
    parser.add_argument(
        "--step", type=float, default=0.5, metavar="X", help="scale of the first steps (default 0.5; 0.1 refines)"
    )
    parser.add_argument(
        "--harmonics", type=int, metavar="H", help="Fourier harmonics of the mesh stiffness (default: the system's)"
    )
    parser.add_argument("--output", metavar="PATH", help="F.yaml for the set that was found; with a LOG a folder")
    parser.add_argument(
        "--sensitivity", action="store_true", help="do not search: how far may each parameter drift on its own"
    )


def run(arguments: argparse.Namespace) -> int:
    """Search, or measure the sensitivity, and print."""
    from seat_gear_dynamics.gears import load_train

    if arguments.log is not None:
        return calibrate_log.run(arguments)
    train = load_train(arguments.system)
    return _sensitivity(train, arguments) if arguments.sensitivity else _search(train, arguments)


def _search(train: object, arguments: argparse.Namespace) -> int:
    from pathlib import Path

    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.progress import progress
    from seat_gear_dynamics.gears import GearTrain
    from seat_gear_dynamics.studies.calibration.describe import described
    from seat_gear_dynamics.studies.calibration.freedom import FREEDOMS
    from seat_gear_dynamics.studies.calibration.search import Candidate, search

    assert isinstance(train, GearTrain)

    try:
        with progress("sets tried", quiet=arguments.json) as tell:

            def report(done: int, best: Candidate) -> None:
                if not arguments.json:
                    scores = "  ".join(f"{claim} {score:.2f}" for claim, score in best.scores.items())
                    print(f"{done:6d}  cost {best.cost:.3f}  {scores}", file=sys.stderr, flush=True)
                tell(done, arguments.evaluations)

            best = search(
                train,
                harmonics=arguments.harmonics or train.meshes[0].stiffness_harmonics,
                evaluations=arguments.evaluations,
                seed=arguments.seed,
                step=arguments.step,
                report=report,
            )
    except ModuleNotFoundError as error:
        raise CommandError(
            "The search needs the package cma, which is not installed: pip install seat_gear_dynamics[calibration]."
        ) from error
    except ValueError as error:
        raise CommandError(str(error)) from error
    if arguments.output is not None:
        Path(arguments.output).write_text(described(train.text, best.train(train)), encoding="utf-8")
    values = {f.name: v for f, v in zip(FREEDOMS, best.values, strict=True)}
    if arguments.json:
        print(json.dumps({"cost": best.cost, "harmonics": best.harmonics, "values": values, "scores": best.scores}))
        return 0
    print(f"cost {best.cost:.4f} with {best.harmonics} harmonics of the mesh stiffness")
    for name, value in values.items():
        print(f"{name:>11s}  {value:.6g}")
    print("scores, 1 is met: " + ", ".join(f"{claim} {score:.2f}" for claim, score in best.scores.items()))
    return 0


def _sensitivity(train: object, arguments: argparse.Namespace) -> int:
    from dataclasses import asdict

    from seat_gear_dynamics.commands.progress import progress
    from seat_gear_dynamics.gears import GearTrain
    from seat_gear_dynamics.studies.calibration.sensitivity import sensitivity

    assert isinstance(train, GearTrain)
    with progress("parameters", quiet=arguments.json) as tell:
        drifts = sensitivity(train, progress=tell)
    if arguments.json:
        print(json.dumps({"drifts": [asdict(d) for d in drifts]}))
        return 0
    print(f"{'parameter':>11s}{'value':>12s}{'may fall by':>13s}  {'then lost':18s}{'may rise by':>12s}  then lost")
    for d in drifts:
        print(
            f"{d.name:>11s}{d.value:12.4g}{d.down:13.1%}  {', '.join(d.lost_down) or '-':18s}{d.up:12.1%}  "
            f"{', '.join(d.lost_up) or '-'}"
        )
    print("Each on its own; a phase drifts by as many radians.")
    return 0
