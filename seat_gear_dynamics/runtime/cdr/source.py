"""Python source of a CDR function under construction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from seat_gear_dynamics.runtime.interfaces import Kind

Layout = Mapping[str, Kind]


LayoutOf = Callable[[str], Layout]


class Source:
    """Lines of a function under construction, with the alignment known at the current position.

    `known` is the largest power of two (at most 8) the position is known modulo, `offset` the remainder.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.names: dict[str, Any] = {}
        self.known = 1
        self.offset = 0
        self.format = ""
        self.values: list[str] = []
        self.indent = 1
        self._counter = 0

    def fresh(self, prefix: str) -> str:
        """Return a name not used yet."""
        self._counter += 1
        return f"{prefix}{self._counter}"

    def emit(self, line: str) -> None:
        """Append a line at the current indent."""
        self.lines.append("    " * self.indent + line)

    def forget(self) -> None:
        """Note that nothing is known about the position any more."""
        self.known, self.offset = 1, 0

    def compile(self, name: str, signature: str) -> Callable[..., Any]:
        """Return the finished function."""
        text = f"def {name}({signature}):\n" + "\n".join(self.lines or ["    pass"])
        exec(compile(text, f"<cdr {name}>", "exec"), self.names)
        function: Callable[..., Any] = self.names[name]
        return function
