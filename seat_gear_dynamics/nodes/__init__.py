"""Monitor, recorder, simulator and the live listener: thin rclpy code.

Importing this package makes `rclpy` importable: the real one where ROS 2 is sourced, else the bundled runtime.
"""

from seat_gear_dynamics.runtime import provide_rclpy

RUNTIME = provide_rclpy()
"""`rclpy` or `bundled`: which runtime the nodes of this process run on."""
