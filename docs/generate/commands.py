"""Every `seat-gear` command as its parser has it: usage, arguments, example."""

import argparse
from collections.abc import Mapping

from docs.generate.markdown import block, code, plain, table
from seat_gear_dynamics.commands import COMMANDS, _parser


def parsers() -> Mapping[str, argparse.ArgumentParser]:
    """Return the parser of each command by its name."""
    for action in _parser()._actions:
        if isinstance(action, argparse._SubParsersAction):
            return {name: parser for name, parser in action.choices.items() if name in COMMANDS}
    raise ValueError("The command line has no commands.")


def reference() -> str:
    """Return a section for each command."""
    return "\n\n".join(_command(name, parser) for name, parser in parsers().items())


def _command(name: str, parser: argparse.ArgumentParser) -> str:
    words = plain(parser.description or "")
    parts = [f"## seat-gear {name}", f"{words[:1].upper()}{words[1:]}."]
    rows = [_row(action) for action in parser._actions if action.help != argparse.SUPPRESS]
    parts.append(table(("argument", "takes", "meaning"), rows))
    example = (parser.epilog or "").partition("example:")[2]
    if example.strip():
        parts += ["Example:", block("\n".join(line.strip() for line in example.strip().splitlines()), "sh")]
    return "\n\n".join(parts)


def _row(action: argparse.Action) -> tuple[str, str, str]:
    names = ", ".join(code(name) for name in action.option_strings) or code(action.metavar or action.dest)
    needed = " (needed)" if action.required and action.option_strings else ""
    return names + needed, _takes(action), plain((action.help or "").replace("%(default)s", str(action.default)))


def _takes(action: argparse.Action) -> str:
    if action.choices is not None:
        return ", ".join(code(choice) for choice in action.choices)
    if action.nargs == 0 or not action.option_strings:
        return ""
    metavar = action.metavar or action.dest.upper()
    return code(" ".join(metavar) if isinstance(metavar, tuple) else metavar)
