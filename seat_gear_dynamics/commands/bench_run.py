"""One run of the bench: start the three processes in order, watch them live, end them in order."""

import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from time import monotonic

import rclpy
from rclpy.node import Node
from rich.console import Console

from seat_gear_dynamics.bench.profiles import profile
from seat_gear_dynamics.commands.children import Child
from seat_gear_dynamics.commands.dashboard_run import Dashboard, Settings
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.commands.listener import Listener
from seat_gear_dynamics.commands.watching import Told, told, watch
from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.band_source import band_source
from seat_gear_dynamics.sensing import map_path
from seat_gear_dynamics.views.live_screen import screen_on
from seat_gear_dynamics.views.live_state import LiveState

_START_PATIENCE = 120.0  # s; the first start on a machine compiles the model
_SPIN = 0.1  # s to wait for a message at most


class BenchRun:
    """Simulator, monitor and recorder as three processes over DDS, and this process looking on."""

    def __init__(
        self,
        *,
        duration: float | None,
        output: Path | None,
        profile_name: str,
        system: str | None,
        seed: int,
        quiet: bool,
        dashboard: int | None = None,
        chart: str | None = None,
    ) -> None:
        if duration is not None and not 0 < duration < float("inf"):
            raise CommandError(f"--duration is {duration!r} s, expected more than 0.")
        profile(profile_name)  # an unknown name is refused before anything starts
        train = load_train(system)
        self.output = (output or Path(f"seat_gear_log_{datetime.now():%Y%m%d_%H%M%S}")).absolute()
        if self.output.exists():
            raise CommandError(f"The log directory {self.output} exists already; choose another --output or move it.")
        self._duration = duration
        self._profile, self._seed = profile_name, seed
        self._system = str(Path(system).absolute()) if system else ""
        self.chart = None if chart is None else map_path(chart).absolute()
        """The regime map that the monitor goes by; None: the published bands."""
        band_source(train, self.chart, None)  # a map that is none is refused before anything starts
        self._console = Console(quiet=quiet)
        shown = Settings(port=dashboard or 0, system=system, map=self.chart)
        self._dashboard = None if dashboard is None else Dashboard(shown)
        self._told = Told()
        self._children: list[Child] = []
        self._state = LiveState(
            title=f"seat-gear bench: {profile_name}",
            bands_rpm=tuple((band.low / RPM, band.high / RPM) for band in train.bands),
            covered_rpm=max(train.model.covered_speed / RPM, 2200.0),
            load_scale=train.model.load_scale,
            duration=duration,
        )

    def run(self) -> str:
        """Run to the end; return how it ended: `duration` or `interrupted`. Raises CommandError if a process fails."""
        from rclpy.signals import SignalHandlerOptions

        with told() as self._told:
            rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
            node = Listener(self._state)
            try:
                with self._shown(), _folder_for_words() as words:
                    try:
                        self._start(node, words)
                        self._watch(node)
                    finally:
                        self._end()
            finally:
                node.destroy_node()
                rclpy.try_shutdown()
            return "interrupted" if self._told.to_end else "duration"

    @contextmanager
    def _shown(self) -> Iterator[None]:
        """Serve the dashboard, where it was asked for, as long as the run lasts."""
        if self._dashboard is None:
            yield
            return
        with self._dashboard:
            self._console.print(f"dashboard: {self._dashboard.url}")
            yield

    def _start(self, node: Listener, words: Path) -> None:
        """Start recorder and monitor, then, once the log hears every topic, the simulator."""
        self._child("recorder", words, output=str(self.output), system=self._system)
        self._child("monitor", words, system=self._system, map=str(self.chart or ""))
        self._console.print("starting the recorder and the monitor (the first start compiles the model)…")
        self._wait(node, lambda: {"bench_recorder", "gear_monitor"} <= node.heard, "recorder and monitor to report")
        self._child("simulator", words, profile=self._profile, seed=str(self._seed))
        self._wait(node, lambda: _heard_by_recorder(node), "the recorder to hear every topic")

    def _child(self, name: str, words: Path, **parameters: str) -> None:
        given = [f"{key}:={value}" for key, value in parameters.items() if value]
        flags = [part for parameter in given for part in ("-p", parameter)]
        self._children.append(Child(name, ["--ros-args", *flags], words / f"{name}.txt"))

    def _wait(self, node: Node, reached: Callable[[], bool], what: str) -> None:
        begin = monotonic()
        while not reached() and not self._told.to_end:
            rclpy.spin_once(node, timeout_sec=_SPIN)
            self._check()
            if monotonic() - begin > _START_PATIENCE:
                raise CommandError(f"Waited {_START_PATIENCE:.0f} s for {what}; look at the network and ROS_DOMAIN_ID.")

    def _watch(self, node: Listener) -> None:
        with screen_on(self._console) as screen:
            watch(node, screen, self._check, self._going_on)

    def _going_on(self, elapsed: float) -> bool:
        return not self._told.to_end and (self._duration is None or elapsed < self._duration)

    def _check(self) -> None:
        for child in self._children:
            child.check()

    def _end(self) -> None:
        """End the source first and the recorder last, so that the log holds everything."""
        order = {"simulator": 0, "monitor": 1, "recorder": 2}
        for child in sorted(self._children, key=lambda child: order[child.name]):
            child.end()


def _heard_by_recorder(node: Node) -> bool:
    """Return whether each declared topic has a subscription of the recorder and a publisher."""
    for topic in topics.TOPICS:
        publishers = node.count_publishers(topic.name)
        if publishers == 0 or node.count_subscribers(topic.name) == 0:
            return False
    return True


@contextmanager
def _folder_for_words() -> Iterator[Path]:
    """Give a folder for what the processes say; it stays where the run fails, for its error names a file in it."""
    folder = Path(tempfile.mkdtemp(prefix="seat_gear_bench_"))
    yield folder
    shutil.rmtree(folder, ignore_errors=True)
