"""The nodes with keys on real ROS 2, security enforced, and what others on the same network then cannot do."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from domains import fresh_domain
from programs import ROOT, Program
from ros import REAL_RCLPY

from seat_gear_dynamics.logs.reader import Bag

pytestmark = [
    pytest.mark.ros,
    pytest.mark.skipif(not REAL_RCLPY or shutil.which("ros2") is None, reason="ROS 2 is not sourced"),
    pytest.mark.skipif(importlib.util.find_spec("sros2") is None, reason="sros2, which makes the keys, is not here"),
    pytest.mark.skipif(os.environ.get("RMW_IMPLEMENTATION") != "rmw_cyclonedds_cpp", reason="needs rmw_cyclonedds_cpp"),
]

POLICY = ROOT / "config" / "security" / "seat_gear.policy.xml"

NODE = """
import runpy, sys
runpy.run_module("seat_gear_dynamics.nodes." + sys.argv[1], run_name="__main__", alter_sys=True)
"""

START = """
import sys
from seat_gear_dynamics.runtime import provide_rclpy
provide_rclpy()
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import Trigger
rclpy.init()
node = Node(sys.argv[1])
print("up", flush=True)
"""

OPERATOR = (
    START
    + """
fed, forces = set(), []
node.create_subscription(JointState, "gear_monitor/input", lambda m: fed.add(m.velocity[0]), 100)
node.create_subscription(JointState, "gear_monitor/mesh_force", forces.append, 100)
reset = node.create_client(Trigger, "gear_monitor/reset")
split = node.create_client(Trigger, "bench_recorder/split")
for client in (reset, split):
    assert client.wait_for_service(60)
    future = client.call_async(Trigger.Request())
    rclpy.spin_until_future_complete(node, future, timeout_sec=30)
    print("answered", future.result().success, flush=True)
while len(forces) < 50:
    rclpy.spin_once(node)
print("forces come", sorted(node.get_node_names()), flush=True)
for line in sys.stdin:
    rclpy.spin_once(node, timeout_sec=0.0)
"""
)

# Two of them: what they exchange shows that discovery and data work where nobody is protected.
SPEAKING_OUTSIDER = (
    START
    + """
publisher = node.create_publisher(Float64, "motor/speed", 10)
reset = node.create_client(Trigger, "gear_monitor/reset")
while True:
    publisher.publish(Float64(data=123.456))
    rclpy.spin_once(node, timeout_sec=0.02)
    print("subscribers", publisher.get_subscription_count(), "service", reset.service_is_ready(), flush=True)
"""
)
HEARING_OUTSIDER = (
    START
    + """
speeds, forces = [], []
node.create_subscription(Float64, "motor/speed", lambda m: speeds.append(m.data), 10)
node.create_subscription(JointState, "gear_monitor/mesh_force", forces.append, 10)
while len(speeds) < 200:
    rclpy.spin_once(node, timeout_sec=1.0)
topics = [name for name, _ in node.get_topic_names_and_types() if "gear_monitor/" in name]
foreign = [topic for topic in topics if node.count_publishers(topic)]
print("speeds", set(speeds), "forces", len(forces), "foreign", foreign, "nodes", sorted(node.get_node_names()))
"""
)

# As long as the honest operator needs for fifty forces several times over.
FORGER = (
    START
    + """
publisher = node.create_publisher(Float64, "motor/speed", 10)
most = 0
for _ in range(200):
    publisher.publish(Float64(data=123.456))
    rclpy.spin_once(node, timeout_sec=0.02)
    most = max(most, publisher.get_subscription_count())
print("subscribers", most)
"""
)

THIEF = (
    START
    + """
node.create_publisher(Float64, "motor/speed", 10)
print("may be the bench", flush=True)
for name in ("gear_monitor/mesh_force", "gear_monitor/input", "gear_monitor/model_state"):
    try:
        node.create_publisher(JointState, name, 10)
        print("may publish", name)
    except Exception as error:
        print("refused", name, flush=True)
try:
    node.create_subscription(JointState, "gear_monitor/mesh_force", print, 10)
    print("may hear")
except Exception as error:
    print("refused to hear", flush=True)
print("done")
"""
)


def security(*words: str, domain: int) -> None:
    """Run `ros2 security` for a domain, whose number goes into what it makes."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    done = subprocess.run(["ros2", "security", *words], env=environment, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr


def make_keys(folder: Path, domain: int) -> Path:
    security("create_keystore", str(folder), domain=domain)
    security("generate_artifacts", "-k", str(folder), "-p", str(POLICY), domain=domain)
    return folder


@pytest.fixture(scope="module")
def domain() -> int:
    """One domain for the site."""
    return fresh_domain()


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory, domain: int) -> Path:
    return make_keys(tmp_path_factory.mktemp("keys") / "store", domain)


def start(text: str, domain: int, keys: Path | None, enclave: str, *arguments: str, runtime: str = "rclpy") -> Program:
    """Start a program with the keys of an enclave, or without any."""
    secure = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_KEYSTORE": str(keys)}
    environment = {"ROS_SECURITY_ENABLE": "false"} if keys is None else secure
    flags = ("--ros-args", "--enclave", f"/seat_gear/{enclave}")
    return Program(text, domain, *arguments, *flags, SEAT_GEAR_RUNTIME=runtime, **environment)


@pytest.fixture(scope="module")
def site(keys: Path, domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Simulator, monitor and recorder with their keys, seen to work by an operator with his; gives the log."""
    log = tmp_path_factory.mktemp("log") / "log"
    names = {"recorder": "bench_recorder", "monitor": "gear_monitor", "simulator": "bench_simulator"}
    output = ("--ros-args", "-p", f"output:={log}", "--")
    programs = [
        start(NODE, domain, keys, enclave, module, *(output if module == "recorder" else ()))
        for module, enclave in names.items()
    ]
    operator = start(OPERATOR, domain, keys, "operator", "operator")
    operator.expect("answered True")
    operator.expect("answered True")
    line = operator.expect("forces come")
    assert all(name in line for name in names.values())
    operator.process.kill()
    yield log
    for program in programs:
        program.process.send_signal(2)
    for program in programs:
        program.wait()
    heard = Bag(log).scalars("motor/speed")[1]
    assert len(heard) > 100
    assert 123.456 not in heard


@pytest.mark.parametrize("runtime", ["rclpy", "bundled"])
def test_an_outsider_without_keys_hears_nothing_and_reaches_nobody(site: Path, domain: int, runtime: str) -> None:
    hearing = start(HEARING_OUTSIDER, domain, None, "none", "hearing", runtime=runtime)
    speaking = start(SPEAKING_OUTSIDER, domain, None, "none", "speaking", runtime=runtime)
    found = hearing.expect("speeds")
    assert "speeds {123.456} forces 0 foreign [] nodes ['hearing', 'speaking']" in found
    speaking.process.kill()
    speaking.wait()
    said = {line for line in speaking.lines if line.startswith("subscribers")}
    assert "subscribers 1 service False" in said, "the other outsider"
    assert said <= {"subscribers 0 service False", "subscribers 1 service False"}


def test_one_with_the_same_names_signed_by_another_authority_reaches_nobody(
    site: Path, domain: int, tmp_path: Path
) -> None:
    foreign = make_keys(tmp_path / "foreign", domain)
    forger = start(FORGER, domain, foreign, "bench_simulator", "bench_simulator")
    forger.expect("certificate signature failure")
    forger.expect("subscribers 0")
    assert forger.wait() == 0


def test_the_key_of_the_simulator_opens_the_simulators_topics_alone(site: Path, keys: Path, domain: int) -> None:
    thief = start(THIEF, domain, keys, "bench_simulator", "bench_simulator")
    thief.wait()
    assert [line for line in thief.lines if line.startswith(("may", "refused", "done"))] == [
        "may be the bench",
        "refused gear_monitor/mesh_force",
        "refused gear_monitor/input",
        "refused gear_monitor/model_state",
        "refused to hear",
        "done",
    ]


def test_without_its_keys_a_node_does_not_start(tmp_path: Path, domain: int) -> None:
    node = start(START, domain, tmp_path, "gear_monitor", "gear_monitor")
    assert node.wait() != 0
    assert "up" not in node.lines
    assert any("SECURITY ERROR" in line for line in node.lines)
