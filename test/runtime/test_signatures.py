"""Every bundled callable against rclpy's own: same parameters, same order, same kinds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from programs import Run
from ros import PATH, REAL_RCLPY

TABLE = Path(__file__).with_name("rclpy_signatures.json")
"""Parameters (name, kind, whether there is a default) of the functions and methods of rclpy 7.1 (Jazzy)."""

NOT_FOR_USERS = {"Client", "EventHandler", "LifecyclePublisher", "Publisher", "Service", "Subscription"}
"""Classes rclpy's documentation tells users not to construct: their __init__ takes handles of its C library."""

NOT_IN_TABLE = {
    "LoggingSeverity",
    "SignalHandlerOptions",
    "NodeNameNonExistentError",
    "TransitionCallbackReturn",
    "UnsupportedEventTypeError",
}
"""Names rclpy takes from its C library, which the table does not cover."""

COLLECT = """
from seat_gear_dynamics.runtime import provide_rclpy, STAND_IN
provide_rclpy()
import importlib, inspect, json, pathlib

INHERITED = {"CallbackGroup", "Clock", "Executor", "Future", "ManagedEntity", "SimpleManagedEntity"}

def parameters(function, skip_self):
    found = []
    for p in list(inspect.signature(function).parameters.values())[skip_self:]:
        found.append([p.name, p.kind.name.lower(), p.default is not p.empty])
    return found

from rclpy.node import Node
from rclpy.publisher import Publisher

def inherited(cls, member, attribute):
    # Under the plain class the table has it.
    return any(
        cls is not base and issubclass(cls, base) and inspect.getattr_static(base, member, None) is attribute
        for base in (Node, Publisher)
    )

table = {}
packages = ("rclpy", "rclpy.lifecycle")
modules = [
    package if path.stem == "__init__" else f"{package}.{path.stem}"
    for package in packages
    for path in sorted(pathlib.Path(STAND_IN, *package.split(".")).glob("*.py"))
]
for module in modules:
    names = importlib.import_module(module)
    for name in names.__all__:
        value = getattr(names, name)
        if inspect.isfunction(value):
            table[f"{module}:{name}"] = parameters(value, 0)
        if not inspect.isclass(value):
            continue
        for member in dir(value):
            if member.startswith("_") and member != "__init__":
                continue
            attribute = inspect.getattr_static(value, member)
            if inherited(value, member, attribute):
                continue
            # The table has a method under the class that defines it.
            owner = next((c.__name__ for c in value.__mro__ if member in vars(c)), name)
            owner = owner if owner in names.__all__ or owner in INHERITED else name
            if isinstance(attribute, property):
                table[f"{module}:{owner}.{member}"] = "property"
            elif isinstance(attribute, classmethod):
                table[f"{module}:{owner}.{member}"] = parameters(attribute.__func__, 1)
            elif inspect.isfunction(attribute):
                table[f"{module}:{owner}.{member}"] = parameters(attribute, 1)
print(json.dumps(table))
"""


@pytest.fixture
def bundled(run: Run) -> dict[str, Any]:
    program = run(COLLECT)
    assert program.wait() == 0, program.lines
    found: dict[str, Any] = json.loads(program.lines[-1])
    return found


def same(bundled: Any, real: Any) -> bool:
    """Return whether the bundled parameters are the real ones, or fewer optional ones in the same order."""
    if bundled == "property" or real == "property":
        return bool(bundled == real)
    wanted = iter(real)
    return all(parameter in wanted for parameter in bundled) and all(
        parameter in bundled or parameter[2] for parameter in real if not parameter[1].startswith("var_")
    )


def test_signatures_are_those_of_rclpy(bundled: dict[str, Any]) -> None:
    real = json.loads(TABLE.read_text())
    by_name: dict[str, list[Any]] = {}
    for key, parameters in real.items():
        by_name.setdefault(key.partition(":")[2], []).append(parameters)
    wrong = []
    for key, parameters in bundled.items():
        name = key.partition(":")[2]
        owner = name.partition(".")[0]
        if owner in NOT_IN_TABLE or (name.endswith(".__init__") and owner in NOT_FOR_USERS):
            continue
        candidates = by_name.get(name)
        if candidates is None and name.endswith("__init__"):
            continue
        if not any(same(parameters, candidate) for candidate in candidates or ()):
            wrong.append(f"{key}{parameters} is not {candidates}")
    assert not wrong, "\n".join(wrong)
    assert len(bundled) > 200
    assert "rclpy.lifecycle:LifecycleNodeMixin.create_lifecycle_publisher" in bundled


@pytest.mark.ros
@pytest.mark.skipif(not REAL_RCLPY, reason="rclpy is not importable")
def test_table_is_that_of_the_rclpy_here(run: Run) -> None:
    program = run(
        """
        import importlib, inspect, json, pathlib, sys
        for key, parameters in json.loads(pathlib.Path(sys.argv[1]).read_text()).items():
            module, _, path = key.partition(":")
            value = importlib.import_module(module)
            for part in path.split("."):
                value = inspect.getattr_static(value, part) if inspect.isclass(value) else getattr(value, part)
            if parameters == "property":
                assert isinstance(value, property), key
                continue
            function = getattr(value, "__func__", value)
            found = [[p.name, p.kind.name.lower(), p.default is not p.empty]
                     for p in inspect.signature(function).parameters.values()]
            skip = len(found) - len(parameters)
            assert skip in (0, 1) and found[skip:] == parameters, (key, found, parameters)
        print("same")
        """,
        str(TABLE),
        SEAT_GEAR_RUNTIME="rclpy",
        PYTHONPATH=":".join(PATH),
    )
    program.expect("same")
