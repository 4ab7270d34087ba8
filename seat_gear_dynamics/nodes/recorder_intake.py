"""How messages reach the recorder: in batches on the bundled runtime, one at a time on rclpy.

This is the one place where the recorder knows which of the two it runs on.
"""

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Protocol

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosidl_runtime_py.utilities import get_message

from seat_gear_dynamics.logs.batch import Batch
from seat_gear_dynamics.logs.chunk_body import compile_packing
from seat_gear_dynamics.runtime.batches import BatchSubscriptions, Publishers, offers_batches

Receive = Callable[[str, bytes, Mapping[str, int]], None]
ReceiveBatch = Callable[[Batch], None]

_POLL = 0.02  # s between two looks into the queues: fifty calls a second cost less than one for each message
_AT_ONCE = 32  # takes in one look, some 500 000 messages: a flood must not keep services and syncs waiting


class Intake(Protocol):
    """Serialized subscriptions by absolute topic name."""

    def subscribe(self, topic: str, kind: str, qos: QoSProfile) -> None:
        """Listen to a topic of a full type, in place of an earlier subscription of that name."""

    def publishers(self) -> Mapping[str, Sequence[Any]]:
        """Return rclpy's endpoint infos of the publishers of each topic that has any, by absolute name."""

    def lost(self) -> Mapping[str, int]:
        """Return how many messages of each topic came and were lost before they could be read."""

    def drain(self, seconds: float) -> bool:
        """Hand over what waits in the queues now, for so many s at most; return whether all of it was."""


def make_intake(node: Node, receive: Receive, receive_batch: ReceiveBatch) -> Intake:
    """Return the intake of a node; which of the two functions it calls is the runtime's matter.

    `receive` gets topic, CDR bytes and rclpy's message info. In a batch log times are when each message came, on the
    system's clock, and publish times the publisher's stamps, 0 without one.
    """
    return BatchIntake(node, receive_batch) if offers_batches(node) else MessageIntake(node, receive)


class BatchIntake:
    """Looks into the queues fifty times a second and hands over what is there in one piece."""

    def __init__(self, node: Node, receive: ReceiveBatch) -> None:
        compile_packing()
        self._receive = receive
        self._batches, self._publishers = BatchSubscriptions(node), Publishers(node)
        self._names: tuple[str, ...] = ()
        self._numbers: dict[str, int] = {}
        self._topic_of = np.empty(0, np.int64)  # number of a subscription -> place in names
        self._past: Counter[str] = Counter()
        node.create_timer(_POLL, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def subscribe(self, topic: str, kind: str, qos: QoSProfile) -> None:
        """Listen to a topic, see `Intake`; what waits for an earlier subscription is handed over first."""
        if topic in self._numbers:
            self._look()
            old = self._numbers[topic]
            self._batches.destroy(old)
            self._past[topic] += self._batches.lost(old)
        else:
            self._names = (*self._names, topic)
        self._numbers[topic] = self._batches.create(get_message(kind), topic, qos)
        self._topic_of = np.append(self._topic_of, self._names.index(topic))

    def publishers(self) -> Mapping[str, Sequence[Any]]:
        """Return the publishers, see `Intake`."""
        return self._publishers.by_topic()

    def lost(self) -> Mapping[str, int]:
        """Return the losses, see `Intake`: all that came and was overwritten, exactly."""
        return {name: self._past[name] + self._batches.lost(number) for name, number in self._numbers.items()}

    def drain(self, seconds: float) -> bool:
        """Hand over what waits, see `Intake`."""
        end = time.monotonic() + seconds
        self._take()
        while not self._batches.complete:
            if time.monotonic() > end:
                return False
            self._take()
        return True

    def _look(self) -> None:
        for _ in range(_AT_ONCE):
            self._take()
            if self._batches.complete:
                return

    def _take(self) -> None:
        taken = self._batches.take()
        if taken is not None:
            topic = self._topic_of[taken.slot]
            self._receive(
                Batch(self._names, topic, taken.offset, taken.size, taken.arrived_ns, taken.published_ns, taken.data)
            )


class MessageIntake:
    """Subscriptions of rclpy, whose callbacks come one message at a time."""

    def __init__(self, node: Node, receive: Receive) -> None:
        self._node, self._receive = node, receive
        self._made: dict[str, Any] = {}
        self._lost: Counter[str] = Counter()

    def subscribe(self, topic: str, kind: str, qos: QoSProfile) -> None:
        """Listen to a topic, see `Intake`; messages of the moment of a change may be missed."""
        receive, lost = self._receive, self._lost

        def callback(data: bytes, info: Mapping[str, int]) -> None:  # rclpy counts a plain function's arguments
            receive(topic, data, info)

        def count_lost(status: Any) -> None:
            lost[topic] += status.total_count_change

        old = self._made.pop(topic, None)
        if old is not None:
            self._node.destroy_subscription(old)
        make = partial(self._node.create_subscription, get_message(kind), topic, callback, qos, raw=True)
        self._made[topic] = make(event_callbacks=SubscriptionEventCallbacks(message_lost=count_lost))

    def publishers(self) -> Mapping[str, Sequence[Any]]:
        """Return the publishers, see `Intake`."""
        names = (name for name, _ in self._node.get_topic_names_and_types())
        found = {name: self._node.get_publishers_info_by_topic(name) for name in names}
        return {name: infos for name, infos in found.items() if infos}

    def lost(self) -> Mapping[str, int]:
        """Return the losses that the middleware reports; Cyclone DDS's queues report none, Fast DDS's gaps do."""
        return self._lost

    def drain(self, seconds: float) -> bool:
        """Hand over what waits, see `Intake`, by rclpy's own way to take a message, which outlives its context."""
        end = time.monotonic() + seconds
        for topic, subscription in self._made.items():
            while (found := _take(subscription)) is not None:
                self._receive(topic, *found)
                if time.monotonic() > end:
                    return False
        return True


def _take(subscription: Any) -> tuple[bytes, Mapping[str, int]] | None:
    with subscription.handle:
        found = subscription.handle.take_message(subscription.msg_type, subscription.raw)
    return found if found is None else (found[0], found[1])
