"""The monitor at work in a process of its own, and this process showing what it says."""

import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import rclpy
from rclpy.signals import SignalHandlerOptions
from rich.console import Console

from seat_gear_dynamics.commands.children import Child
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.commands.listener import Listener
from seat_gear_dynamics.commands.watching import told, watch
from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.views.live_screen import is_terminal, screen_on
from seat_gear_dynamics.views.live_state import LiveState

_PLAIN = 10.0  # s between two lines where the output is no terminal: a monitor may run for weeks
_ERROR = "error: "  # how a node begins the sentence that says why it ends


class MonitorView:
    """The monitor apart from its view: drawing takes no time from the model, and ends with it."""

    def __init__(self, ros_args: Sequence[str], system: str | None) -> None:
        """Take what follows --ros-args; raises DescriptionError for a `system` that is none."""
        train = load_train(system)
        self._ros_args = list(ros_args)
        self._console = Console()
        self._state = LiveState(
            title="seat-gear monitor",
            bands_rpm=tuple((band.low / RPM, band.high / RPM) for band in train.bands),
            covered_rpm=max(train.model.covered_speed / RPM, 2200.0),
            load_scale=train.model.load_scale,
            ending="Ctrl-C ends the monitor",
        )

    def run(self) -> int:
        """Run until told to end or until the monitor ends; return 0. Raises CommandError where it ends by itself."""
        with told() as signals, tempfile.TemporaryDirectory(prefix="seat_gear_monitor_") as folder:
            arguments = ["--ros-args", *_own(self._ros_args)]
            rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
            node = Listener(self._state, fed=True)
            words = Path(folder) / "monitor.txt"
            child = Child("monitor", ["--ros-args", *self._ros_args], words)
            try:
                return self._watch(node, child, words, lambda elapsed: child.running and not signals.to_end)
            finally:
                child.end()
                node.destroy_node()
                rclpy.try_shutdown()

    def _watch(self, node: Listener, child: Child, words: Path, going_on: Callable[[float], bool]) -> int:
        with screen_on(self._console, plain_period=_PLAIN) as screen, words.open(errors="replace") as log:
            say = screen.say if is_terminal(self._console) else _complain

            def tell() -> None:
                for line in log.read().splitlines():
                    if not line.startswith(_ERROR):
                        say(line)

            watch(node, screen, tell, going_on)
            by_itself = not child.running
            code = child.end()
            tell()
        if by_itself and code != 0:
            raise CommandError(_reason(child.words, code))
        return code


def _complain(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _reason(words: str, code: int) -> str:
    """Return the node's own sentence, or that it ended without one."""
    said = [line.removeprefix(_ERROR) for line in words.splitlines() if line.startswith(_ERROR)]
    return said[-1] if said else f"The monitor ended by itself with code {code}; what it said stands above."


def _own(ros_args: Sequence[str]) -> list[str]:
    """Return the arguments for the view's own node: the same names and namespace, but for the monitor's own name."""
    named = {place for place, given in enumerate(ros_args) if "__node:=" in given or "__name:=" in given}
    dropped = named | {place - 1 for place in named}  # with the -r before it
    return [argument for place, argument in enumerate(ros_args) if place not in dropped]
