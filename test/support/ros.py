"""Whether a real ROS 2 is here, whatever the bundled runtime has put on the path."""

import importlib.machinery
import sys

from seat_gear_dynamics.runtime import STAND_IN

PATH = [entry for entry in sys.path if entry != STAND_IN]
"""Where programs of real ROS 2 look for their modules."""
REAL_RCLPY = importlib.machinery.PathFinder.find_spec("rclpy", PATH) is not None
