"""The monitor's inputs: from topics or joint states to stamped samples that the model can take."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from math import isfinite
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.diagnostics import Composite
from seat_gear_dynamics.nodes.input_health import InputHealth, SampleHealth, Wakefulness
from seat_gear_dynamics.nodes.qos_events import QosEvents
from seat_gear_dynamics.sensing import RejectedSampleError

Feed = Callable[[int, float, float, float], None]
_TIMEOUTS = {"speed": "input_timeout", "load": "load_timeout"}
_QUEUE = 500  # samples that may wait: a second at 500 Hz in which a busy machine gives the node no time
_UNIT_MISTAKE = 9.55  # r/min in one rad/s
PLAUSIBLE = 1.5
"""Times the covered speed: what is faster is taken for a wrong unit (r/min sent as rad/s are 9.55 times too much)."""


@dataclass(frozen=True)
class Limits:
    """What a machine can mean: speeds in rad/s of s1, load in N·m."""

    covered_speed: float
    max_speed: float
    max_load: float


class Intake:
    """Subscribes to the inputs and hands on (stamp in ns, t in s, speed in rad/s, load in N·m), once per speed.

    A Float64 carries no time, so the moment its publisher wrote it is taken, which a recorder sees alike; with
    use_sim_time it is the simulated time at arrival. A joint state's own stamp is used. Time t runs from the first
    sample. The load is held between its messages. Nothing is handed on before `open` and after `shut`.

    Best effort takes reliable publishers as well.
    """

    def __init__(self, node: Node, settings: Mapping[str, Any], limits: Limits, events: QosEvents, feed: Feed) -> None:
        """`feed` takes a sample and raises RejectedSampleError for one that the model refuses."""
        self._node, self._limits, self._feed = node, limits, feed
        self._joint = str(settings["joint"])
        self._is_open = False
        self._load: float | None = None
        self._origin: int | None = None
        joint_states = settings["input"] == "joint_states"
        names = [topics.JOINT_STATES.name] * 2 if joint_states else [topics.MOTOR_SPEED.name, topics.LOAD_TORQUE.name]
        self._speed_health, self._load_health = (
            InputHealth(
                name,
                topic,
                self._now,
                self._held_up,
                partial(settings.__getitem__, key),
                partial(events.publishers, topic),
            )
            for (name, key), topic in zip(_TIMEOUTS.items(), names, strict=True)
        )
        self._samples = SampleHealth()
        self.expect_ticks(settings["warning_rate"])
        self.health = Composite("input", (self._speed_health, self._load_health, self._samples))
        """The inputs' diagnostic task."""
        qos = _qos(settings["input_deadline"])
        self._subscriptions = [
            node.create_subscription(
                kind, topic.name, callback, qos, event_callbacks=events.of_subscription(topic.name)
            )
            for kind, topic, callback in self._sources(joint_states)
        ]

    def _sources(self, joint_states: bool) -> list[tuple[Any, topics.Topic, Callable[..., None]]]:
        if joint_states:
            return [(JointState, topics.JOINT_STATES, self._on_joint_states)]
        return [(Float64, topics.MOTOR_SPEED, self._on_speed), (Float64, topics.LOAD_TORQUE, self._on_load)]

    @property
    def origin_ns(self) -> int:
        """The stamp of the first sample, which is t = 0 of the session; 0 before it."""
        return self._origin or 0

    def open(self) -> None:
        """Begin to hand on samples."""
        self.forget()
        self._is_open = True

    def shut(self) -> None:
        """Hand on nothing any more."""
        self._is_open = False

    def close(self) -> None:
        """Leave the topics."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions.clear()

    def forget(self) -> None:
        """Forget what came and when; counts are kept."""
        self._load = None
        self._speed_health.forget()
        self._load_health.forget()

    def stepped_back(self) -> None:
        """Forget what came and when, because the clock stepped back, and count it."""
        self.forget()
        self._samples.jumped()

    def expect_ticks(self, rate: float) -> None:
        """Take it that `tick` is called at this rate, Hz, from now on."""
        self._wakefulness = Wakefulness(self._now(), int(1e9 / rate))

    def tick(self) -> None:
        """Note that the node is awake: a hold-up is no silence of the inputs, whose messages may still be unread."""
        self._wakefulness.tick(self._now())

    def silence(self) -> str | None:
        """Return what input is missing, in words, or None."""
        return self._speed_health.silence() or self._load_health.silence()

    def _held_up(self, since: int, now: int) -> int:
        return self._wakefulness.held_up(since, now)

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _time(self, *inputs: InputHealth) -> int | None:
        """Return the time of a message of these inputs; None where it counts for nothing."""
        if not self._is_open:
            return None
        now = self._now()
        if not now and self._node.get_clock().ros_time_is_active:
            self._refuse("no clock", "use_sim_time is set and nothing came on /clock yet", *inputs)
            return None
        for each in inputs:
            each.heard(now)
        return now

    def _on_load(self, message: Float64) -> None:
        now = self._time(self._load_health)
        if now is not None:
            self._take_load(now, message.data)

    def _take_load(self, now: int, load: float) -> None:
        if not isfinite(load):
            self._refuse("not finite", f"the load is {load}, expected a finite torque in N·m", self._load_health)
        elif abs(load) > self._limits.max_load:
            text = f"the load is {load:.6g} N·m, expected at most {self._limits.max_load:g}; check its unit"
            self._refuse("absurd", text, self._load_health)
        else:
            self._load = load
            self._load_health.used(now)

    def _on_speed(self, message: Float64, info: Mapping[str, int]) -> None:
        now = self._time(self._speed_health)
        if now is None:
            return
        if self._node.get_clock().ros_time_is_active:
            self._hand_on(now, now, message.data)
            return
        # Some publishers' middleware leaves the source time out; then the arrival is the best there is.
        stamp = int(info["source_timestamp"]) or now
        self._samples.waited(now - stamp)
        self._hand_on(now, stamp, message.data)

    def _on_joint_states(self, message: JointState) -> None:
        both = (self._speed_health, self._load_health)
        now = self._time(*both)
        if now is None:
            return
        names = list(message.name)
        index = names.index(self._joint) if self._joint in names else -1
        stamp = messages.nanoseconds(message.header.stamp)
        if index < 0 or index >= min(len(message.velocity), len(message.effort)):
            self._refuse("joint not named", f"no velocity and effort of joint {self._joint!r} among {names}", *both)
        elif stamp <= 0:
            text = f"the joint state's stamp is {stamp} ns; its publisher has to fill in header.stamp"
            self._refuse("no stamp", text, *both)
        else:
            self._take_load(now, message.effort[index])
            self._hand_on(now, stamp, message.velocity[index])

    def _hand_on(self, now: int, stamp_ns: int, speed: float) -> None:
        if not isfinite(speed):
            text = f"the speed is {speed}, expected a finite number in rad/s"
            self._refuse("not finite", text, self._speed_health)
            return
        ratio = abs(speed) / self._limits.covered_speed
        if ratio > PLAUSIBLE and abs(speed) <= self._limits.max_speed:
            text = (
                f"the speed is {speed:.6g} rad/s, {ratio:.1f} times the highest covered; expected rad/s "
                f"({speed:.6g} r/min would be {speed / _UNIT_MISTAKE:.4g} rad/s)"
            )
            self._refuse("implausible", text, self._speed_health)
            return
        if self._load is None or self._load_health.silence() is not None:
            self._samples.without_load()
            self._speed_health.used(now)
            return
        if self._origin is None:
            self._origin = stamp_ns
        try:
            self._feed(stamp_ns, (stamp_ns - self._origin) * 1e-9, speed, self._load)
        except RejectedSampleError as error:
            self._refuse(error.reason, str(error), self._speed_health)
            return
        self._speed_health.used(now)
        self._samples.accepted()

    def _refuse(self, reason: str, text: str, *inputs: InputHealth) -> None:
        for each in inputs:
            each.refused(text)
        self._samples.refuse(reason, text)
        self._node.get_logger().warning(f"input refused: {text}", throttle_duration_sec=5.0)


def _qos(deadline: float) -> QoSProfile:
    profile = QoSProfile(depth=_QUEUE, reliability=ReliabilityPolicy.BEST_EFFORT)
    if deadline:
        profile.deadline = Duration(nanoseconds=int(deadline * 1e9))
    return profile
