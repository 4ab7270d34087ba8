"""Paths that commands write to, checked while the command line is read: before hours of computing, not after."""

import argparse
from collections.abc import Callable
from pathlib import Path

PICTURE_ENDINGS = (".png", ".svg", ".pdf")


def path_ending_in(*endings: str) -> Callable[[str], Path]:
    """Return an argparse type: a path in a folder that exists, with one of `endings` (none: any)."""

    def path(text: str) -> Path:
        found = Path(text)
        if endings and found.suffix.lower() not in endings:
            raise argparse.ArgumentTypeError(f"{text!r} ends in {found.suffix!r}, expected {', '.join(endings)}")
        if not found.parent.is_dir():
            raise argparse.ArgumentTypeError(f"the folder {str(found.parent)!r} of {text!r} does not exist; make it")
        if found.is_dir():
            raise argparse.ArgumentTypeError(f"{text!r} is a folder, expected a file's name")
        return found

    return path
