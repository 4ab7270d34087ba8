"""Publishing and subscribing in one program, QoS, raw bytes, message info, events and the graph."""

from __future__ import annotations

import time
from typing import Any

import pytest
from programs import MakeNode, SpinUntil

from seat_gear_dynamics.runtime import client_library as rclpy
from seat_gear_dynamics.runtime import exceptions, qos
from seat_gear_dynamics.runtime.endpoints import Publisher
from seat_gear_dynamics.runtime.events import (
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)
from seat_gear_dynamics.runtime.graph_queries import NodeNameNonExistentError
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.time import Duration

Float64 = get_message("std_msgs/msg/Float64")
String = get_message("std_msgs/msg/String")
JointState = get_message("sensor_msgs/msg/JointState")


@pytest.fixture
def node(make_node: MakeNode, executor: Any) -> Node:
    made = make_node()
    executor.add_node(made)
    return made


def send(publisher: Publisher, *values: float) -> None:
    for value in values:
        publisher.publish(Float64(data=value))


def test_messages_arrive_in_order(node: Node, spin_until: SpinUntil) -> None:
    got: list[float] = []
    node.create_subscription(Float64, "x", lambda m: got.append(m.data), 100)
    values = [float(n) for n in range(50)]
    send(node.create_publisher(Float64, "x", 100), *values)
    spin_until(lambda: len(got) == 50)
    assert got == values


def test_large_message(node: Node, spin_until: SpinUntil) -> None:
    got: list[Any] = []
    node.create_subscription(JointState, "x", got.append, 1)
    sent = JointState(name=["a", "ü"], position=[0.5] * 100_000)
    node.create_publisher(JointState, "x", 1).publish(sent)
    spin_until(lambda: got)
    assert rclpy.serialize_message(got[0]) == rclpy.serialize_message(sent)


def test_raw_bytes_and_info(node: Node, spin_until: SpinUntil) -> None:
    got: list[tuple[bytes, dict[str, Any]]] = []
    node.create_subscription(String, "x", lambda data, info: got.append((data, info)), 10, raw=True)
    publisher = node.create_publisher(String, "x", 10)
    before = time.time_ns()
    publisher.publish(String(data="abc"))
    publisher.publish(rclpy.serialize_message(String(data="abc")))
    spin_until(lambda: len(got) == 2)
    data, info = got[0]
    assert data == got[1][0] == rclpy.serialize_message(String(data="abc"))
    assert before <= info["source_timestamp"] <= info["received_timestamp"] <= time.time_ns()
    assert set(info) == {
        "source_timestamp",
        "received_timestamp",
        "publication_sequence_number",
        "reception_sequence_number",
    }


def test_keep_last_keeps_the_last(node: Node, spin_until: SpinUntil) -> None:
    got: list[float] = []
    node.create_subscription(Float64, "x", lambda m: got.append(m.data), 3)
    send(node.create_publisher(Float64, "x", 20), *range_of(10))
    spin_until(lambda: 9.0 in got)
    assert got == [7.0, 8.0, 9.0]


def range_of(count: int) -> list[float]:
    return [float(n) for n in range(count)]


def test_transient_local_late_joiner_gets_the_last(node: Node, spin_until: SpinUntil) -> None:
    late = qos.QoSProfile(depth=4, durability=qos.DurabilityPolicy.TRANSIENT_LOCAL)
    send(node.create_publisher(Float64, "x", late), *range_of(10))
    got: list[float] = []
    node.create_subscription(Float64, "x", lambda m: got.append(m.data), late)
    spin_until(lambda: 9.0 in got)
    assert got == [6.0, 7.0, 8.0, 9.0]


def test_mismatch_is_told_and_nothing_arrives(
    node: Node, spin_until: SpinUntil, capsys: pytest.CaptureFixture[str]
) -> None:
    told: list[Any] = []
    best_effort = qos.QoSProfile(depth=1, reliability=qos.ReliabilityPolicy.BEST_EFFORT)
    publisher = node.create_publisher(Float64, "x", best_effort)
    node.create_subscription(
        Float64, "x", pytest.fail, 1, event_callbacks=SubscriptionEventCallbacks(incompatible_qos=told.append)
    )
    send(publisher, 1.0)
    spin_until(lambda: told and "New subscription discovered on topic '/x'" in capsys.readouterr().err)
    assert told[0].last_policy_kind is qos.QoSPolicyKind.RELIABILITY
    assert told[0].total_count == told[0].total_count_change == 1
    assert publisher.get_subscription_count() == 0


def test_matched_and_deadline_events(node: Node, spin_until: SpinUntil) -> None:
    matched: list[Any] = []
    missed: list[Any] = []
    profile = qos.QoSProfile(depth=1, deadline=Duration(nanoseconds=20_000_000))
    publisher = node.create_publisher(
        Float64, "x", profile, event_callbacks=PublisherEventCallbacks(matched=matched.append)
    )
    subscription = node.create_subscription(
        Float64, "x", lambda _: None, profile, event_callbacks=SubscriptionEventCallbacks(deadline=missed.append)
    )
    send(publisher, 1.0)
    spin_until(lambda: missed and matched)
    assert matched[0].current_count == 1
    node.destroy_subscription(subscription)
    spin_until(lambda: matched[-1].current_count == 0)


def test_liveliness_event(node: Node, spin_until: SpinUntil) -> None:
    changes: list[Any] = []
    lease = Duration(nanoseconds=50_000_000)
    profile = qos.QoSProfile(depth=1, liveliness=qos.LivelinessPolicy.MANUAL_BY_TOPIC, liveliness_lease_duration=lease)
    publisher = node.create_publisher(Float64, "x", profile)
    node.create_subscription(
        Float64, "x", lambda _: None, profile, event_callbacks=SubscriptionEventCallbacks(liveliness=changes.append)
    )
    publisher.assert_liveliness()
    spin_until(lambda: any(change.not_alive_count == 1 for change in changes))


def test_event_that_is_left_out_is_a_sentence() -> None:
    with pytest.raises(UnsupportedEventTypeError, match="is not part of the bundled runtime"):
        SubscriptionEventCallbacks(incompatible_type=print)


def test_reliable_messages_are_acknowledged(node: Node) -> None:
    node.create_subscription(Float64, "x", lambda _: None, 10)
    publisher = node.create_publisher(Float64, "x", 10)
    send(publisher, 1.0)
    assert publisher.wait_for_all_acked(Duration(seconds=5))
    assert publisher.get_subscription_count() == 1


def test_wrong_uses_are_refused(node: Node) -> None:
    publisher = node.create_publisher(Float64, "x", 10)
    with pytest.raises(TypeError, match="Expected"):
        publisher.publish(String())
    with pytest.raises(TypeError, match="data is 1 of type int"):
        publisher.publish(Float64(data=1))
    with pytest.raises(TypeError, match="is not a message class"):
        node.create_publisher(int, "x", 10)
    with pytest.raises(TypeError, match="Expected QoSProfile or int"):
        node.create_publisher(Float64, "x", "10")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="greater than or equal to zero"):
        node.create_publisher(Float64, "x", -1)
    with pytest.raises(RuntimeError, match="callback should be"):
        node.create_subscription(Float64, "x", lambda: None, 10)
    with pytest.raises(NotImplementedError, match="BEST_AVAILABLE"):
        node.create_publisher(Float64, "x", qos.QoSProfile(depth=1, reliability=qos.ReliabilityPolicy.BEST_AVAILABLE))
    node.destroy_publisher(publisher)
    with pytest.raises(exceptions.InvalidHandle, match="was destroyed"):
        publisher.publish(Float64())


def test_publishing_after_shutdown_is_refused(node: Node) -> None:
    publisher = node.create_publisher(Float64, "x", 10)
    node.context.shutdown()
    with pytest.raises(exceptions.RCLError, match="context is invalid"):
        publisher.publish(Float64())
    with pytest.raises(exceptions.RCLError, match="already called"):
        node.context.shutdown()


def test_exceptions_leave_spin(node: Node, executor: Any) -> None:
    def fail(_: Any) -> None:
        raise ArithmeticError("from the callback")

    node.create_subscription(Float64, "x", fail, 10)
    send(node.create_publisher(Float64, "x", 10), 1.0)
    with pytest.raises(ArithmeticError, match="from the callback"):
        executor.spin()


def test_coroutine_callbacks_run(node: Node, spin_until: SpinUntil) -> None:
    got: list[float] = []

    async def callback(message: Any) -> None:
        got.append(message.data)

    node.create_subscription(Float64, "x", callback, 10)
    send(node.create_publisher(Float64, "x", 10), 1.0)
    spin_until(lambda: got == [1.0])


def test_one_callback_per_spin_once(node: Node, executor: Any, spin_until: SpinUntil) -> None:
    got: list[float] = []
    node.create_subscription(Float64, "x", lambda m: got.append(m.data), 10)
    send(node.create_publisher(Float64, "x", 10), 1.0, 2.0, 3.0)
    spin_until(lambda: got)
    assert got == [1.0]
    executor.spin_once(timeout_sec=0)
    assert got == [1.0, 2.0]


def test_destroyed_subscription_gets_nothing_more(node: Node, executor: Any, spin_until: SpinUntil) -> None:
    got: list[float] = []
    subscription = node.create_subscription(Float64, "x", lambda m: got.append(m.data), 10)
    send(node.create_publisher(Float64, "x", 10), 1.0, 2.0)
    spin_until(lambda: got)
    assert node.destroy_subscription(subscription)
    assert not node.destroy_subscription(subscription)
    executor.spin_once(timeout_sec=0)
    assert got == [1.0]


def test_graph(make_node: MakeNode, spin_until: SpinUntil, executor: Any) -> None:
    one, two = make_node("one", namespace="bench"), make_node("two")
    publisher = one.create_publisher(Float64, "~/x", 7)
    two.create_subscription(Float64, "/bench/one/x", lambda _: None, qos.qos_profile_sensor_data)
    spin_until(lambda: set(two.get_fully_qualified_node_names()) == {"/bench/one", "/two"})
    assert publisher.topic_name == "/bench/one/x"
    assert (two.count_publishers("/bench/one/x"), two.count_subscribers("/bench/one/x")) == (1, 1)
    assert ("/bench/one/x", ["std_msgs/msg/Float64"]) in two.get_topic_names_and_types()
    (info,) = two.get_publishers_info_by_topic("/bench/one/x")
    assert (info.node_name, info.node_namespace, info.topic_type) == ("one", "/bench", "std_msgs/msg/Float64")
    assert info.qos_profile is not None
    assert info.qos_profile.reliability is qos.ReliabilityPolicy.RELIABLE
    (info,) = one.get_subscriptions_info_by_topic("~/x")
    assert info.qos_profile is not None
    assert info.qos_profile.reliability is qos.ReliabilityPolicy.BEST_EFFORT
    assert ("/bench/one/x", ["std_msgs/msg/Float64"]) in two.get_publisher_names_and_types_by_node("one", "/bench")
    with pytest.raises(NodeNameNonExistentError):
        one.get_publisher_names_and_types_by_node("three", "/")
    two.destroy_node()
    spin_until(lambda: one.get_node_names() == ["one"])


def test_qos_profiles() -> None:
    assert qos.QoSReliabilityPolicy is qos.ReliabilityPolicy
    assert qos.QoSProfile(depth=3).depth == 3
    assert qos.qos_profile_sensor_data.reliability is qos.ReliabilityPolicy.BEST_EFFORT
    assert qos.QoSPresetProfiles.get_from_short_key("sensor_data") is qos.qos_profile_sensor_data
    with pytest.raises(qos.InvalidQoSProfileException):
        qos.QoSProfile()
    with pytest.raises(AssertionError, match="Invalid arguments"):
        qos.QoSProfile(depth=1, nothing=2)
    with pytest.raises(AssertionError, match="lifespan is 3"):
        qos.QoSProfile(depth=1, lifespan=3)
