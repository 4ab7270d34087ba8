"""Say in one sentence that a name of rclpy is not part of the bundled runtime."""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import opcode
import sys
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

REMEDY = "is not part of the bundled runtime; source a ROS 2 Jazzy installation to use it."

_IMPORT_FROM = opcode.opmap["IMPORT_FROM"]


def sentence(name: str) -> str:
    """Return the sentence for a missing name, which may be dotted."""
    return f"{name} {REMEDY}"


def unsupported(name: str, value: object, supported: object) -> NotImplementedError:
    """Return the error for an argument value rclpy takes and this runtime does not."""
    return NotImplementedError(f"{name}={value!r} {REMEDY[:-1]}, or use {name}={supported!r}.")


def missing_from(module: str) -> Callable[[str], Any]:
    """Return a module `__getattr__` whose error names the missing attribute of `module`.

    `from module import name` raises ImportError and `module.name` AttributeError, each with the sentence:
    Python replaces the text of an AttributeError raised under a from-import, so that one is told apart.
    """

    def getattr_missing(name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        text = sentence(f"{module}.{name}")
        frame = sys._getframe(1)
        if frame.f_lasti >= 0 and frame.f_code.co_code[frame.f_lasti] == _IMPORT_FROM:
            raise ImportError(text, name=module)
        raise AttributeError(text)

    return getattr_missing


class MissingModules(importlib.abc.MetaPathFinder):
    """Last finder on the import path: a submodule of rclpy nobody found is named in a sentence."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Raise for `rclpy.something`, pass on everything else."""
        if fullname.startswith("rclpy."):
            raise ModuleNotFoundError(sentence(fullname), name=fullname)
        return None


def install_finder() -> None:
    """Put the finder last on `sys.meta_path`, once."""
    if not any(isinstance(finder, MissingModules) for finder in sys.meta_path):
        sys.meta_path.append(MissingModules())
