"""What a configured monitor has: model, alarm, inputs, outputs and timers; it runs while the node is active."""

from collections.abc import Mapping
from time import perf_counter
from typing import Any

from rclpy.lifecycle import LifecycleNode

from seat_gear_dynamics.gears import DescriptionError, GearTrain, load_train
from seat_gear_dynamics.nodes.diagnostics import Updater
from seat_gear_dynamics.nodes.intake import Intake, Limits
from seat_gear_dynamics.nodes.monitor_health import SolverHealth, WarningHealth
from seat_gear_dynamics.nodes.monitor_outputs import Outputs
from seat_gear_dynamics.nodes.monitor_parameters import alarm_settings
from seat_gear_dynamics.nodes.monitor_state import StateTicker, model_state
from seat_gear_dynamics.nodes.process import StartError
from seat_gear_dynamics.nodes.qos_events import QosEvents
from seat_gear_dynamics.regimes.regime_map import MapError, RegimeMap
from seat_gear_dynamics.sensing import BandSource, MapBands, PublishedBands, Session, map_path, warm_up

_DIAGNOSTICS_PERIOD = 1.0  # s


class Watch:
    """Feeds a session and publishes what it says; decides nothing itself.

    `settings` are followed: what `adopt` takes over may change while it runs.
    """

    def __init__(self, node: LifecycleNode, settings: Mapping[str, Any]) -> None:
        """Load system and map and compile; raises StartError, one sentence, where that cannot be."""
        self._node, self._settings = node, settings
        train = _load(settings["system"])
        bands = _bands(settings["map"], train)
        points, gap = settings["section_points"], settings["input_timeout"]
        self._session = Session(
            train, settings=alarm_settings(settings), bands=bands, max_gap=gap, section_points=points
        )
        warm_up(train, announce=node.get_logger().info)
        name = node.get_fully_qualified_name().lstrip("/")  # in /diagnostics two nodes must not share a name
        events = QosEvents(self._complain)
        limits = Limits(
            max(train.model.covered_speed, bands.covered_speed), train.model.max_speed, train.model.max_load
        )
        self._intake = Intake(node, settings, limits, events, self._feed)
        self._outputs = Outputs(node, name, events)
        self._solver = SolverHealth(self._session, settings["publish_rate"])
        tasks = (self._intake.health, self._solver, WarningHealth(self._session), events)
        self._updater = Updater(name, tasks)
        self._state_ticker = StateTicker(settings["state_period"])
        self._forces_due = False
        self._stamp_ns = 0
        self._timers: list[Any] = []

    def start(self) -> None:
        """Begin to watch, from rest; the node's publishers speak already."""
        self._session.reset()
        self._session.silence("no input yet")
        self._intake.open()
        self._make_timers()
        self._publish_warning()

    def stop(self) -> None:
        """Watch no more: the last word is STALE, and a trip, since from now on nobody would see one."""
        self._intake.shut()
        self._destroy_timers()
        self._session.silence("no input is watched: the monitor was deactivated")
        self._outputs.trip(True)
        self._outputs.verdict(self._session.verdict, self._session.sample)

    def close(self) -> None:
        """Give everything back."""
        self._destroy_timers()
        self._intake.close()
        self._outputs.close()

    def adopt(self) -> None:
        """Take the settings over as they are now; the next sample is judged by them, afresh."""
        alarm = alarm_settings(self._settings)
        if alarm != self._session.alarm.settings:
            self._session.alarm.settings = alarm
            self._session.alarm.reset()
        self._session.sensor.max_gap = self._settings["input_timeout"]
        self._state_ticker.pace(self._settings["state_period"])
        if self._timers:
            self._make_timers()

    def reset(self) -> None:
        """Put the model at rest with the next sample."""
        self._session.reset()

    def stepped_back(self) -> None:
        """Start over: the clock stepped back, and what was timed by it means nothing any more."""
        self._intake.stepped_back()
        self._intake.expect_ticks(self._settings["warning_rate"])
        self._session.reset()
        self._solver.pace(self._settings["publish_rate"])

    def _make_timers(self) -> None:
        self._destroy_timers()
        self._intake.expect_ticks(self._settings["warning_rate"])
        self._solver.pace(self._settings["publish_rate"])
        self._timers = [
            self._node.create_timer(1.0 / self._settings["publish_rate"], self._on_publish),
            self._node.create_timer(1.0 / self._settings["warning_rate"], self._on_warning),
            self._node.create_timer(_DIAGNOSTICS_PERIOD, self._on_diagnostics),
        ]

    def _destroy_timers(self) -> None:
        for timer in self._timers:
            self._node.destroy_timer(timer)
        self._timers = []

    def _feed(self, stamp_ns: int, t: float, speed: float, load: float) -> None:
        """Take one sample; what it changes in the warning goes out at once, before the model moves and any timer."""
        judged = self._session.judge(t, speed, load)
        if judged.changed:
            self._outputs.warn(judged.verdict, judged.sample)
        begin = perf_counter()
        reading = self._session.advance(judged.sample)
        self._solver.fed(perf_counter() - begin, reading)
        self._stamp_ns = stamp_ns
        self._outputs.fed(stamp_ns, speed, load)
        self._publish_forces()
        if reading.event not in ("running", "started"):
            self._complain(f"the model restarted: {reading.event}")

    def _on_publish(self) -> None:
        self._solver.published(self._now())
        self._forces_due = True
        self._publish_forces()

    def _publish_forces(self) -> None:
        """Publish the forces that are due; without a new sample they wait for one, rather than for the next tick."""
        if not self._forces_due:
            return
        windows, reading = self._session.take_windows(), self._session.reading
        if reading is None or windows[0].duration == 0:
            return  # nothing moved since the last message: silence, not an invented value
        self._forces_due = False
        self._outputs.forces(self._stamp_ns, windows, reading.contacts)
        if self._state_ticker.due(self._stamp_ns):
            self._outputs.state(model_state(self._stamp_ns, self._intake.origin_ns, self._session))

    def _on_warning(self) -> None:
        self._intake.tick()
        silence = self._intake.silence()
        if silence is not None:
            self._session.silence(silence)
        self._publish_warning()
        if self._session.reading is not None:
            self._outputs.section(self._stamp_ns, self._session.section, self._intake.origin_ns)

    def _publish_warning(self) -> None:
        self._outputs.warn(self._session.verdict, self._session.sample)

    def _on_diagnostics(self) -> None:
        self._outputs.diagnostics(self._now(), self._updater.update())

    def _complain(self, text: str) -> None:
        self._node.get_logger().warning(text, throttle_duration_sec=5.0)

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)


def _load(system: str) -> GearTrain:
    try:
        return load_train(system or None)
    except DescriptionError as error:
        raise StartError(str(error)) from error


def _bands(name: str, train: GearTrain) -> BandSource:
    """Return the bands of a map file, of the packaged map, or the published ones without a name."""
    if not name:
        return PublishedBands.of(train)
    path = map_path(name)
    try:
        with path.open("rb") as file:
            return MapBands(RegimeMap.load(file, train), train)
    except OSError as error:
        raise StartError(
            f"The map {path} cannot be read ({error.strerror}); expected a file that seat-gear map wrote."
        ) from error
    except MapError as error:
        raise StartError(f"{error} The file is {path}.") from error
