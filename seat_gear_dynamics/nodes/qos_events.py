"""What DDS says of the topics themselves: deadlines missed, liveliness lost, QoS that does not fit, messages lost."""

from collections import Counter
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import qos_policy_name_from_kind

from seat_gear_dynamics.nodes.diagnostics import Status
from seat_gear_dynamics.sensing import Level

_WORDS = {
    "deadline": "missed its deadline",
    "liveliness": "a publisher lost its liveliness",
    "incompatible": "an endpoint's QoS does not fit",
    "lost": "lost messages",
}


class QosEvents:
    """Counts the events of a node's topics, and says as a diagnostic task what is new."""

    name = "qos"

    def __init__(self, tell: Callable[[str], None]) -> None:
        """`tell` is told at once of each event, in a sentence; it should not let a flood through."""
        self._tell = tell
        self._counts: Counter[tuple[str, str]] = Counter()
        self._policies: dict[str, str] = {}
        self._reported: Counter[tuple[str, str]] = Counter()
        self._publishers: dict[str, int] = {}

    def publishers(self, topic: str) -> int:
        """Return how many publishers of a subscribed topic are matched now."""
        return self._publishers.get(topic, 0)

    def of_subscription(self, topic: str) -> SubscriptionEventCallbacks:
        """Return the callbacks for a subscription of `topic`."""
        return SubscriptionEventCallbacks(
            deadline=lambda status: self._note(topic, "deadline", status.total_count_change),
            liveliness=lambda status: self._note(topic, "liveliness", max(status.not_alive_count_change, 0)),
            incompatible_qos=lambda status: self._misfit(topic, status),
            message_lost=lambda status: self._note(topic, "lost", status.total_count_change),
            matched=lambda status: self._matched(topic, status),
        )

    def of_publisher(self, topic: str) -> PublisherEventCallbacks:
        """Return the callbacks for a publisher of `topic`."""
        return PublisherEventCallbacks(
            deadline=lambda status: self._note(topic, "deadline", status.total_count_change),
            liveliness=lambda status: self._note(topic, "liveliness", status.total_count_change),
            incompatible_qos=lambda status: self._misfit(topic, status),
        )

    def run(self, status: Status) -> None:
        """WARN for what came since the last report, naming topics; the values are the counts so far."""
        fresh = self._counts - self._reported
        self._reported = self._counts.copy()
        values = {f"{topic}, {_WORDS[kind]}": count for (topic, kind), count in sorted(self._counts.items())}
        status.say(Level.OK, "no event", {**values, **{f"{t}, policy": p for t, p in self._policies.items()}})
        for (topic, kind), count in sorted(fresh.items()):
            status.say(Level.WARN, f"{self._sentence(topic, kind)} ({count} new)")

    def _matched(self, topic: str, status: Any) -> None:
        self._publishers[topic] = status.current_count

    def _misfit(self, topic: str, status: Any) -> None:
        self._policies[topic] = qos_policy_name_from_kind(status.last_policy_kind).lower()
        self._note(topic, "incompatible", status.total_count_change)

    def _note(self, topic: str, kind: str, count: int) -> None:
        if count > 0:
            self._counts[topic, kind] += count
            self._tell(self._sentence(topic, kind))

    def _sentence(self, topic: str, kind: str) -> str:
        policy = f": {self._policies[topic]}" if kind == "incompatible" else ""
        return f"{topic}: {_WORDS[kind]}{policy}"
