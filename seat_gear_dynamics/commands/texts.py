"""The texts that every command's help has."""

from typing import NamedTuple

_EXAMPLE_WIDTH = 76
"""Columns of a line of an example: two of indentation and two of a backslash make 80."""


class Texts(NamedTuple):
    """One line of help and an example that runs."""

    help: str
    example: str


def broken(example: str) -> str:
    """Return a command line in lines that fit 80 columns, each but the last continued for the shell."""
    lines = [""]
    for word in example.replace(" -", "\0-").split("\0"):  # an option stays with its values
        if lines[-1] and len(lines[-1]) + 1 + len(word) > _EXAMPLE_WIDTH:
            lines.append(f"    {word}")
        else:
            lines[-1] += f" {word}" if lines[-1] else word
    return " \\\n  ".join(lines)
