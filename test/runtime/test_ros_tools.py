"""ROS 2's own command line tools on bundled nodes; runs where ROS 2 Jazzy is sourced (services: Cyclone RMW)."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator

import pytest
from domains import fresh_domain
from programs import PREAMBLE, Program
from ros import PATH, REAL_RCLPY

pytestmark = [
    pytest.mark.ros,
    pytest.mark.skipif(not REAL_RCLPY or shutil.which("ros2") is None, reason="ROS 2 is not sourced"),
    pytest.mark.skipif(
        os.environ.get("RMW_IMPLEMENTATION") != "rmw_cyclonedds_cpp", reason="services need rmw_cyclonedds_cpp"
    ),
]

LOOK = ("--no-daemon", "--spin-time", "2")
LONGEST = 60.0
"""Seconds a tool may take on a loaded machine."""

WORKER = (
    PREAMBLE
    + """
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.lifecycle import LifecycleNode
rclpy.init()
node = LifecycleNode("worker")
bounds = [FloatingPointRange(from_value=1.0, to_value=100.0, step=0.5)]
node.declare_parameter("rate", 10.0, ParameterDescriptor(description="samples, Hz", floating_point_range=bounds))
node.declare_parameter("fixed", "a", ParameterDescriptor(read_only=True))
publisher = node.create_lifecycle_publisher(Float64, "value", 5)
node.create_subscription(Float64, "input", print, 10)
node.create_timer(0.05, lambda: publisher.publish(Float64(data=node.get_parameter("rate").value)))
print("up")
rclpy.spin(node)
"""
)


@pytest.fixture(scope="module")
def domain() -> int:
    """One domain for the node and all tools."""
    return fresh_domain()


@pytest.fixture(scope="module", autouse=True)
def worker(domain: int) -> Iterator[Program]:
    program = Program(WORKER, domain, "--ros-args", "-r", "__ns:=/bench")
    program.expect("up")
    yield program
    program.stop()


def ros2(domain: int, *words: str) -> str:
    """Run a tool and return what it said; it must end well, and say nothing of trouble with the node's types."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "PYTHONPATH": os.pathsep.join(PATH)}
    environment.pop("SEAT_GEAR_RUNTIME", None)
    done = subprocess.run(["ros2", *words], env=environment, capture_output=True, text=True, timeout=LONGEST)
    assert done.returncode == 0, done.stdout + done.stderr
    # The Cyclone RMW warns here of a type hash it cannot read.
    assert "[WARN]" not in done.stderr, done.stderr
    return done.stdout + done.stderr


def test_lifecycle_tools(domain: int) -> None:
    name = "/bench/worker"
    assert name in ros2(domain, "lifecycle", "nodes", *LOOK).split()
    assert ros2(domain, "lifecycle", "get", *LOOK, name).strip() == "unconfigured [1]"
    listed = ros2(domain, "lifecycle", "list", *LOOK, name)
    assert "- configure [1]\n\tStart: unconfigured\n\tGoal: configuring" in listed
    assert "activate" not in listed
    for transition in ("configure", "activate"):
        said = ros2(domain, "lifecycle", "set", *LOOK, name, transition)
        assert said.strip() == "Transitioning successful"
    assert ros2(domain, "topic", "echo", "--once", *LOOK, "/bench/value") == "data: 10.0\n---\n"
    assert ros2(domain, "lifecycle", "get", *LOOK, name).strip() == "active [3]"


def test_graph_tools(domain: int) -> None:
    assert "/bench/worker" in ros2(domain, "node", "list", *LOOK).split()
    info = ros2(domain, "node", "info", *LOOK, "/bench/worker")
    subscribers, _, rest = info.partition("Publishers:")
    publishers, _, services = rest.partition("Service Servers:")
    assert "/bench/input: std_msgs/msg/Float64" in subscribers
    assert "/bench/value: std_msgs/msg/Float64" in publishers
    assert "/bench/worker/transition_event: lifecycle_msgs/msg/TransitionEvent" in publishers
    assert "/bench/worker/change_state: lifecycle_msgs/srv/ChangeState" in services
    assert "/bench/worker/set_parameters: rcl_interfaces/srv/SetParameters" in services
    verbose = ros2(domain, "topic", "info", "-v", *LOOK, "/bench/value")
    for line in (
        "Node name: worker",
        "Node namespace: /bench",
        "Topic type hash: RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a",
        "Reliability: RELIABLE",
        "History (Depth): KEEP_LAST (5)",
        "Durability: VOLATILE",
    ):
        assert line in verbose
    listed = ros2(domain, "service", "list", "-t", *LOOK)
    assert "/bench/worker/get_state [lifecycle_msgs/srv/GetState]" in listed


def test_parameter_tools(domain: int) -> None:
    name = "/bench/worker"
    assert {"rate", "fixed", "use_sim_time"} <= set(ros2(domain, "param", "list", *LOOK, name).split())
    described = ros2(domain, "param", "describe", *LOOK, name, "rate")
    for line in ("Type: double", "Description: samples, Hz", "Min value: 1.0", "Max value: 100.0", "Step: 0.5"):
        assert line in described
    assert "successful" in ros2(domain, "param", "set", *LOOK, name, "rate", "20.5")
    assert ros2(domain, "param", "get", *LOOK, name, "rate").strip() == "Double value is: 20.5"
    assert "out of range" in ros2(domain, "param", "set", *LOOK, name, "rate", "200.0")
    assert "not close enough to a valid step" in ros2(domain, "param", "set", *LOOK, name, "rate", "20.7")
    assert "read-only" in ros2(domain, "param", "set", *LOOK, name, "fixed", "b")
