"""The monitor node: measured speed and load in; forces, section, warning and trip signal out."""

from collections.abc import Sequence
from time import perf_counter
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Bool, Header
from std_srvs.srv import Trigger

from seat_gear_dynamics.gears import DescriptionError, GearTrain, load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.intake import Intake
from seat_gear_dynamics.nodes.monitor_health import SolverHealth
from seat_gear_dynamics.nodes.monitor_state import StateTicker, model_state
from seat_gear_dynamics.nodes.parameters import Parameter, declare
from seat_gear_dynamics.nodes.process import StartError, run
from seat_gear_dynamics.sensing import AlarmSettings, Change, RejectedSampleError, Session, warm_up

NAME = "gear_monitor"

PARAMETERS = (
    Parameter("system", "", "system description (YAML file); empty: the packaged height adjuster"),
    Parameter("input", "topics", "where speed and load come from: topics, or joint_states"),
    Parameter("joint", "seat_height", "joint whose velocity and effort are speed and load, with input joint_states"),
    Parameter("publish_rate", 50.0, "mesh state and force, Hz", 1.0, 1000.0),
    Parameter("warning_rate", 10.0, "warning, trip signal and section when nothing changes, Hz", 1.0, 100.0),
    Parameter("input_timeout", 0.5, "silence of the speed after which the warning is STALE, s", 0.05, 60.0),
    Parameter("load_timeout", 2.0, "silence of the load after which the warning is STALE, s", 0.05, 600.0),
    Parameter("margin_rpm", 40.0, "WARN when closer to a forbidden band than this, r/min", 0.0, 1000.0),
    Parameter("horizon", 1.0, "WARN when the acceleration reaches a band within this time, s", 0.0, 60.0),
    Parameter("hysteresis_rpm", 4.0, "a band is left only when this far outside, r/min", 0.0, 100.0),
    Parameter("debounce", 0.03, "time a worse level has to last, s", 0.0, 10.0),
    Parameter("hold", 0.3, "time a better level has to last, s", 0.0, 60.0),
    Parameter("state_period", 1.0, "time between two messages of the model's state, s", 0.1, 600.0),
    Parameter("section_points", 256, "section points kept and published", 1, 10000),
)

_LATCHED_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_OUTPUT_QOS = QoSProfile(depth=10)


class Monitor(Node):
    """Feeds a session and publishes what it says; decides nothing itself."""

    def __init__(self) -> None:
        super().__init__(NAME)
        self._settings = declare(self, PARAMETERS)
        self._session = self._make_session(self._load())
        self._health = SolverHealth(self._settings["publish_rate"])
        self._state_ticker = StateTicker(self._settings["state_period"])
        self._forces_due = False
        self._intake = Intake(self, self._settings, self._feed)
        self._publish_on()
        self._timers_on()
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.get_logger().info("ready")

    def _load(self) -> GearTrain:
        try:
            return load_train(self._settings["system"] or None)
        except DescriptionError as error:
            raise StartError(str(error)) from error

    def _make_session(self, train: GearTrain) -> Session:
        get = self._settings.__getitem__
        alarm = AlarmSettings(
            margin=get("margin_rpm") * RPM,
            horizon=get("horizon"),
            hysteresis=get("hysteresis_rpm") * RPM,
            debounce=get("debounce"),
            hold=get("hold"),
        )
        session = Session(train, settings=alarm, max_gap=get("input_timeout"), section_points=get("section_points"))
        self.get_logger().info("compiling the gear model for this machine (seconds once, then cached)")
        warm_up(train)
        return session

    def _publish_on(self) -> None:
        self._input = self.create_publisher(JointState, topics.MODEL_INPUT.name, _OUTPUT_QOS)
        self._model_state = self.create_publisher(JointState, topics.MODEL_STATE.name, _LATCHED_QOS)
        self._mesh_state = self.create_publisher(JointState, topics.MESH_STATE.name, _OUTPUT_QOS)
        self._mesh_force = self.create_publisher(JointState, topics.MESH_FORCE.name, _OUTPUT_QOS)
        self._poincare = self.create_publisher(PointCloud2, topics.POINCARE.name, _OUTPUT_QOS)
        self._warning = self.create_publisher(DiagnosticStatus, topics.CHAOS_WARNING.name, _OUTPUT_QOS)
        self._trip = self.create_publisher(Bool, topics.IN_FORBIDDEN_BAND.name, _LATCHED_QOS)
        self._diagnostics = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS.name, _OUTPUT_QOS)
        self._publish_warning()

    def _timers_on(self) -> None:
        self.create_timer(1.0 / self._settings["publish_rate"], self._on_publish)
        self.create_timer(1.0 / self._settings["warning_rate"], self._on_warning)
        self.create_timer(1.0, self._on_diagnostics)

    def _feed(self, stamp_ns: int, t: float, speed: float, load: float) -> None:
        """Feed one sample; what it changes in the warning goes out at once, without waiting for a timer."""
        begin = perf_counter()
        try:
            change: Change = self._session.feed(t, speed, load)
        except RejectedSampleError as error:
            self.get_logger().warning(f"sample refused: {error}", throttle_duration_sec=5.0)
            return
        self._stamp_ns = stamp_ns
        self._health.fed(perf_counter() - begin, change.reading)
        if change.changed:
            self._publish_warning()
        self._input.publish(messages.model_input(stamp_ns, speed, load))
        self._publish_forces()
        if change.reading.event not in ("running", "started"):
            self.get_logger().warning(f"the model restarted: {change.reading.event}", throttle_duration_sec=5.0)

    def _on_publish(self) -> None:
        self._health.published(self.get_clock().now().nanoseconds)
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
        self._mesh_force.publish(messages.mesh_force(self._stamp_ns, windows))
        self._mesh_state.publish(messages.mesh_state(self._stamp_ns, reading.contacts))
        if self._state_ticker.due(self._stamp_ns):
            self._model_state.publish(model_state(self._stamp_ns, self._intake.origin_ns, self._session))

    def _on_warning(self) -> None:
        silence = self._intake.silence()
        if silence is not None:
            self._session.silence(silence)
        self._publish_warning()
        if self._session.reading is not None:
            self._poincare.publish(messages.poincare(self._stamp_ns, self._session.section, self._intake.origin_ns))

    def _publish_warning(self) -> None:
        verdict = self._session.verdict
        self._trip.publish(Bool(data=verdict.in_band))
        name = f"{self.get_name()}: chaos warning"
        self._warning.publish(messages.chaos_warning(name, verdict, self._session.reading))

    def _on_diagnostics(self) -> None:
        now = self.get_clock().now().nanoseconds
        name, session = self.get_name(), self._session
        level, text, values = self._intake.report(session.sensor.counts)
        statuses = [
            messages.status(level, f"{name}: input", text, values),
            messages.status(*self._health.report(f"{name}: solver", session)),
            messages.chaos_warning(f"{name}: warning", session.verdict, session.reading),
        ]
        self._diagnostics.publish(DiagnosticArray(header=Header(stamp=messages.stamp(now)), status=statuses))

    def _on_reset(self, request: Any, response: Any) -> Any:
        self._session.reset()
        response.success, response.message = True, "the model restarts with the next sample"
        return response


def main(args: Sequence[str] | None = None) -> int:
    """Run the monitor; returns its exit code."""
    return run(Monitor, args)


if __name__ == "__main__":
    raise SystemExit(main())
