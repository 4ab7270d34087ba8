"""`seat-gear bench`: the main job on one machine, from the simulated bench to the log's report."""

import argparse
import json
from pathlib import Path

from seat_gear_dynamics.commands.dashboard import PORT, port
from seat_gear_dynamics.commands.texts import Texts

TEXTS = {
    "bench": Texts(
        "simulator, monitor and recorder as three processes, a live view, then the log's report",
        "seat-gear bench --duration 20 --profile dwell-in-band",
    )
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("--duration", type=float, metavar="S", help="length of the run, s (default: until Ctrl-C)")
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="directory of the log (default: seat_gear_log_<date and time>)"
    )
    parser.add_argument(
        "--profile", default="up-down", metavar="NAME", help="up-down, run-up, run-down, dwell-in-band or load-step"
    )
    parser.add_argument(
        "--dashboard",
        nargs="?",
        const=PORT,
        type=port,
        metavar="PORT",
        help=f"serve the dashboard to this machine, read-only (default port {PORT})",
    )
    parser.add_argument(
        "--map",
        metavar="F.npz",
        help="regime map whose bands follow the load, or `packaged` (default: the published bands)",
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the simulated noise (default 0)")


def run(arguments: argparse.Namespace) -> int:
    """Run the bench, then report."""
    from seat_gear_dynamics.commands.analyze import report
    from seat_gear_dynamics.runtime import provide_rclpy

    provide_rclpy()  # before anything that imports rclpy
    from seat_gear_dynamics.commands.bench_run import BenchRun

    bench = BenchRun(
        duration=arguments.duration,
        output=arguments.output,
        profile_name=arguments.profile,
        system=arguments.system,
        seed=arguments.seed,
        quiet=arguments.json,
        dashboard=arguments.dashboard,
        chart=arguments.map,
    )
    ended = bench.run()
    if not bench.output.exists():  # Ctrl-C came before the recorder had made its log
        raise KeyboardInterrupt
    values, lines = report(bench.output, None, arguments.system, chart=bench.chart, quiet=arguments.json)
    values["ended"] = ended
    print(json.dumps(values) if arguments.json else "\n".join(["", *lines]))
    return 0
