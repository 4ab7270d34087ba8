"""QoS events between programs: what each one says, and when; DDS itself reports them."""

from __future__ import annotations

import signal
from functools import partial
from typing import Any

import pytest
from programs import PREAMBLE, MakeNode, Program, Run, SpinUntil

from seat_gear_dynamics.runtime import events, qos
from seat_gear_dynamics.runtime.events import SubscriptionEventCallbacks
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.time import Duration

Float64 = get_message("std_msgs/msg/Float64")

# A publisher that tells its own events; the profile is the first argument, on its standard input each line is a count
# of messages to send at once.
TELLER = (
    PREAMBLE
    + """
import sys, threading
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy, qos_policy_name_from_kind
rclpy.init(args=[])
node = Node("teller")
callbacks = PublisherEventCallbacks(
    deadline=lambda info: print("deadline", info.total_count, info.total_count_change),
    liveliness=lambda info: print("liveliness", info.total_count, info.total_count_change),
    incompatible_qos=lambda info: print("incompatible", qos_policy_name_from_kind(info.last_policy_kind)),
    matched=lambda info: print("matched", info.current_count, info.current_count_change, info.total_count),
)
publisher = node.create_publisher(Float64, "x", eval(sys.argv[1]), event_callbacks=callbacks)
node.create_timer(0.05, lambda: publisher.publish(Float64(data=1.0)) if "talk" in sys.argv else None)
print("up")
rclpy.spin(node)
"""
)

DEADLINE = "QoSProfile(depth=1, deadline=Duration(nanoseconds=100_000_000))"


@pytest.fixture
def node(make_node: MakeNode, executor: Any) -> Node:
    made = make_node("listener")
    executor.add_node(made)
    return made


def listen(node: Node, profile: qos.QoSProfile, **callbacks: Any) -> list[Any]:
    """Subscribe to the teller; return the list its messages go to."""
    got: list[Any] = []
    node.create_subscription(Float64, "x", got.append, profile, event_callbacks=SubscriptionEventCallbacks(**callbacks))
    return got


def teller(run: Run, profile: str, *words: str) -> Program:
    program = run(TELLER, profile, *words)
    program.expect("up")
    return program


@pytest.mark.parametrize(
    ("offered", "asked", "policy"),
    [
        ("reliability=ReliabilityPolicy.BEST_EFFORT", {}, "RELIABILITY"),
        ("", {"durability": qos.DurabilityPolicy.TRANSIENT_LOCAL}, "DURABILITY"),
        ("deadline=Duration(seconds=2)", {"deadline": Duration(seconds=1)}, "DEADLINE"),
        ("", {"liveliness": qos.LivelinessPolicy.MANUAL_BY_TOPIC}, "LIVELINESS"),
        ("", {"liveliness_lease_duration": Duration(seconds=1)}, "LIVELINESS"),
    ],
)
def test_both_ends_are_told_what_does_not_fit(
    run: Run, node: Node, spin_until: SpinUntil, offered: str, asked: dict[str, Any], policy: str
) -> None:
    told: list[Any] = []
    got = listen(node, qos.QoSProfile(depth=1, **asked), incompatible_qos=told.append)
    program = teller(run, f"QoSProfile(depth=1, {offered})", "talk")
    assert program.expect("incompatible") == f"incompatible {policy}"
    spin_until(lambda: told)
    assert qos.qos_policy_name_from_kind(told[0].last_policy_kind) == policy
    assert (told[0].total_count, told[0].total_count_change) == (1, 1)
    assert not got
    assert not any("matched" in line for line in program.lines)


def test_both_ends_are_told_of_a_missed_deadline(run: Run, node: Node, spin_until: SpinUntil) -> None:
    missed: list[Any] = []
    profile = qos.QoSProfile(depth=1, deadline=Duration(nanoseconds=100_000_000))
    got = listen(node, profile, deadline=missed.append)
    program = teller(run, DEADLINE, "talk")
    spin_until(lambda: got)
    # It hangs, as a driver in trouble does: it is still there, and says nothing.
    program.process.send_signal(signal.SIGSTOP)
    missed.clear()
    spin_until(lambda: len(missed) >= 2)
    assert all(info.total_count_change >= 1 for info in missed)
    assert missed[1].total_count == missed[0].total_count + missed[1].total_count_change
    program.process.send_signal(signal.SIGCONT)
    # Awake again it finds that its own offer was not kept.
    assert int(program.expect("deadline").split()[1]) >= 1


def test_a_killed_publisher_is_not_alive(run: Run, node: Node, spin_until: SpinUntil) -> None:
    changes: list[Any] = []
    lease = "QoSProfile(depth=1, liveliness_lease_duration=Duration(seconds=1))"
    profile = qos.QoSProfile(depth=1, liveliness_lease_duration=Duration(seconds=1))
    got = listen(node, profile, liveliness=changes.append)
    program = teller(run, lease, "talk")
    spin_until(lambda: got and changes)
    assert (changes[0].alive_count, changes[0].alive_count_change, changes[0].not_alive_count) == (1, 1, 0)
    changes.clear()
    program.stop(signal.SIGKILL)
    spin_until(lambda: changes)
    assert (changes[0].alive_count, changes[0].alive_count_change) == (0, -1)
    assert (changes[0].not_alive_count, changes[0].not_alive_count_change) == (1, 1)


def test_a_publisher_that_does_not_assert_itself_loses_its_liveliness(run: Run) -> None:
    lease = "liveliness_lease_duration=Duration(nanoseconds=200_000_000)"
    silent = teller(run, f"QoSProfile(depth=1, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, {lease})")
    assert silent.expect("liveliness") == "liveliness 1 1"


def test_matches_come_and_go(run: Run, node: Node, spin_until: SpinUntil) -> None:
    matches: list[Any] = []
    listen(node, qos.QoSProfile(depth=1), matched=matches.append)
    first = teller(run, "QoSProfile(depth=1)")
    assert first.expect("matched") == "matched 1 1 1"
    spin_until(lambda: matches)
    second = teller(run, "QoSProfile(depth=1)")
    spin_until(lambda: matches[-1].current_count == 2)
    second.stop()
    first.stop()
    spin_until(lambda: matches[-1].current_count == 0)
    assert matches[-1].total_count == 2
    assert sum(info.current_count_change for info in matches) == 0


def test_what_dds_counts_as_lost_is_told(domain_id: int) -> None:
    # Cyclone counts a sample as lost when its reader refuses it, here for coming after a younger one. It does not count
    # one that the network dropped, or that a younger one pushed out of the history (see docs/runtime.md).
    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    from seat_gear_dynamics.runtime.wire.types import topic_struct

    ordered = Qos(Policy.DestinationOrder.BySourceTimestamp, Policy.Reliability.Reliable(10**9))
    participant = DomainParticipant(domain_id)
    topic = Topic(participant, "rt/x", topic_struct("std_msgs/msg/Float64"), qos=ordered)
    reader, writer = DataReader(participant, topic, qos=ordered), DataWriter(participant, topic, qos=ordered)
    told: list[Any] = []
    handler = events.EventHandler(
        callback_group=None,
        callback={"message_lost": told.append},
        event_type=events._SUBSCRIPTION,
        parent_impl=reader,
    )
    for seconds in (20, 10, 10):
        writer.write(topic.data_type(data=1.0), seconds * 10**9)
    work = handler._take_work()
    assert work is not None
    work()
    assert told == [events.QoSMessageLostInfo(total_count=2, total_count_change=2)]
    assert handler._take_work() is None


def test_an_event_may_end_what_another_event_waits_for(node: Node, spin_until: SpinUntil) -> None:
    told: list[int] = []
    ends: list[Any] = []

    def first(number: int, _: Any) -> None:
        told.append(number)
        node.destroy_subscription(ends[1 - number])

    for number in (0, 1):
        callbacks = SubscriptionEventCallbacks(matched=partial(first, number))
        ends.append(node.create_subscription(Float64, "x", lambda _: None, 1, event_callbacks=callbacks))
    # Both are told in one round of the executor, and whichever comes first takes the other away.
    node.create_publisher(Float64, "x", 1)
    spin_until(lambda: told)
    node.create_publisher(Float64, "x", 1)
    spin_until(lambda: len(told) == 2)
    assert told[0] == told[1]
