"""The Python interface for autodoc: which names, their signatures as the source has them, docstrings as plain text."""

import ast
import inspect
import re
import textwrap
from importlib import import_module
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

ROOMS = ("", ".gears", ".motion", ".motion.integrators", ".regimes", ".sensing")
"""Whose public names are documented; `` is the package itself."""
_PACKAGE = "seat_gear_dynamics"


def reference() -> str:
    """Return a section for each room and a directive for each of its public names; a name stands once."""
    documented: set[int] = set()
    return "\n\n".join(_room(room, documented) for room in ROOMS)


def _room(room: str, documented: set[int]) -> str:
    module = import_module(_PACKAGE + room)
    words = inspect.cleandoc(module.__doc__ or "").splitlines()[0]
    lines = [f"## {_PACKAGE}{room}", "", words, "", "```{eval-rst}"]
    for name in sorted(module.__all__, key=str.lower):
        found = getattr(module, name)
        if name.startswith("__") or (id(found) in documented and callable(found)):
            continue
        documented.add(id(found))
        lines += [*_directive(f"{_PACKAGE}{room}.{name}", found), ""]
    return "\n".join([*lines, "```"])


def _directive(name: str, found: object) -> list[str]:
    if inspect.isclass(found):
        return [f".. autoclass:: {name}", "   :members:", "   :undoc-members:"]
    return [f".. autofunction:: {name}" if callable(found) else f".. autodata:: {name}"]


def setup(app: Sphinx) -> dict[str, Any]:
    """Give autodoc the source's own words."""
    app.connect("autodoc-process-signature", _signature)
    app.connect("autodoc-process-docstring", _docstring)
    app.connect("missing-reference", _missing)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _signature(
    app: Sphinx, what: str, name: str, found: Any, options: Any, given: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Return the signature as it is written, since the annotations' own names are shorter than what they stand for."""
    node = _source(found)
    if isinstance(node, ast.ClassDef):
        return _of_class(node, given), None
    if isinstance(node, ast.FunctionDef):
        back = ast.unparse(node.returns) if node.returns else ""
        return f"({_arguments(node)})", back.replace('"', "").replace("'", "") or None
    return given, None


def _of_class(node: ast.ClassDef, given: str | None) -> str | None:
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and each.name == "__init__":
            return f"({_arguments(each)})"
    fields = [each for each in node.body if isinstance(each, ast.AnnAssign)]
    return f"({', '.join(ast.unparse(each.target) for each in fields)})" if fields else given


def _arguments(node: ast.FunctionDef) -> str:
    text = ast.unparse(node.args)
    bound = re.sub(r"^(self|cls)(, )?", "", text)
    return re.sub(r"'(\w+)'", r"\1", bound) if bound else ""


def _source(found: Any) -> ast.AST | None:
    try:
        return ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(found)))).body[0]
    except (TypeError, OSError, SyntaxError, IndentationError):
        return None


def _docstring(app: Sphinx, what: str, name: str, found: Any, options: Any, lines: list[str]) -> None:
    """Turn a docstring, which is plain text with `code` in it, into reStructuredText that shows it as it is."""
    if what == "data" and lines[:1] == inspect.cleandoc(type(found).__doc__ or "").splitlines()[:1]:
        lines.clear()  # a constant without words of its own: autodoc gives those of its type
    kind = _annotation(name, found) if what in ("attribute", "property") else ""
    first = [f"*{_escaped(kind)}*", ""] if kind else []
    lines[:] = [*first, *(_converted(line) for line in lines)]


def _converted(line: str) -> str:
    parts = line.split("`")
    if len(parts) % 2 == 0:
        return _escaped(line)
    return "".join(f"``{part}``" if k % 2 else _escaped(part) for k, part in enumerate(parts))


def _escaped(text: str) -> str:
    return re.sub(r"([\\*|_`])", r"\\\1", text)


def _annotation(name: str, found: Any) -> str:
    """Return the type of a field or property as the source writes it."""
    if isinstance(found, property) or hasattr(found, "func"):
        node = _source(getattr(found, "fget", None) or found.func)
        return ast.unparse(node.returns) if isinstance(node, ast.FunctionDef) and node.returns else ""
    owner, _, field = name.rpartition(".")
    module, _, kind = owner.rpartition(".")
    body = getattr(_source(getattr(import_module(module), kind, None)), "body", [])
    for each in body:
        if isinstance(each, ast.AnnAssign) and ast.unparse(each.target) == field:
            return ast.unparse(each.annotation).strip("'\"")
    return ""


def _missing(app: Sphinx, env: Any, node: Any, content: nodes.Node) -> nodes.Node | None:
    """Leave the name of a type that no page documents as plain text; links that authors write stay strict."""
    return content if node.get("refdomain") == "py" and node.get("reftype") in ("class", "obj", "exc") else None
