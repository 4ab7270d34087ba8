"""The `seat-gear` command line: one short module per command, loaded when it runs."""

import argparse
import os
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from importlib import import_module
from textwrap import fill
from typing import NoReturn

from seat_gear_dynamics import __version__

# command -> module; every module has HELP, EXAMPLE, add_arguments(parser) and run(arguments) -> exit code, and imports
# at its top nothing heavier than argparse, so that --help is quick.
COMMANDS = {
    "bench": "bench",
    "dashboard": "dashboard",
    "monitor": "node",
    "record": "node",
    "simulator": "node",
    "simulate": "simulate",
    "stiffness": "stiffness",
    "sweep": "sweep",
    "map": "map",
    "basins": "basins",
    "harmonic": "harmonic",
    "taguchi": "taguchi",
    "calibrate": "calibrate",
    "reproduce": "reproduce",
    "quality": "quality",
    "analyze": "analyze",
    "replay": "replay",
    "recover": "recover",
    "completion": "completion",
}
# Those that run the model in this process. Compiling it takes some seconds, once on a machine, in which they say so.
_MODELLING = frozenset(
    (
        *("simulate", "sweep", "map", "basins", "harmonic", "taguchi"),
        *("calibrate", "reproduce", "quality", "analyze", "replay"),
    )
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `seat-gear`; returns 0 done, 1 failed; wrong use exits with 2."""
    parser = _parser()
    if "_ARGCOMPLETE" in os.environ:  # set by the code of `seat-gear completion`
        import_module("seat_gear_dynamics.commands.completion").complete(parser)
    parsed = parser.parse_args(arguments)
    try:
        with _compilation_told(parsed):
            return int(parsed.run(parsed))
    except KeyboardInterrupt:
        return 130
    except _expected() as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except Exception as error:
        # Interrupted while it started, a pool of processes fails to clean up: still the end that was asked for.
        if isinstance(error.__context__, KeyboardInterrupt):
            return 130
        raise


def _compilation_told(parsed: argparse.Namespace) -> AbstractContextManager[None]:
    """Return the context in which a compilation is told on standard error; with --json it stays silent."""
    if parsed.command not in _MODELLING or parsed.json:
        return nullcontext()
    from seat_gear_dynamics.motion.compiling import announced

    return announced(lambda text: print(text, file=sys.stderr, flush=True))


def _expected() -> tuple[type[Exception], ...]:
    """Return the errors whose text is a sentence for the user; imported only once one has happened."""
    from seat_gear_dynamics.bench.errors import BenchError
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.gears.errors import DescriptionError
    from seat_gear_dynamics.logs.errors import LogError
    from seat_gear_dynamics.runtime.exceptions import RCLError

    return (BenchError, CommandError, DescriptionError, LogError, RCLError, OSError)


class _Parser(argparse.ArgumentParser):
    """Tells wrong use as every other error: in one line."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and end with 2."""
        self.exit(2, f"error: {message}; `{self.prog} --help` shows what is right\n")


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Wraps sentences, keeps the lines of an example, and has a column in which every command's name fits."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog)
        # argparse leaves out the indentation of the list of commands, and then breaks the line after long names.
        self._action_max_length = max(len(name) for name in COMMANDS) + 2 * self._indent_increment

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return super()._fill_text(text if "\n" in text else fill(text, width), width, indent)


def _parser() -> argparse.ArgumentParser:
    from seat_gear_dynamics.commands.texts import broken

    parser = _Parser(
        prog="seat-gear",
        formatter_class=_Formatter,
        description="Virtual sensor and rattle warning for car-seat height adjusters.",
        epilog="Start with: seat-gear bench --duration 60",
    )
    parser.add_argument("--version", action="version", version=f"seat-gear {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, module_name in COMMANDS.items():
        module = import_module(f"seat_gear_dynamics.commands.{module_name}")
        texts = module.TEXTS[name]
        command = commands.add_parser(
            name,
            help=texts.help,
            description=texts.help,
            epilog=f"example:\n  {broken(texts.example)}",
            formatter_class=_Formatter,
        )
        command.add_argument(
            "--system", metavar="FILE", help="system description (default: the packaged height adjuster)"
        )
        command.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
        module.add_arguments(command)
        command.set_defaults(run=module.run, command=name)
    return parser
