"""`seat-gear monitor`, `record` and `simulator`: one node each; the monitor with the live view."""

import argparse
import json

from seat_gear_dynamics.commands.texts import Texts

TEXTS = {
    "monitor": Texts(
        "run the monitor node: speed and load in, forces and warning out",
        "seat-gear monitor --set publish_rate=100.0",
    ),
    "record": Texts("run the recorder node: topics in, a bag out", "seat-gear record --set output=my_run"),
    "simulator": Texts(
        "run the simulator node: a bench that plays a profile", "seat-gear simulator --set profile=run-up"
    ),
}
_MODULES = {"monitor": "monitor", "record": "recorder", "simulator": "simulator"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that all nodes share."""
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a node parameter; may be repeated"
    )
    parser.add_argument(
        "--ros-args", nargs=argparse.REMAINDER, default=[], help="ROS arguments (remapping, namespace), to the end"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the node until it is told to end; the monitor beside its live view, but for --json."""
    flags = _ros_arguments(arguments)
    if arguments.command == "monitor" and not arguments.json:
        from seat_gear_dynamics.runtime import provide_rclpy

        provide_rclpy()  # before anything that imports rclpy
        from seat_gear_dynamics.commands.monitor_view import MonitorView

        return MonitorView(flags, arguments.system).run()
    from importlib import import_module

    node = import_module(f"seat_gear_dynamics.nodes.{_MODULES[arguments.command]}")
    code = int(node.main([arguments.command, "--ros-args", *flags]))
    if arguments.json:
        print(json.dumps({"node": node.NAME, "exit": code}))
    return code


def _ros_arguments(arguments: argparse.Namespace) -> list[str]:
    """Return what follows --ros-args; raises CommandError for a setting that is none."""
    parameters = [f"system:={arguments.system}"] if arguments.system else []
    for setting in arguments.set:
        name, equals, value = setting.partition("=")
        if not equals or not name:
            from seat_gear_dynamics.commands.errors import CommandError

            raise CommandError(f"--set got {setting!r}, expected NAME=VALUE, such as publish_rate=100.0.")
        parameters.append(f"{name}:={value}")
    flags = [part for parameter in parameters for part in ("-p", parameter)]
    return [*flags, *arguments.ros_args]
