"""`seat-gear dashboard`: one page in the browser that shows the running bench."""

import argparse
import json
from pathlib import Path

from seat_gear_dynamics.commands.texts import Texts

TEXTS = {
    "dashboard": Texts(
        "one page in the browser: speed, bands, forces, warning and recorder, live",
        "seat-gear dashboard --port 8642",
    )
}
PORT = 8642


def port(text: str) -> int:
    """Return an argument as a TCP port, 0 for any free one."""
    number = int(text) if text.isascii() and text.isdigit() else -1
    if not 0 <= number <= 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is no port, expected a whole number from 0 (any free one) to 65535")
    return number


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument(
        "--host", default="127.0.0.1", metavar="ADDRESS", help="listen there (default: this machine only)"
    )
    parser.add_argument("--port", type=port, default=PORT, metavar="N", help=f"default {PORT}; 0: any free one")
    parser.add_argument(
        "--map",
        type=Path,
        metavar="F.npz",
        help="regime map that `seat-gear map` wrote (default: packaged, where it is of this machine)",
    )
    parser.add_argument(
        "--allow-control", action="store_true", help="let the page start, stop and snapshot the recorder"
    )
    parser.add_argument(
        "--token-file", type=Path, metavar="FILE", help="token to keep over restarts; written where there is none"
    )
    parser.add_argument(
        "--ros-args", nargs=argparse.REMAINDER, default=[], help="ROS arguments (remapping, namespace), to the end"
    )


def run(arguments: argparse.Namespace) -> int:
    """Serve until told to end."""
    from seat_gear_dynamics.runtime import provide_rclpy

    provide_rclpy()  # before anything that imports rclpy
    from seat_gear_dynamics.commands.dashboard_run import Dashboard, Settings, serve_until_told

    settings = Settings(
        host=arguments.host,
        port=arguments.port,
        system=arguments.system,
        map=arguments.map,
        control=arguments.allow_control,
        token_file=arguments.token_file,
    )

    def tell(dashboard: Dashboard) -> None:
        if arguments.json:
            print(json.dumps(dashboard.as_dict()), flush=True)
        else:
            print("\n".join(dashboard.words()), flush=True)

    serve_until_told(settings, arguments.ros_args, tell)
    return 0
