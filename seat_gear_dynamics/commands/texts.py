"""The texts that every command's help has."""

from typing import NamedTuple


class Texts(NamedTuple):
    """One line of help and an example that runs."""

    help: str
    example: str
