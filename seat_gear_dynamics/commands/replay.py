"""`seat-gear replay`: the monitor's outputs again from the log's inputs."""

import argparse
import json
from pathlib import Path

from seat_gear_dynamics.commands.texts import Texts

TEXTS = {
    "replay": Texts("the monitor's forces again from a log's inputs, compared bit for bit", "seat-gear replay my_run")
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("log", metavar="LOG", type=Path, help="bag directory or .mcap file")


def run(arguments: argparse.Namespace) -> int:
    """Replay and compare; exit code 1 where anything differs."""
    from dataclasses import asdict

    from seat_gear_dynamics.gears import load_train
    from seat_gear_dynamics.gears.description import parse_train
    from seat_gear_dynamics.logs.reader import Bag
    from seat_gear_dynamics.logs.replay import replay

    text = (Bag(arguments.log).metadata or {}).get("system")
    train = load_train(arguments.system) if arguments.system or not text else parse_train(text)
    result = replay(arguments.log, train)
    if arguments.json:
        print(json.dumps(asdict(result)))
    else:
        print(
            f"{result.samples} samples replayed, {result.equal} of {result.messages} force messages equal bit for bit"
        )
        if result.first_difference:
            print(f"first difference: {result.first_difference}")
    return 0 if result.equal == result.messages else 1
