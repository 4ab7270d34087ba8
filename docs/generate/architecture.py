"""The diagram of the rooms: who imports whom, read from the real imports and drawn as SVG."""

import ast
from collections.abc import Mapping
from html import escape
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "seat_gear_dynamics"
Arrows = Mapping[str, set[str]]

_WORDS = {
    "commands": "one file per command",
    "nodes": "thin ROS 2 code",
    "views": "what people see",
    "studies": "questions to the model",
    "logs": "bags on disk",
    "sensing": "sensor and warning",
    "regimes": "kind of motion",
    "motion": "how it moves",
    "gears": "what the machine is",
    "bench": "the simulated bench",
    "cluster": "more than one machine",
    "runtime": "rclpy's names over DDS",
}
_COLUMNS = {
    "cluster": 0.0,
    "studies": 0.5,
    "views": 1.0,
    "sensing": 1.0,
    "regimes": 1.0,
    "motion": 1.0,
    "gears": 1.0,
    "commands": 1.5,
    "logs": 1.5,
    "bench": 2.25,
    "nodes": 2.5,
    "runtime": 3.0,
}
"""Where a room likes to stand, in rooms from the left, so that arrows pass beside rooms and not behind them."""
_WIDTH, _HEIGHT, _ACROSS, _DOWN = 150, 46, 176, 88  # a room, and the distance from one to the next, px


def imports() -> dict[str, set[str]]:
    """Return room → the rooms that its modules import, the stand-in packages of the runtime left out."""
    rooms = {path.name for path in PACKAGE.iterdir() if path.is_dir() and any(path.glob("*.py"))}
    return {room: {target for target in _targets(room) if target in rooms} - {room} for room in sorted(rooms)}


def _targets(room: str) -> set[str]:
    found: set[str] = set()
    for path in (PACKAGE / room).rglob("*.py"):
        if "stand_in" in path.parts:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            found |= {name.split(".")[1] for name in names if name.startswith(f"{PACKAGE.name}.")}
    return found


def levels(arrows: Arrows) -> dict[str, int]:
    """Return room → the longest way down from it; raises ValueError where imports run in a circle."""
    found: dict[str, int] = {}
    while len(found) < len(arrows):
        ready = [room for room in arrows if room not in found and arrows[room] <= found.keys()]
        if not ready:
            raise ValueError(f"The rooms {', '.join(sorted(arrows.keys() - found.keys()))} import in a circle.")
        found.update({room: 1 + max((found[below] for below in arrows[room]), default=-1) for room in ready})
    return found


def drawn(arrows: Arrows) -> list[tuple[str, str]]:
    """Return the arrows to draw: those that do not follow from a way over other rooms."""
    return [
        (room, below)
        for room in sorted(arrows)
        for below in sorted(arrows[room])
        if not any(below in reached(arrows, other) for other in arrows[room] - {below})
    ]


def reached(arrows: Arrows, room: str) -> set[str]:
    """Return every room below `room`, itself left out."""
    return arrows[room].union(*(reached(arrows, below) for below in arrows[room]))


def diagram() -> str:
    """Return the diagram of the package as it is."""
    return svg(imports())


def svg(arrows: Arrows) -> str:
    """Return the rooms and arrows as SVG in the colours of the page; each arrow names its ends in `data-arrow`."""
    places = _places(arrows)
    width = max(x for x, _ in places.values()) + _WIDTH + 10
    height = max(y for _, y in places.values()) + _HEIGHT + 10
    parts = [_arrow(room, below, places) for room, below in drawn(arrows)]
    parts += [_room(room, *place) for room, place in places.items()]
    label = "Rooms of the package; an arrow points from a room to one that it imports"
    head = f'<svg class="rooms" viewBox="0 0 {width:g} {height:g}" role="img" aria-label="{label}">'
    tip = (
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
        '<path d="M0 0 8 4 0 8z"/></marker></defs>'
    )
    return "\n".join([head, tip, *parts, "</svg>"])


def _places(arrows: Arrows) -> dict[str, tuple[float, float]]:
    """Return where each room stands: below what imports it, in its column or as near to it as its row leaves room."""
    level, places = _hung(arrows), dict[str, tuple[float, float]]()
    lowest = min(level.values())
    for height in sorted(set(level.values())):
        row = [room for room in arrows if level[room] == height]
        column = -1.0
        for room in sorted(row, key=lambda room: (_COLUMNS.get(room, 9.0), room)):
            column = max(column + 1, _COLUMNS.get(room, 0.0))
            places[room] = (10 + _ACROSS * column, 10 + _DOWN * (max(level.values()) - height + lowest))
    return places


def _hung(arrows: Arrows) -> dict[str, int]:
    """Return the levels, each room that imports nothing raised to just below the lowest that imports it."""
    level = levels(arrows)
    for room in arrows:
        above = [level[other] for other in arrows if room in arrows[other]]
        if not arrows[room] and above:
            level[room] = min(above) - 1
    return level


def _room(room: str, x: float, y: float) -> str:
    return (
        f'<g class="room"><rect x="{x:g}" y="{y:g}" width="{_WIDTH}" height="{_HEIGHT}" rx="6"/>'
        f'<text x="{x + _WIDTH / 2:g}" y="{y + 19:g}" class="name">{escape(room)}</text>'
        f'<text x="{x + _WIDTH / 2:g}" y="{y + 36:g}">{escape(_WORDS.get(room, ""))}</text></g>'
    )


def _arrow(room: str, below: str, places: Mapping[str, tuple[float, float]]) -> str:
    (x0, y0), (x1, y1) = places[room], places[below]
    x0, x1, y0 = x0 + _WIDTH / 2, x1 + _WIDTH / 2, y0 + _HEIGHT
    bend = (y1 - y0) / 2
    return (
        f'<path class="arrow" data-arrow="{room} {below}" marker-end="url(#tip)" '
        f'd="M{x0:g} {y0:g}C{x0:g} {y0 + bend:g} {x1:g} {y1 - bend:g} {x1:g} {y1:g}"/>'
    )
