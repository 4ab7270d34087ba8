"""The monitor's inputs: from topics or joint states to stamped samples, with age, rate and rejects counted."""

from collections import Counter
from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.process import StartError
from seat_gear_dynamics.sensing import Level

Feed = Callable[[int, float, float, float], None]
INPUT_QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Best effort takes reliable publishers as well."""


class Intake:
    """Subscribes to the inputs and hands on (stamp in ns, t in s, speed in rad/s, load in N·m), once per speed.

    A Float64 carries no time, so the moment its publisher wrote it is taken, which a recorder sees alike; with
    use_sim_time it is the simulated time at arrival. A joint state's own stamp is used. Time t runs from the first
    sample. The load is held between its messages.
    """

    def __init__(self, node: Node, settings: Mapping[str, Any], feed: Feed) -> None:
        self._node, self._settings, self._feed = node, settings, feed
        self._joint = str(settings["joint"])
        self._load: float | None = None
        self._arrival: dict[str, int] = {}
        self._origin: int | None = None
        self._rejected: Counter[str] = Counter()
        self._received = 0
        self._reported = (0, node.get_clock().now().nanoseconds)
        self._sim_time = bool(node.get_parameter("use_sim_time").value)
        source = settings["input"]
        if source == "topics":
            node.create_subscription(Float64, topics.MOTOR_SPEED.name, self._on_speed, INPUT_QOS)
            node.create_subscription(Float64, topics.LOAD_TORQUE.name, self._on_load, INPUT_QOS)
        elif source == "joint_states":
            node.create_subscription(JointState, topics.JOINT_STATES.name, self._on_joint_states, INPUT_QOS)
        else:
            raise StartError(f"The parameter input is {source!r}, expected 'topics' or 'joint_states'.")

    @property
    def origin_ns(self) -> int:
        """The stamp of the first sample, which is t = 0 of the session; 0 before it."""
        return self._origin or 0

    def silence(self) -> str | None:
        """Return what input is missing, in words, or None."""
        return self._missing("speed", self._settings["input_timeout"]) or self._missing_load()

    def report(self, counts: Mapping[str, int]) -> tuple[Level, str, dict[str, object]]:
        """Return level, text and values of the input's health; `counts` are the sensor's."""
        now = self._now()
        received, since = self._reported
        self._reported = (self._received, now)
        rate = (self._received - received) / max((now - since) * 1e-9, 1e-9)
        ages = {name: (now - at) * 1e-9 for name, at in self._arrival.items()}
        refused = {key: counts.get(key, 0) for key in ("not finite", "absurd", "duplicate", "late")}
        refused["not finite"] += self._rejected["not finite"]
        values: dict[str, object] = {
            "speed rate (Hz)": rate,
            "speed age (s)": ages.get("speed"),
            "load age (s)": ages.get("load"),
            "samples accepted": counts.get("accepted", 0) + counts.get("started", 0),
            **{f"refused, {key}": count for key, count in refused.items()},
            "refused, joint not named": self._rejected["no joint"],
            "speeds without a load": self._rejected["no load"],
        }
        silence = self.silence()
        if silence is not None:
            return Level.STALE, silence, values
        total = sum(refused.values()) + self._rejected["no joint"]
        if total:
            return Level.WARN, f"{total} samples refused so far", values
        return Level.OK, f"{rate:.0f} samples a second", values

    def _missing(self, name: str, limit: float) -> str | None:
        if name not in self._arrival:
            return f"no {name} received yet"
        age = (self._now() - self._arrival[name]) * 1e-9
        return f"no {name} for more than {limit:g} s" if age > limit else None

    def _missing_load(self) -> str | None:
        return self._missing("load", self._settings["load_timeout"])

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _on_load(self, message: Float64) -> None:
        if not isfinite(message.data):
            self._refuse("not finite", f"the load is {message.data}, expected a finite torque in N·m")
            return
        self._arrival["load"] = self._now()
        self._load = message.data

    def _on_speed(self, message: Float64, info: Mapping[str, int]) -> None:
        self._arrival["speed"] = self._now()
        # Some publishers' middleware leaves the source time out; then the arrival is the best there is.
        stamp = self._now() if self._sim_time else int(info["source_timestamp"]) or self._now()
        self._hand_on(stamp, message.data)

    def _on_joint_states(self, message: JointState) -> None:
        names = list(message.name)
        index = names.index(self._joint) if self._joint in names else -1
        if index < 0 or index >= min(len(message.velocity), len(message.effort)):
            self._refuse("no joint", f"no velocity and effort of joint {self._joint!r} among {names}")
            return
        now = self._now()
        self._arrival.update(speed=now, load=now)
        self._load = message.effort[index]
        self._hand_on(messages.nanoseconds(message.header.stamp), message.velocity[index])

    def _hand_on(self, stamp_ns: int, speed: float) -> None:
        self._received += 1
        if self._load is None or self._missing_load():
            self._rejected["no load"] += 1
            return
        if self._origin is None:
            self._origin = stamp_ns
        self._feed(stamp_ns, (stamp_ns - self._origin) * 1e-9, speed, self._load)

    def _refuse(self, key: str, text: str) -> None:
        self._rejected[key] += 1
        self._node.get_logger().warning(f"input refused: {text}", throttle_duration_sec=5.0)
