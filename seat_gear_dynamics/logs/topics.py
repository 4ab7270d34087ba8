"""The contract's topic names, types and durability: the only place in the project that spells them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Reliability = Literal["reliable", "best_effort"]
Durability = Literal["volatile", "transient_local"]
History = Literal["keep_last", "keep_all", "system_default", "unknown"]
Direction = Literal["in", "out"]

FLOAT64 = "std_msgs/msg/Float64"
BOOL = "std_msgs/msg/Bool"
JOINT_STATE = "sensor_msgs/msg/JointState"
POINT_CLOUD = "sensor_msgs/msg/PointCloud2"
DIAGNOSTIC_STATUS = "diagnostic_msgs/msg/DiagnosticStatus"
DIAGNOSTIC_ARRAY = "diagnostic_msgs/msg/DiagnosticArray"


@dataclass(frozen=True)
class Qos:
    """The quality of service that a log states for a topic.

    History and depth do not travel with DDS discovery, so a recorder that learns a topic from the network
    knows neither: rosbag2 then writes `unknown` and 0, and so do these defaults.
    """

    reliability: Reliability = "reliable"
    durability: Durability = "volatile"
    history: History = "unknown"
    depth: int = 0


@dataclass(frozen=True)
class Topic:
    """A declared topic: name (relative unless it begins with `/`), type, direction as the monitor sees it."""

    name: str
    type: str
    direction: Direction
    description: str
    durability: Durability = "volatile"
    depth: int = 10

    @property
    def qos(self) -> Qos:
        """The quality of service that the project's own publishers offer for this topic."""
        return Qos(durability=self.durability, history="keep_last", depth=self.depth)

    def absolute(self, namespace: str = "/") -> str:
        """Return the name as it appears on the network for a node in `namespace`, before any remapping."""
        if self.name.startswith("/"):
            return self.name
        return f"{namespace.rstrip('/')}/{self.name}"


MOTOR_SPEED = Topic("motor/speed", FLOAT64, "in", "speed of s1, rad/s, signed")
LOAD_TORQUE = Topic("load/torque", FLOAT64, "in", "load torque T4 on s4, N·m")
JOINT_STATES = Topic("joint_states", JOINT_STATE, "in", "speed and load of one stamped joint (optional input)")
MODEL_INPUT = Topic(
    "gear_monitor/input",
    JOINT_STATE,
    "out",
    "what the model was fed: name s1, velocity in rad/s, effort = load in N·m, stamp = the time used",
)
MODEL_STATE = Topic(
    "gear_monitor/model_state",
    JOINT_STATE,
    "out",
    "all that the model goes on from, for a replay that begins amid a run: names and positions, stamp of its sample",
    durability="transient_local",
    depth=1,
)
MESH_STATE = Topic(
    "gear_monitor/mesh_state",
    JOINT_STATE,
    "out",
    "per mesh: position δ in m, velocity dδ/dt in m/s, effort = mesh force in N",
)
MESH_FORCE = Topic(
    "gear_monitor/mesh_force",
    JOINT_STATE,
    "out",
    "per mesh: mean, min, max and rms of the force over the window, N",
)
POINCARE = Topic("gear_monitor/poincare", POINT_CLOUD, "out", "the last section points of the first mesh")
CHAOS_WARNING = Topic("gear_monitor/chaos_warning", DIAGNOSTIC_STATUS, "out", "the graded warning with its evidence")
IN_FORBIDDEN_BAND = Topic(
    "gear_monitor/in_forbidden_band",
    BOOL,
    "out",
    "the plain trip signal for bench automation",
    durability="transient_local",
    depth=1,
)
DIAGNOSTICS = Topic("/diagnostics", DIAGNOSTIC_ARRAY, "out", "health of inputs, solver, warning and recorder")
PARAMETER_EVENTS = Topic(
    "/parameter_events",
    "rcl_interfaces/msg/ParameterEvent",
    "out",
    "changes of every node's parameters, by which a replay follows the monitor's thresholds",
    depth=1000,
)
"""ROS 2's own: no topic of the contract, but recorded with it."""

TOPICS: tuple[Topic, ...] = (
    MOTOR_SPEED,
    LOAD_TORQUE,
    JOINT_STATES,
    MODEL_INPUT,
    MODEL_STATE,
    MESH_STATE,
    MESH_FORCE,
    POINCARE,
    CHAOS_WARNING,
    IN_FORBIDDEN_BAND,
    DIAGNOSTICS,
)

ORIGIN_NAMES = ("origin/s", "origin/ns")
"""In a message of MODEL_STATE, behind the sensor's own names: the stamp of t = 0, whole seconds and ns."""
