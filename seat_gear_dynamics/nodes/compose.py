"""Several nodes in one process: `python -m seat_gear_dynamics.nodes.compose monitor recorder [--ros-args …]`."""

import sys
from collections.abc import Callable, Sequence

from rclpy.node import Node

from seat_gear_dynamics.nodes.monitor import Monitor
from seat_gear_dynamics.nodes.process import run_together
from seat_gear_dynamics.nodes.recorder import Recorder
from seat_gear_dynamics.nodes.simulator import Simulator

COMPONENTS: dict[str, Callable[[], Node]] = {"simulator": Simulator, "monitor": Monitor, "recorder": Recorder}
"""What may be named, in the order in which nodes are best made and closed: the source first, the log last."""


def main(args: Sequence[str] | None = None) -> int:
    """Run the nodes named before `--ros-args`, all without any, under one executor; returns the exit code.

    One thread runs them all: a callback of one holds up the others. Messages between them go through DDS as always.
    """
    words = list(sys.argv if args is None else args)
    own = words[1 : words.index("--ros-args") if "--ros-args" in words else len(words)]
    unknown = [name for name in own if name not in COMPONENTS]
    if unknown:
        print(f"error: {unknown[0]!r} is no component; expected some of {', '.join(COMPONENTS)}.", file=sys.stderr)
        return 2
    chosen = own or list(COMPONENTS)
    return run_together([make for name, make in COMPONENTS.items() if name in chosen], words)


if __name__ == "__main__":
    raise SystemExit(main())
