"""Bundled nodes and real rclpy nodes on one domain; runs where ROS 2 Jazzy is sourced (services: Cyclone RMW)."""

from __future__ import annotations

from typing import Any

import pytest
from programs import MakeNode, Program, Run, SpinUntil
from ros import ON_CYCLONE, PATH, REAL_RCLPY

from seat_gear_dynamics.runtime.messages import get_message, get_service

pytestmark = [
    pytest.mark.ros,
    pytest.mark.skipif(not REAL_RCLPY, reason="rclpy is not importable"),
]

cyclone_rmw = pytest.mark.skipif(not ON_CYCLONE, reason="services need rmw_cyclonedds_cpp")

JointState = get_message("sensor_msgs/msg/JointState")

REAL = """
from seat_gear_dynamics.runtime import provide_rclpy
assert provide_rclpy() == "rclpy"
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger
rclpy.init()
node = Node("real")
late = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""


def real(run: Run, text: str) -> Program:
    return run(REAL + text, SEAT_GEAR_RUNTIME="rclpy", PYTHONPATH=":".join(["", *PATH]))


def test_topics_both_ways(run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node("bundled")
    executor.add_node(node)
    got: list[Any] = []
    node.create_subscription(JointState, "/back", got.append, 10)
    publisher = node.create_publisher(JointState, "/there", 10)
    peer = real(
        run,
        """
publisher = node.create_publisher(JointState, "/back", 10)
def back(message):
    message.position = [2.0 * x for x in message.position]
    publisher.publish(message)
node.create_subscription(JointState, "/there", back, 10)
print("up")
rclpy.spin(node)
""",
    )
    peer.expect("up")
    spin_until(lambda: publisher.get_subscription_count() == 1 and node.count_publishers("/back") == 1)
    sent = JointState(name=["s1_s2", "s3_s4"], position=[1.0, -2.5])
    sent.header.frame_id = "gear"
    publisher.publish(sent)
    spin_until(lambda: got)
    assert (got[0].name, list(got[0].position), got[0].header.frame_id) == (sent.name, [2.0, -5.0], "gear")
    spin_until(lambda: "/real" in node.get_fully_qualified_node_names())
    assert node.get_publishers_info_by_topic("/back")[0].node_name == "real"


def test_late_joiner_and_graph(run: Run, make_node: MakeNode, executor: Any) -> None:
    from seat_gear_dynamics.runtime.qos import DurabilityPolicy, QoSProfile

    node = make_node("bundled", namespace="/bench")
    executor.add_node(node)
    status = get_message("diagnostic_msgs/msg/DiagnosticStatus")
    late = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(status, "warning", late)
    for number in range(6):
        publisher.publish(status(level=status.ERROR, name=str(number)))
    peer = real(
        run,
        """
got = []
node.create_subscription(DiagnosticStatus, "/bench/warning", got.append, late)
while len(got) < 3:
    rclpy.spin_once(node)
print("got", [m.name for m in got], got[0].level)
while ("bundled", "/bench") not in node.get_node_names_and_namespaces():
    pass
info, = node.get_publishers_info_by_topic("/bench/warning")
print("info", info.node_name, info.topic_type, info.qos_profile.depth)
""",
    )
    assert peer.expect("got") == "got ['3', '4', '5'] b'\\x02'"
    depth = 3 if ON_CYCLONE else 0  # Fast DDS does not tell what history its peers keep
    assert peer.expect("info") == f"info bundled diagnostic_msgs/msg/DiagnosticStatus {depth}"
    assert not any("WARN" in line for line in peer.lines)


@cyclone_rmw
def test_real_client_of_bundled_service(run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node("bundled", start_parameter_services=True)
    node.declare_parameter("speed", 1.5)
    executor.add_node(node)

    def answer(request: Any, response: Any) -> Any:
        response.success, response.message = request.data, "from bundled"
        return response

    node.create_service(get_service("std_srvs/srv/SetBool"), "~/switch", answer)
    peer = real(
        run,
        """
from rclpy.parameter_client import AsyncParameterClient
client = node.create_client(SetBool, "/bundled/switch")
assert client.wait_for_service(20.0)
future = client.call_async(SetBool.Request(data=True))
rclpy.spin_until_future_complete(node, future)
print("answer", future.result().success, future.result().message)
parameters = AsyncParameterClient(node, "/bundled")
assert parameters.wait_for_services(20.0)
future = parameters.get_parameters(["speed"])
rclpy.spin_until_future_complete(node, future)
print("speed", future.result().values[0].double_value)
""",
    )
    spin_until(lambda: peer.process.poll() is not None)
    peer.wait()
    assert peer.lines[-2:] == ["answer True from bundled", "speed 1.5"]


@cyclone_rmw
def test_bundled_client_of_real_service(run: Run, make_node: MakeNode, executor: Any) -> None:
    node = make_node("bundled")
    executor.add_node(node)
    trigger = get_service("std_srvs/srv/Trigger")
    client = node.create_client(trigger, "/real/reset")
    peer = real(
        run,
        """
def answer(request, response):
    response.success, response.message = True, "from real"
    return response
node.create_service(Trigger, "~/reset", answer)
print("up")
rclpy.spin(node)
""",
    )
    peer.expect("up")
    assert client.wait_for_service(timeout_sec=20.0)
    future = client.call_async(trigger.Request())
    executor.spin_until_future_complete(future, timeout_sec=20.0)
    assert future.result().message == "from real"
