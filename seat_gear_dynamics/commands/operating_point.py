"""The machine under the conditions that a command line gives: its operating point, its damping and its backlash."""

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from seat_gear_dynamics.motion import System


def add_mesh_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what may be changed of both meshes."""
    parser.add_argument("--damping", type=float, metavar="ξ", help="mesh damping ratio (default: the system's)")
    parser.add_argument("--backlash-um", type=float, metavar="B", help="backlash, µm (default: the system's)")


def system_at(arguments: argparse.Namespace) -> "System":
    """Return the system at the command's operating point, with its damping and backlash in both meshes.

    Takes `frequency`, or `speed_rpm` where the command has it, and `load`. Raises ValueError for impossible conditions.
    """
    from seat_gear_dynamics.gears.units import RPM
    from seat_gear_dynamics.motion import load_system

    system, micrometres = load_system(arguments.system), arguments.backlash_um
    for name, value in (("damping", arguments.damping), ("backlash", micrometres)):
        if value is not None and not 0 <= value < float("inf"):
            raise ValueError(f"The {name} is {value!r}, expected a finite number of at least 0.")
    train = system.train
    for index in (0, 1):
        backlash = None if micrometres is None else micrometres * 1e-6
        train = train.with_mesh(index, damping_ratio=arguments.damping, backlash=backlash)
    rpm = getattr(arguments, "speed_rpm", None)
    speed = None if rpm is None else rpm * RPM
    return replace(system, train=train).at(frequency=arguments.frequency, speed=speed, load=arguments.load)
