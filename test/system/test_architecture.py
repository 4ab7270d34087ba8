"""The rooms and their arrows, as docs/architecture.md draws them, held against the real imports."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "seat_gear_dynamics"
ROOMS = sorted(path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__")
PURE = ("gears", "motion", "regimes", "studies", "sensing", "bench")


def drawn() -> dict[str, set[str]]:
    """Return room -> rooms it may import, from the table in the docs."""
    allowed: dict[str, set[str]] = {}
    for line in (ROOT / "docs" / "architecture.md").read_text().splitlines():
        if match := re.match(r"\| `(\w+)/` \|.*\|(.*)\|$", line):
            names = match[2].strip()
            allowed[match[1]] = set(ROOMS) if names == "everything" else {n.strip() for n in names.split(",")} - {""}
    return allowed


def modules(room: str) -> list[Path]:
    return [path for path in (PACKAGE / room).rglob("*.py") if "stand_in" not in path.parts]


def imported(path: Path) -> set[str]:
    """Return the full names of what a module imports, relative imports resolved."""
    names: set[str] = set()
    parents = path.relative_to(ROOT).with_suffix("").parts
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(parents[: -node.level]) + "." if node.level else ""
            names.add((base + (node.module or "")).rstrip("."))
    return names


@pytest.mark.parametrize("room", ROOMS)
def test_every_room_is_drawn_and_imports_only_what_the_drawing_allows(room: str) -> None:
    allowed = drawn()
    assert room in allowed, f"docs/architecture.md does not draw the room {room}"
    for path in modules(room):
        for name in imported(path):
            parts = name.split(".")
            if parts[0] == "seat_gear_dynamics" and len(parts) > 1 and parts[1] in ROOMS:
                assert parts[1] in allowed[room] | {room}, (
                    f"{path.name} imports {name}, which is no arrow of the drawing"
                )


def test_the_drawing_has_no_room_that_is_not_there() -> None:
    assert set(drawn()) == set(ROOMS)


@pytest.mark.parametrize("room", PURE)
def test_the_core_imports_no_ros_and_reads_no_clock(room: str) -> None:
    forbidden = {"rclpy", "std_msgs", "sensor_msgs", "time", "datetime", "cyclonedds", "mcap"}
    for path in modules(room):
        assert not forbidden & {name.split(".")[0] for name in imported(path)}, path


def test_dask_is_known_in_one_room() -> None:
    for room in ROOMS:
        for path in modules(room):
            known = {name.split(".")[0] for name in imported(path)} & {"dask", "distributed"}
            assert not known or room == "cluster", f"{path} imports {known}"


def test_every_module_says_in_one_sentence_what_it_is() -> None:
    for path in PACKAGE.rglob("*.py"):
        text = ast.get_docstring(ast.parse(path.read_text()))
        assert text, f"{path} has no docstring"


def test_modules_stay_readable() -> None:
    longest = max((len(path.read_text().splitlines()), path.name) for path in PACKAGE.rglob("*.py"))
    assert longest[0] <= 340, f"{longest[1]} has {longest[0]} lines"


def test_the_topic_names_stand_in_one_place() -> None:
    for path in PACKAGE.rglob("*.py"):
        if path.name != "topics.py":
            text = path.read_text()
            for name in ("gear_monitor/mesh", "gear_monitor/chaos", "gear_monitor/in_", "motor/speed", "load/torque"):
                assert not re.search(f'(?<!`)"{name}', text), f"{path.name} spells the topic {name}"


def named_in_views(path: Path) -> list[tuple[str, str]]:
    """Return what the result classes of a module name: `figures` or `tables`, and `module:function`."""
    classes = (node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ClassDef))
    words = [word for node in classes for word in node.keywords if word.arg in ("figure", "table")]
    return [(f"{word.arg}s", str(ast.literal_eval(word.value))) for word in words]


def test_the_one_way_up_is_by_name_and_leads_somewhere() -> None:
    """`plotting` imports no room; what results name for `plot` and `table` is a function of `views`."""
    assert not any(name.startswith("seat_gear_dynamics") for name in imported(PACKAGE / "plotting.py"))
    named = [each for room in ROOMS if room != "views" for path in modules(room) for each in named_in_views(path)]
    assert len(named) > 20
    for kind, name in named:
        module, _, function = name.partition(":")
        defined = ast.parse((PACKAGE / "views" / kind / f"{module}.py").read_text()).body
        assert function in {node.name for node in defined if isinstance(node, ast.FunctionDef)}, f"{kind} {name}"
