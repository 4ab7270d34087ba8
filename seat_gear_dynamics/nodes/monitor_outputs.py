"""The monitor's publishers: which message goes where, silent while the node is not active."""

from collections.abc import Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from numpy import float64
from numpy.typing import NDArray
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Bool, Header

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.qos_events import QosEvents
from seat_gear_dynamics.sensing import Accepted, Contact, ForceWindow, Verdict

TRIP_DEADLINE = 2.0
"""s between two trip signals that the publisher promises: a subscriber may ask to be told when they cease."""
_KINDS = {
    topics.JOINT_STATE: JointState,
    topics.POINT_CLOUD: PointCloud2,
    topics.DIAGNOSTIC_STATUS: DiagnosticStatus,
    topics.DIAGNOSTIC_ARRAY: DiagnosticArray,
    topics.BOOL: Bool,
}
_TRIP = {tripped: serialize_message(Bool(data=tripped)) for tripped in (False, True)}


class Outputs:
    """Publishes what the monitor says; `name` is the node's in the statuses."""

    def __init__(self, node: LifecycleNode, name: str, events: QosEvents) -> None:
        self._node, self._events, self._name = node, events, name
        self._made: list[Any] = []
        self._trip = self._publisher(topics.IN_FORBIDDEN_BAND, TRIP_DEADLINE)
        self._warning = self._publisher(topics.CHAOS_WARNING)
        self._input = self._publisher(topics.MODEL_INPUT)
        self._mesh_state = self._publisher(topics.MESH_STATE)
        self._mesh_force = self._publisher(topics.MESH_FORCE)
        self._poincare = self._publisher(topics.POINCARE)
        self._model_state = self._publisher(topics.MODEL_STATE)
        self._diagnostics = self._publisher(topics.DIAGNOSTICS)

    def _publisher(self, topic: topics.Topic, deadline: float | None = None) -> Any:
        qos = QoSProfile(depth=topic.depth)
        if topic.durability == "transient_local":
            qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
        if deadline is not None:
            qos.deadline = Duration(nanoseconds=int(deadline * 1e9))
        callbacks = self._events.of_publisher(topic.name)
        made = self._node.create_lifecycle_publisher(_KINDS[topic.type], topic.name, qos, event_callbacks=callbacks)
        self._made.append(made)
        return made

    def warn(self, verdict: Verdict, sample: Accepted | None) -> None:
        """Publish a verdict: the trip signal first, which has been encoded before, for whoever acts on it."""
        self.trip(verdict.in_band)
        self.verdict(verdict, sample)

    def verdict(self, verdict: Verdict, sample: Accepted | None) -> None:
        """Publish the warning alone; `sample` is the last that was judged."""
        self._warning.publish(messages.chaos_warning(f"{self._name}: chaos warning", verdict, sample))

    def trip(self, tripped: bool) -> None:
        """Publish the trip signal."""
        self._trip.publish(_TRIP[tripped])

    def fed(self, stamp_ns: int, speed: float, load: float) -> None:
        """Publish what the model was fed."""
        self._input.publish(messages.model_input(stamp_ns, speed, load))

    def forces(self, stamp_ns: int, windows: Sequence[ForceWindow], contacts: Sequence[Contact]) -> None:
        """Publish both meshes' forces over a window, and their state now."""
        self._mesh_force.publish(messages.mesh_force(stamp_ns, windows))
        self._mesh_state.publish(messages.mesh_state(stamp_ns, contacts))

    def section(self, stamp_ns: int, section: NDArray[float64], origin_ns: int) -> None:
        """Publish the last section points."""
        self._poincare.publish(messages.poincare(stamp_ns, section, origin_ns))

    def state(self, message: JointState) -> None:
        """Publish the model's whole state."""
        self._model_state.publish(message)

    def diagnostics(self, now_ns: int, statuses: list[DiagnosticStatus]) -> None:
        """Publish the health of everything."""
        self._diagnostics.publish(DiagnosticArray(header=Header(stamp=messages.stamp(now_ns)), status=statuses))

    def close(self) -> None:
        """Leave the topics; latched messages go too."""
        for publisher in self._made:
            self._node.destroy_lifecycle_publisher(publisher)
        self._made.clear()
