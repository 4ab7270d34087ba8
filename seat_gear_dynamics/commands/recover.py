"""`seat-gear recover`: a readable log out of a damaged one."""

import argparse
import json
from pathlib import Path

from seat_gear_dynamics.commands.texts import Texts

TEXTS = {"recover": Texts("a readable log out of a damaged one", "seat-gear recover my_run --output my_run_sound")}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("log", metavar="LOG", type=Path, help="bag directory or .mcap file; it is only read")
    parser.add_argument(
        "--output",
        metavar="DIR",
        type=Path,
        help="the new bag's directory, which must not exist (default: NAME_recovered beside the log)",
    )
    checks = parser.add_mutually_exclusive_group()
    checks.add_argument(
        "--strict",
        dest="unchecked",
        action="store_false",
        help="keep only what a checksum vouches for (the default)",
    )
    checks.add_argument(
        "--unchecked",
        action="store_true",
        help="keep well-formed messages without a checksum too; a wrong byte in them is not noticed",
    )
    parser.set_defaults(unchecked=False)


def run(arguments: argparse.Namespace) -> int:
    """Recover and print what was kept and lost; raises LogError, hence exit code 1, where nothing was."""
    from seat_gear_dynamics import __version__
    from seat_gear_dynamics.commands.progress import stages
    from seat_gear_dynamics.logs.recovery import recover

    with stages(quiet=arguments.json) as tell:
        result = recover(arguments.log, arguments.output, unchecked=arguments.unchecked, version=__version__, tell=tell)
    print(json.dumps(result.as_dict()) if arguments.json else "\n".join(result.lines()))
    return 0
