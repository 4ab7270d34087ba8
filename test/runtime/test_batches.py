"""Messages taken in batches: the same bytes as one at a time, in the order of arrival, and each lost one counted."""

from __future__ import annotations

import struct
import time

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from programs import PATIENCE, PREAMBLE, MakeNode, Run

from seat_gear_dynamics.runtime import qos
from seat_gear_dynamics.runtime.batches import BatchSubscriptions, Publishers, offers_batches
from seat_gear_dynamics.runtime.client_library import serialize_message
from seat_gear_dynamics.runtime.endpoints import Publisher
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.qos import QoSProfile
from seat_gear_dynamics.runtime.wire.counted import Sink, Taken

Float64 = get_message("std_msgs/msg/Float64")
String = get_message("std_msgs/msg/String")


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node()


@pytest.fixture
def batches(node: Node) -> BatchSubscriptions:
    return BatchSubscriptions(node)


def contents(taken: Taken | None) -> list[bytes]:
    assert taken is not None
    return [bytes(taken.data[o : o + n]) for o, n in zip(taken.offset, taken.size, strict=True)]


def numbers(taken: Taken | None) -> list[float]:
    return [] if taken is None else [struct.unpack_from("<d", data, 4)[0] for data in contents(taken)]


def send(publisher: Publisher, *values: float) -> None:
    for value in values:
        publisher.publish(Float64(data=float(value)))


def test_two_topics_come_as_they_were_published_byte_for_byte_with_both_times(
    node: Node, batches: BatchSubscriptions
) -> None:
    profile = QoSProfile(depth=50)
    one, other = batches.create(Float64, "x", profile), batches.create(String, "y", profile)
    x, y = node.create_publisher(Float64, "x", 50), node.create_publisher(String, "y", 50)
    before = time.time_ns()
    sent = [Float64(data=float(k)) if k % 3 else String(data="ä" * k) for k in range(30)]
    for message in sent:
        (x if isinstance(message, Float64) else y).publish(message)
    after = time.time_ns()
    taken = batches.take()
    assert taken is not None
    # DDS sends multiples of four bytes.
    for data, message in zip(contents(taken), sent, strict=True):
        assert data.rstrip(b"\0") == serialize_message(message).rstrip(b"\0")
    assert taken.slot.tolist() == [one if k % 3 else other for k in range(30)]
    assert np.all(np.diff(taken.arrived_ns) >= 0)
    assert np.all(np.diff(taken.published_ns) >= 0)
    assert before <= taken.published_ns[0] <= taken.published_ns[-1] <= after
    # The two clocks of the machine are read one after the other: a step between them would be far more than 0.1 s.
    assert np.all(np.abs(taken.arrived_ns - taken.published_ns) < 100_000_000)
    assert batches.complete
    assert batches.take() is None


def test_what_is_overwritten_before_it_is_taken_is_counted(node: Node, batches: BatchSubscriptions) -> None:
    number = batches.create(Float64, "x", QoSProfile(depth=5))
    publisher = node.create_publisher(Float64, "x", 1000)
    send(publisher, *range(100))
    assert batches.lost(number) == 95, "known before anything is taken"
    assert numbers(batches.take()) == [95.0, 96.0, 97.0, 98.0, 99.0]
    assert batches.lost(number) == 95
    send(publisher, *range(5))
    assert numbers(batches.take()) == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert batches.lost(number) == 95
    batches.destroy(number)
    assert batches.lost(number) == 95
    assert batches.lost(99) == 0


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(1, 7), st.lists(st.one_of(st.none(), st.integers(1, 12)), max_size=25), st.integers(1, 9))
def test_each_message_is_taken_once_or_counted_as_lost(
    make_node: MakeNode, depth: int, steps: list[int | None], rows: int
) -> None:
    node = make_node()
    batches = BatchSubscriptions(node)
    batches._sink = Sink(rows=rows)  # so that a take ends amid a queue
    number = batches.create(Float64, "x", QoSProfile(depth=depth))
    publisher = node.create_publisher(Float64, "x", 1000)
    sent, got = 0, []
    waiting: list[float] = []
    for step in steps:
        if step is None:
            got += numbers(batches.take())
            waiting = waiting[rows:]
        else:
            fresh = [float(k) for k in range(sent, sent + step)]
            send(publisher, *fresh)
            sent += step
            waiting = (waiting + fresh)[-depth:]  # what keep-last means
        assert len(got) + len(waiting) + batches.lost(number) == sent
    while part := numbers(batches.take()):
        got += part
    assert got == sorted(set(got))
    assert got[len(got) - len(waiting) :] == waiting
    assert len(got) + batches.lost(number) == sent
    node.destroy_node()


def test_a_small_sink_is_shared_in_turn(node: Node, batches: BatchSubscriptions) -> None:
    batches._sink = Sink(rows=4)
    flood, quiet = (batches.create(Float64, name, QoSProfile(depth=100)) for name in "xy")
    x, y = (node.create_publisher(Float64, name, 100) for name in "xy")
    send(x, *range(50))
    send(y, 7.0)
    found = []
    for _ in range(3):
        part = batches.take()
        assert part is not None
        found.append(set(part.slot.tolist()))
        assert not batches.complete
    assert quiet in found[0] | found[1], "a topic that floods must not starve the other"
    assert found[2] == {flood}
    while not batches.complete:
        batches.take()
    assert batches.take() is None


def test_a_message_larger_than_the_buffer_makes_it_grow(node: Node, batches: BatchSubscriptions) -> None:
    batches._sink = Sink(size=1000)
    batches.create(String, "x", QoSProfile(depth=10))
    publisher = node.create_publisher(String, "x", 10)
    for count in (10, 5000, 20):
        publisher.publish(String(data="x" * count))
    taken = [data for _ in range(4) if (part := batches.take()) is not None for data in contents(part)]
    assert [data.count(b"x") for data in taken] == [10, 5000, 20]


SENDER = (
    PREAMBLE
    + """
rclpy.init()
node = Node("sender")
publisher = node.create_publisher(Float64, "x", 10_000)
go = []
node.create_subscription(Float64, "go", go.append, 1)
while not go:
    publisher.publish(Float64(data=-1.0))
    rclpy.spin_once(node, timeout_sec=0.05)
for k in range(2000):
    publisher.publish(Float64(data=float(k)))
    if k % 200 == 0:  # so that the system's own buffer, which is not counted here, never runs over
        publisher.wait_for_all_acked()
publisher.wait_for_all_acked()
print("sent")
"""
)


def test_nothing_that_a_process_sent_goes_uncounted(node: Node, batches: BatchSubscriptions, run: Run) -> None:
    number = batches.create(Float64, "x", QoSProfile(depth=50))
    go = node.create_publisher(Float64, "go", 1)
    program = run(SENDER)
    end = time.monotonic() + PATIENCE
    greetings = 0
    while not greetings:
        greetings += len(numbers(batches.take()))
        assert time.monotonic() < end, "nothing came"
    while go.get_subscription_count() == 0:
        assert time.monotonic() < end, "nobody listens"
    send(go, 1.0)
    program.expect("sent")
    last = numbers(batches.take())
    assert last == [float(k) for k in range(1950, 2000)]
    # The greetings between the first and the go are overwritten and counted as well.
    assert batches.lost(number) >= 1950


def test_the_network_sees_the_subscription_as_the_nodes(node: Node, batches: BatchSubscriptions) -> None:
    number = batches.create(Float64, "x", QoSProfile(depth=5))
    (info,) = node.get_subscriptions_info_by_topic("/x")
    assert (info.node_name, info.topic_type) == (node.get_name(), "std_msgs/msg/Float64")
    assert info.topic_type_hash.startswith("RIHS01_")
    batches.destroy(number)
    assert node.count_subscribers("/x") == 0
    batches.create(Float64, "x", QoSProfile(depth=5))
    assert node.count_subscribers("/x") == 1


def test_publishers_are_those_that_one_topic_at_a_time_tells(node: Node) -> None:
    publishers = Publishers(node)
    best_effort = QoSProfile(depth=3, reliability=qos.ReliabilityPolicy.BEST_EFFORT)
    for count in (1, 2):
        made = [node.create_publisher(Float64, "x", best_effort) for _ in range(count)]
        made.append(node.create_publisher(String, "y", 1))
        found = publishers.by_topic()
        assert publishers.by_topic() == found
        for name in ("/x", "/y"):
            one, other = found[name], node.get_publishers_info_by_topic(name)
            assert sorted(map(repr, one)) == sorted(map(repr, other))
        for each in made:
            node.destroy_publisher(each)
        assert "/x" not in publishers.by_topic(), "what has gone is noticed too"


def test_what_cannot_be_is_refused_with_a_sentence(node: Node, batches: BatchSubscriptions) -> None:
    with pytest.raises(ValueError, match="keeps the last messages; set a depth"):
        batches.create(Float64, "x", QoSProfile(history=qos.HistoryPolicy.KEEP_ALL))
    with pytest.raises(TypeError, match="is not a message class"):
        batches.create(float, "x", QoSProfile(depth=1))
    assert batches.take() is None
    assert offers_batches(node)
    assert not offers_batches(object())
