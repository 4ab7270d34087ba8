"""The sentences that users may meet, taken from the code: what is raised, and what starts or stops a node."""

import ast
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from docs.generate.markdown import plain

PACKAGE = Path(__file__).resolve().parents[2] / "seat_gear_dynamics"
ERRORS = (
    "DescriptionError",
    "LogError",
    "CommandError",
    "StartError",
    "BenchError",
    "MapError",
    "ClusterError",
    "AccessError",
)
"""The errors whose text is a sentence for the user."""
_GAP = "…"
_SHORTEST = 20  # letters of its own; a sentence with fewer is put together elsewhere


@lru_cache(maxsize=1)
def texts() -> tuple[str, ...]:
    """Return every text of the package, its variable parts as `…`."""
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in sorted(PACKAGE.rglob("*.py")))
    nodes = (node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.expr))
    return tuple(text for text in map(_text, nodes) if text.replace(_GAP, ""))


def raised() -> Iterator[tuple[str, str, str]]:
    """Yield (room, module, sentence) of every error that is raised for users, in the order of the code."""
    for path in sorted(PACKAGE.rglob("*.py")):
        room, *_ = path.relative_to(PACKAGE).parts
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and _name(node.exc) in ERRORS:
                sentence = _argument(node.exc)
                if len(sentence.replace(_GAP, "")) >= _SHORTEST:
                    yield room, path.relative_to(PACKAGE).with_suffix("").as_posix(), sentence


def reference() -> str:
    """Return the sentences by the part of the program that says them."""
    rooms: dict[str, dict[str, None]] = {}
    for room, _, sentence in raised():
        rooms.setdefault(room, {})[sentence] = None
    return "\n\n".join(f"### {room}\n\n" + "\n".join(f"- {plain(s)}" for s in rooms[room]) for room in rooms)


def stands(quoted: str) -> bool:
    """Return whether a quoted message, its variable parts as `…`, is in the code."""
    pieces = [piece for piece in quoted.split(_GAP) if piece]
    scripts = ((PACKAGE.parent / "scripts" / name).read_text(encoding="utf-8") for name in ("environment",))
    return any(_in_order(pieces, text) for text in (*texts(), *scripts))


def _in_order(pieces: list[str], text: str) -> bool:
    begin = 0
    for piece in pieces:
        begin = text.find(piece, begin)
        if begin < 0:
            return False
        begin += len(piece)
    return True


def _name(call: ast.Call) -> str:
    return call.func.id if isinstance(call.func, ast.Name) else getattr(call.func, "attr", "")


def _argument(call: ast.Call) -> str:
    return _text(call.args[0]) if call.args else ""


def _text(node: ast.expr) -> str:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else _GAP
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(part) for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return _text(node.left) + _text(node.right)
    return _GAP
