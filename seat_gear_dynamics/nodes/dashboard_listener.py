"""The dashboard's ears: a node that hears the bench's topics, and asks the recorder where it is told to."""

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Trigger

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.nodes.dashboard_gathered import Gathered
from seat_gear_dynamics.nodes.recorder import NAME as RECORDER

ACTIONS = ("start", "stop", "snapshot")
"""What the recorder may be asked for."""

# Best effort hears reliable publishers as well, and never holds one up.
_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_EVERY = QoSProfile(depth=200, reliability=ReliabilityPolicy.BEST_EFFORT)


class DashboardListener(Node):
    """Hears inputs, forces, section, warning and diagnostics into `heard`; publishes nothing.

    `clock` gives steady time in s. Callbacks run where the node spins; `heard.take` and `ask_recorder` may be called
    from another thread.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        super().__init__("dashboard")
        self.heard = Gathered(clock)
        self._recorder_services = {name: self.create_client(Trigger, f"{RECORDER}/{name}") for name in ACTIONS}
        heard = self.heard
        subscriptions: tuple[tuple[Any, topics.Topic, Callable[[Any], None], QoSProfile], ...] = (
            (Float64, topics.MOTOR_SPEED, heard.on_speed, _NEWEST),
            (Float64, topics.LOAD_TORQUE, heard.on_load, _NEWEST),
            (JointState, topics.MODEL_INPUT, heard.on_input, _NEWEST),
            (JointState, topics.MESH_STATE, heard.on_state, _EVERY),
            (JointState, topics.MESH_FORCE, heard.on_force, _EVERY),
            (PointCloud2, topics.POINCARE, heard.on_section, _NEWEST),
            (DiagnosticStatus, topics.CHAOS_WARNING, heard.on_warning, _EVERY),
            (Bool, topics.IN_FORBIDDEN_BAND, heard.on_trip, _EVERY),
            (DiagnosticArray, topics.DIAGNOSTICS, heard.on_diagnostics, _EVERY),
        )
        for kind, topic, callback, qos in subscriptions:
            self.create_subscription(kind, topic.name, callback, qos)

    def ask_recorder(self, action: str) -> "Future[tuple[bool, str]]":
        """Ask the recorder for one of ACTIONS; return the future of whether it did, and what it said.

        Raises KeyError for another action. Where no recorder is heard the answer is there at once.
        """
        client, answer = self._recorder_services[action], Future[tuple[bool, str]]()
        if not client.service_is_ready():
            answer.set_result((False, "no recorder answers; start one with: seat-gear record"))
            return answer

        def told(future: Any) -> None:
            if answer.set_running_or_notify_cancel():
                response = future.result()
                answer.set_result((bool(response.success), str(response.message)))

        client.call_async(Trigger.Request()).add_done_callback(told)
        return answer
