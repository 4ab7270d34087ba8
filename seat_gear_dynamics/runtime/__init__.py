"""Run plain rclpy node code with ROS 2 where it is sourced and over bundled DDS where it is not."""

from __future__ import annotations

import importlib
import importlib.machinery
import importlib.util
import os
import sys
from pathlib import Path

STAND_IN = str(Path(__file__).resolve().parent / "stand_in")
"""Directory of the packages that take rclpy's place where ROS 2 is absent."""

_CHOICES = ("rclpy", "bundled")


def provide_rclpy() -> str:
    """Make `import rclpy` work and say what it resolves to: "rclpy" or "bundled".

    Real rclpy is taken where it is importable. The environment variable SEAT_GEAR_RUNTIME set to `bundled`
    forces the bundled runtime, `rclpy` insists on the real one. Calling it again changes nothing and is cheap.

    Raises:
        RuntimeError: SEAT_GEAR_RUNTIME has another value, or the other kind of rclpy is imported already.
        ModuleNotFoundError: SEAT_GEAR_RUNTIME is `rclpy` and no real rclpy can be found.
    """
    choice = os.environ.get("SEAT_GEAR_RUNTIME", "")
    if choice and choice not in _CHOICES:
        raise RuntimeError(
            f"SEAT_GEAR_RUNTIME is {choice!r}, expected 'rclpy' or 'bundled': set one of them or unset it."
        )
    loaded = _kind_loaded()
    if loaded is not None:
        return _accept_loaded(loaded, choice)
    if choice != "bundled" and _real_rclpy_exists():
        if STAND_IN in sys.path:
            sys.path.remove(STAND_IN)
        return "rclpy"
    if choice == "rclpy":
        raise ModuleNotFoundError(
            "SEAT_GEAR_RUNTIME is 'rclpy' and no rclpy can be imported: source a ROS 2 Jazzy installation "
            "(for example `source /opt/ros/jazzy/setup.bash`) or unset SEAT_GEAR_RUNTIME.",
            name="rclpy",
        )
    if STAND_IN not in sys.path:
        sys.path.insert(0, STAND_IN)
        importlib.invalidate_caches()
    return "bundled"


def _kind_loaded() -> str | None:
    """Return which kind of rclpy this interpreter has imported, if any."""
    module = sys.modules.get("rclpy")
    if module is None:
        return None
    return "bundled" if str(getattr(module, "__file__", "")).startswith(STAND_IN) else "rclpy"


def _accept_loaded(loaded: str, choice: str) -> str:
    if choice and choice != loaded:
        raise RuntimeError(
            f"SEAT_GEAR_RUNTIME is {choice!r} and the {loaded} kind of rclpy is imported already: "
            "set the variable before the program starts."
        )
    return loaded


def _real_rclpy_exists() -> bool:
    """Look for an rclpy anywhere but among the stand-ins, without importing it."""
    if STAND_IN not in sys.path:
        return importlib.util.find_spec("rclpy") is not None
    elsewhere = [entry for entry in sys.path if entry != STAND_IN]
    return importlib.machinery.PathFinder.find_spec("rclpy", elsewhere) is not None
