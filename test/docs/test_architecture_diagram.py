"""The diagram of the rooms, held against imports that are read here in another way, and against the table."""

import re
from pathlib import Path

import pytest

from docs.generate import architecture

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "seat_gear_dynamics"
IMPORT = re.compile(r"^\s*(?:from|import) seat_gear_dynamics\.(\w+)", re.MULTILINE)


def real() -> dict[str, set[str]]:
    """Return room -> rooms below it, found by the lines of text that import."""
    rooms = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    direct = {
        room: {
            target
            for path in (PACKAGE / room).rglob("*.py")
            if "stand_in" not in path.parts
            for target in IMPORT.findall(path.read_text(encoding="utf-8"))
        }
        & rooms - {room}
        for room in rooms
    }
    return {room: below(direct, room) for room in rooms}


def below(direct: dict[str, set[str]], room: str) -> set[str]:
    found: set[str] = set()
    waiting = set(direct[room])
    while waiting:
        found |= waiting
        waiting = {target for each in waiting for target in direct[each]} - found
    return found


def drawn(text: str) -> dict[str, set[str]]:
    """Return room -> rooms that the arrows of a drawing lead to, over others or not."""
    direct: dict[str, set[str]] = {room: set() for room in re.findall(r'class="name">(\w+)<', text)}
    for room, target in re.findall(r'data-arrow="(\w+) (\w+)"', text):
        direct[room].add(target)
    return {room: below(direct, room) for room in direct}


def test_the_arrows_lead_where_the_imports_do() -> None:
    assert drawn(architecture.diagram()) == real()


def test_an_arrow_that_follows_from_others_is_not_drawn() -> None:
    arrows = {"top": {"middle", "low"}, "middle": {"low"}, "low": set[str]()}
    assert architecture.drawn(arrows) == [("middle", "low"), ("top", "middle")]
    assert drawn(architecture.svg(arrows)) == {"top": {"middle", "low"}, "middle": {"low"}, "low": set()}


def test_rooms_do_not_overlap() -> None:
    places = re.findall(r'<rect x="([\d.]+)" y="([\d.]+)"', architecture.diagram())
    corners = [(float(x), float(y)) for x, y in places]
    assert len(corners) == len(real())
    for k, (x, y) in enumerate(corners):
        # A room is 150 wide and 46 high.
        assert all(abs(x - x1) >= 150 or abs(y - y1) >= 46 for x1, y1 in corners[:k])


def test_imports_in_a_circle_are_refused() -> None:
    with pytest.raises(ValueError, match="a, b import in a circle"):
        architecture.levels({"a": {"b"}, "b": {"a"}, "c": set()})
