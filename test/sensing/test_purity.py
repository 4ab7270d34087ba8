"""The numerical core reads no clock, opens no file and knows no ROS: checked on its source."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import seat_gear_dynamics

PACKAGE = Path(seat_gear_dynamics.__file__).parent
ROOMS = ("gears", "motion", "regimes", "studies", "sensing")
MODULES = sorted(p for room in ROOMS for p in (PACKAGE / room).rglob("*.py"))
FORBIDDEN = {"time", "datetime", "rclpy", "random", "threading", "asyncio", "socket", "subprocess", "os", "logging"}
FILES = {"open", "read_text", "read_bytes", "write_text", "write_bytes", "load", "save", "loadtxt", "savetxt"}
ALLOWED_FILES = {
    "gears/description.py": {"read_text", "load"},  # the system description
    "motion/lanes/cache.py": {"read_text"},  # generated source, kept where the compiler keeps its code
    "regimes/regime_map.py": {"load"},  # NumPy's, from a file that the caller opened
}


def place(path: Path) -> str:
    return path.relative_to(PACKAGE).as_posix()


def imported(tree: ast.Module) -> Iterator[str]:
    """Yield the top-level names of every import, wherever it stands."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            names = {alias.name for alias in node.names}
            if (node.module, names) != ("os", {"cpu_count"}):  # how many threads to use changes no result
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
    assert {place(p).split("/")[0] for p in MODULES} == set(ROOMS)
    assert set(ALLOWED_FILES) <= {place(p) for p in MODULES}


@pytest.mark.parametrize("path", MODULES, ids=place)
def test_no_clock_no_ros_and_no_process_is_imported(path: Path) -> None:
    assert not FORBIDDEN & set(imported(ast.parse(path.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("path", MODULES, ids=place)
def test_files_are_read_in_the_description_alone(path: Path) -> None:
    touched = FILES & set(called(ast.parse(path.read_text(encoding="utf-8"))))
    assert touched == ALLOWED_FILES.get(place(path), set())


def test_the_check_itself_sees_what_it_forbids() -> None:
    tree = ast.parse("def f():\n    from time import sleep\n    import os.path\n    Path('x').open()\n    open('y')\n")
    assert {"time", "os"} <= set(imported(tree))
    assert "open" in set(called(tree))
