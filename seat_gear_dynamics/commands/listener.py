"""The live view's ears: a node that keeps a LiveState up to date from the bench's topics."""

from math import isfinite
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.nodes.messages import MESHES
from seat_gear_dynamics.views.live_state import LiveState, MeshStatistics

_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)  # only the newest matters to the eye
_ALL = QoSProfile(depth=10)


class Listener(Node):
    """Subscribes to inputs, forces, warning and diagnostics; never publishes."""

    def __init__(self, state: LiveState, *, fed: bool = False) -> None:
        """Take speed and load from the inputs, or where `fed` from what the monitor fed its model, whatever its input.

        The first are there before a monitor is; the second are there for joint states, too.
        """
        super().__init__("bench_view")
        self.state = state
        if fed:
            self.create_subscription(JointState, topics.MODEL_INPUT.name, self._on_fed, _QOS)
        else:
            self.create_subscription(Float64, topics.MOTOR_SPEED.name, self._on_speed, _QOS)
            self.create_subscription(Float64, topics.LOAD_TORQUE.name, self._on_load, _QOS)
        self.create_subscription(JointState, topics.MESH_FORCE.name, self._on_force, _QOS)
        self.create_subscription(DiagnosticStatus, topics.CHAOS_WARNING.name, self._on_warning, _ALL)
        self.create_subscription(Bool, topics.IN_FORBIDDEN_BAND.name, self._on_trip, _ALL)
        self.create_subscription(DiagnosticArray, topics.DIAGNOSTICS.name, self._on_diagnostics, _ALL)
        self.heard: set[str] = set()
        """Names of the nodes whose diagnostics came: they are up."""

    def _on_speed(self, message: Any) -> None:
        self.state.speed_rpm = message.data / RPM if isfinite(message.data) else None

    def _on_load(self, message: Any) -> None:
        self.state.load = message.data if isfinite(message.data) else None

    def _on_fed(self, message: Any) -> None:
        self.state.speed_rpm, self.state.load = message.velocity[0] / RPM, message.effort[0]

    def _on_force(self, message: Any) -> None:
        effort = dict(zip(message.name, message.effort, strict=True))
        for mesh in MESHES:
            values = (effort[f"{mesh}/{name}"] for name in ("mean", "min", "max", "rms"))
            self.state.meshes[mesh] = MeshStatistics(*values)

    def _on_warning(self, message: Any) -> None:
        self.state.level = message.level[0]
        self.state.reason = message.message
        self.state.details = {value.key: value.value for value in message.values}

    def _on_trip(self, message: Any) -> None:
        self.state.in_band = message.data

    def _on_diagnostics(self, message: Any) -> None:
        for status in message.status:
            node, _, part = status.name.partition(": ")
            self.heard.add(node)
            if part == "recording":
                self.state.recorder = {value.key: value.value for value in status.values}
            elif part == "solver":
                self.state.solver = f"model: {status.message}"
