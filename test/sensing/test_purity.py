"""The numerical core reads no clock, opens no file and knows no ROS: checked on its source."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import seat_gear_dynamics

PACKAGE = Path(seat_gear_dynamics.__file__).parent
MODULES = sorted(p for room in ("gears", "motion", "regimes", "sensing") for p in (PACKAGE / room).rglob("*.py"))
FORBIDDEN = {"time", "datetime", "rclpy", "random", "threading", "asyncio", "socket", "subprocess", "os", "logging"}
FILES = {"open", "read_text", "read_bytes", "write_text", "write_bytes", "load", "save", "loadtxt", "savetxt"}
READER = PACKAGE / "gears" / "description.py"


def imported(tree: ast.Module) -> Iterator[str]:
    """Yield the top-level names of every import, wherever it stands."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield (node.module or "").split(".")[0]


def called(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            function = node.func
            if isinstance(function, ast.Attribute):
                yield function.attr
            elif isinstance(function, ast.Name):
                yield function.id


def test_the_rooms_of_the_core_are_found() -> None:
    assert {p.parent.name for p in MODULES} == {"gears", "motion", "regimes", "sensing"}
    assert READER in MODULES


@pytest.mark.parametrize("path", MODULES, ids=lambda p: f"{p.parent.name}/{p.name}")
def test_no_clock_no_ros_and_no_process_is_imported(path: Path) -> None:
    assert not FORBIDDEN & set(imported(ast.parse(path.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("path", MODULES, ids=lambda p: f"{p.parent.name}/{p.name}")
def test_files_are_read_in_the_description_alone(path: Path) -> None:
    touched = FILES & set(called(ast.parse(path.read_text(encoding="utf-8"))))
    assert touched == ({"read_text", "load"} if path == READER else set())


def test_the_check_itself_sees_what_it_forbids() -> None:
    tree = ast.parse("def f():\n    from time import sleep\n    import os.path\n    Path('x').open()\n    open('y')\n")
    assert {"time", "os"} <= set(imported(tree))
    assert "open" in set(called(tree))
