"""`seat-gear completion`: what a shell has to run once so that it completes commands, options and file names."""

import argparse
import json

from seat_gear_dynamics.commands.texts import Texts

TEXTS = {"completion": Texts("print what makes a shell complete `seat-gear`", "seat-gear completion bash")}
SHELLS = ("bash", "zsh", "fish")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own argument."""
    parser.add_argument(
        "shell", choices=SHELLS, help='bash or zsh: eval "$(seat-gear completion bash)"; fish: … | source'
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the code."""
    from argcomplete.shell_integration import shellcode

    code = shellcode(["seat-gear"], shell=arguments.shell)
    print(json.dumps({"shell": arguments.shell, "code": code}) if arguments.json else code)
    return 0


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer a shell that asks for completions, and end; only called where one asks."""
    import argcomplete

    argcomplete.autocomplete(parser)
