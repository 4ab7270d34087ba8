"""Whether a real ROS 2 is here, whatever the bundled runtime has put on the path."""

import importlib.machinery
import os
import sys
from pathlib import Path

from seat_gear_dynamics.runtime import STAND_IN

PATH = [entry for entry in sys.path if entry != STAND_IN]
"""Where programs of real ROS 2 look for their modules."""
REAL_RCLPY = importlib.machinery.PathFinder.find_spec("rclpy", PATH) is not None
ON_CYCLONE = not REAL_RCLPY or os.environ.get("RMW_IMPLEMENTATION") == "rmw_cyclonedds_cpp"
"""Whether nodes speak through Cyclone DDS; Jazzy's default is Fast DDS."""


def program(package: str, name: str) -> Path | None:
    """Return a ROS package's program where the package is installed."""
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    found = (Path(prefix) / "lib" / package / name for prefix in prefixes if prefix)
    return next((path for path in found if path.is_file()), None)
