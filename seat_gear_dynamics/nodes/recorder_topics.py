"""What the recorder listens to: the contract's topics, a list or patterns, followed as publishers come and go."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosidl_runtime_py.utilities import get_message

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.topics import Qos
from seat_gear_dynamics.nodes.process import StartError
from seat_gear_dynamics.nodes.recorder_intake import Intake

AddTopic = Callable[[str, str, Qos], None]

_HIDDEN = re.compile(r"/(.*/)?_")


@dataclass(frozen=True)
class Choice:
    """Which topics to record, by their absolute names."""

    contract: bool
    everything: bool
    names: frozenset[str]
    pattern: re.Pattern[str] | None
    exclude: re.Pattern[str] | None

    def takes(self, name: str) -> bool:
        """Return whether a topic of the network is chosen; hidden ones only by name."""
        if self.exclude is not None and self.exclude.search(name):
            return False
        if name in self.names or (self.contract and name == topics.PARAMETER_EVENTS.name):
            return True
        wanted = self.everything or (self.pattern is not None and self.pattern.search(name) is not None)
        return wanted and _HIDDEN.match(name) is None


def choose(node: Node, chosen: str, pattern: str, exclude: str) -> Choice:
    """Return the choice that three parameters describe; raises StartError for a bad pattern or name.

    `chosen` is `contract`, `all`, or names separated by blanks or commas, of which `contract` may be one.
    """
    words = re.split(r"[\s,]+", chosen.strip()) if chosen.strip() else []
    try:
        names = frozenset(node.resolve_topic_name(word) for word in words if word not in ("contract", "all"))
    except Exception as error:  # rclpy has several classes for names that cannot be
        raise StartError(f"The parameter topics has a name that cannot be ({error}).") from error
    return Choice(
        "contract" in words, "all" in words, names, _compiled("pattern", pattern), _compiled("exclude", exclude)
    )


def _compiled(name: str, text: str) -> re.Pattern[str] | None:
    try:
        return re.compile(text) if text else None
    except re.error as error:
        raise StartError(
            f"The parameter {name} is {text!r}, which is no regular expression ({error}); "
            f"expected one such as '^/cell1/.*'."
        ) from error


class Subscriptions:
    """One serialized subscription for each chosen topic, made when its type is known.

    A topic of the contract, or one first seen on the network, has one type from then on; publishers of another type
    cannot be heard and stand in `problems`. Reliability and durability follow what publishers offer: the strongest
    that all of them meet, and weaker where a weaker publisher joins.
    """

    def __init__(self, node: Node, choice: Choice, depth: int, intake: Intake, add_topic: AddTopic) -> None:
        self.problems: dict[str, str] = {}
        """Absolute topic to what keeps it, or a publisher of it, from being recorded."""
        self._node, self._choice, self._depth = node, choice, depth
        self._intake, self._add_topic = intake, add_topic
        self._types: dict[str, str] = {}
        self._refused: set[str] = set()
        self._qos: dict[str, QoSProfile] = {}
        for topic in topics.TOPICS:
            name = node.resolve_topic_name(topic.name)
            excluded = choice.exclude is not None and choice.exclude.search(name)
            if not excluded and (choice.contract or name in choice.names):
                self._begin(name, topic.type, topic.qos)
        if choice.contract and choice.takes(topics.PARAMETER_EVENTS.name):
            self._begin_parameter_events()

    @property
    def names(self) -> tuple[str, ...]:
        """The topics that are listened to."""
        return tuple(self._types)

    @property
    def missing(self) -> tuple[str, ...]:
        """The topics asked for by name that nobody has published yet, so that their type is not known."""
        return tuple(sorted(self._choice.names - self._types.keys()))

    def look(self) -> None:
        """Follow the network: new topics, weaker publishers, publishers of a wrong type."""
        publishers = self._intake.publishers()
        for name, offers in publishers.items():
            if name not in self._types and name not in self._refused and self._choice.takes(name):
                self._discover(name, offers)
        for name in self._types:
            self._follow(name, publishers.get(name, ()))

    def _discover(self, name: str, publishers: Sequence[Any]) -> None:
        kind = publishers[0].topic_type
        try:
            self._begin(name, kind, _stated(_strongest((p.qos_profile for p in publishers), latched=True)))
            self._node.get_logger().info(f"recording {name} ({kind})")
        except (LogError, LookupError, AttributeError, ValueError, ImportError) as error:
            self._complain(name, f"{name} is not recorded: {error}")

    def _begin(self, name: str, kind: str, qos: Qos) -> None:
        get_message(kind)
        self._add_topic(name, kind, qos)
        self._types[name] = kind
        latched = qos.durability == "transient_local"
        reliability = ReliabilityPolicy.BEST_EFFORT if qos.reliability == "best_effort" else ReliabilityPolicy.RELIABLE
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        self._subscribe(name, QoSProfile(depth=self._depth, reliability=reliability, durability=durability))

    def _begin_parameter_events(self) -> None:
        """Listen to them where that is allowed: the rights of a secured bench may be of the contract alone."""
        topic = topics.PARAMETER_EVENTS
        try:
            self._begin(topic.name, topic.type, topic.qos)
        except Exception as error:  # of the middleware, each runtime has its own class
            self._types.pop(topic.name, None)
            self._refused.add(topic.name)
            self._complain(topic.name, f"{topic.name} is not recorded, so no replay follows thresholds: {error}")

    def _follow(self, name: str, publishers: Sequence[Any]) -> None:
        wrong = sorted({f"{p.topic_type} by {p.node_name}" for p in publishers if p.topic_type != self._types[name]})
        if wrong:
            self._complain(name, f"{name} is published as {', '.join(wrong)}; recorded is {self._types[name]} alone")
        else:
            self.problems.pop(name, None)
        present = self._qos[name]
        offers = [p.qos_profile for p in publishers if p.topic_type == self._types[name]]
        found = _strongest(offers, latched=present.durability == DurabilityPolicy.TRANSIENT_LOCAL)
        weaker = QoSProfile(
            depth=self._depth,
            reliability=max(present.reliability, found.reliability),  # best effort is the greater of the two
            durability=max(present.durability, found.durability),  # volatile is
        )
        if (weaker.reliability, weaker.durability) != (present.reliability, present.durability):
            words = f"{weaker.reliability.name}, {weaker.durability.name}".lower().replace("_", " ")
            self._node.get_logger().info(f"{name} is offered {words}; recording it so")
            self._subscribe(name, weaker)

    def _subscribe(self, name: str, qos: QoSProfile) -> None:
        self._intake.subscribe(name, self._types[name], qos)
        self._qos[name] = qos

    def _complain(self, name: str, text: str) -> None:
        if self.problems.get(name) != text:
            self._node.get_logger().warning(text)
        self.problems[name] = text


def _strongest(offers: Iterable[QoSProfile], *, latched: bool) -> QoSProfile:
    """Return the strongest reliability and durability that all offers meet; durability only where it is `latched`."""
    found = list(offers)
    reliable = all(offer.reliability != ReliabilityPolicy.BEST_EFFORT for offer in found)
    kept = latched and all(offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in found)
    return QoSProfile(
        depth=1,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE,
    )


def _stated(profile: QoSProfile) -> Qos:
    """Return what a log states of a topic learnt from the network, where history and depth do not travel."""
    latched = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    reliable = profile.reliability == ReliabilityPolicy.RELIABLE
    return Qos("reliable" if reliable else "best_effort", "transient_local" if latched else "volatile")
