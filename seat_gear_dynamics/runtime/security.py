"""ROS 2's security settings, and why the bundled runtime refuses to run where they demand security."""

from __future__ import annotations

from collections.abc import Mapping

from seat_gear_dynamics.runtime.exceptions import RCLError

ENABLE, STRATEGY = "ROS_SECURITY_ENABLE", "ROS_SECURITY_STRATEGY"
"""The variables that rcl reads to learn whether security is wanted, and whether it may be missing."""

_OFF = ("", "0", "false", "no", "off")
_REMEDY = (
    "The Cyclone DDS of the PyPI package cyclonedds has no DDS security, so everything would go over the network "
    "readable and open to everybody. Run the node on ROS 2 (source it; SEAT_GEAR_RUNTIME=rclpy), or take security "
    f"back with {ENABLE}=false."
)


def insecurity(environment: Mapping[str, str]) -> str | None:
    """Return a warning where security was wished for and cannot be had, None where nobody asked for it.

    Follows rcl: `ROS_SECURITY_ENABLE` must be `true`, and `ROS_SECURITY_STRATEGY` is `Enforce` or `Permissive`,
    the default, with which ROS 2 goes on insecurely where something is missing. rcl takes every other word for no or
    for Permissive; here it is an error, for whoever writes `True` or `enforce` means to be secure.

    Raises:
        RCLError: security is enforced, or one of the two words cannot be understood.
    """
    wanted, strategy = environment.get(ENABLE, ""), environment.get(STRATEGY, "")
    if wanted.lower() in _OFF:
        return None
    if wanted != "true":
        raise RCLError(f"{ENABLE} is {wanted!r}, expected true or false: ROS 2 would read it as false. {_REMEDY}")
    if strategy == "Enforce":
        raise RCLError(f"{STRATEGY} is Enforce, and the bundled runtime cannot obey. {_REMEDY}")
    if strategy not in ("", "Permissive"):
        raise RCLError(
            f"{STRATEGY} is {strategy!r}, expected Enforce or Permissive: ROS 2 would read it as Permissive. {_REMEDY}"
        )
    return f"{ENABLE} is true and the strategy Permissive: running WITHOUT security. {_REMEDY}"
