"""Real programs on loopback: talkers, listeners, signals, a kill, and peers that know only DDS."""

from __future__ import annotations

import os
import signal
import time
from typing import Any

import pytest
from programs import PREAMBLE, MakeNode, Run, SpinUntil

from seat_gear_dynamics.runtime.messages import get_message

Float64 = get_message("std_msgs/msg/Float64")

TALKER = (
    PREAMBLE
    + """
import sys
rclpy.init()
node = Node("talker")
publisher = node.create_publisher(Float64, "speed", 10)
node.create_timer(0.01, lambda: publisher.publish(Float64(data=2.5)))
def up():
    first.cancel()
    print("up", node.get_fully_qualified_name(), publisher.topic_name)
first = node.create_timer(0.0, up)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException) as error:
    print("ended by", type(error).__name__)
finally:
    node.destroy_node()
    rclpy.try_shutdown()
print("clean")
"""
)

SILENT = TALKER.replace("node.create_timer(0.01", "0 and node.create_timer(0.01")

PLAIN_PEER = """
from dataclasses import dataclass
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
import os, time

@dataclass
class Float64(IdlStruct, typename="std_msgs.msg.dds_.Float64_"):
    data: float

qos = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.History.KeepLast(10),
    Policy.DataRepresentation(use_cdrv0_representation=True),
)
participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
writer = DataWriter(participant, Topic(participant, "rt/to_ros", Float64, qos), qos)
reader = DataReader(participant, Topic(participant, "rt/from_ros", Float64, qos), qos)
print("up")
for sample in reader.take_iter(timeout=duration(seconds=20)):
    if hasattr(sample, "data"):
        print("got", sample.data)
        writer.write(Float64(data=sample.data * 2.0))
"""

CONFIGURED = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/>
</Interfaces></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""


def test_talker_reaches_listener(run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    got: list[float] = []
    node = make_node("listener")
    node.create_subscription(Float64, "/bench/spindle", lambda m: got.append(m.data), 10)
    executor.add_node(node)
    talker = run(TALKER, "--ros-args", "-r", "__ns:=/bench", "-r", "__node:=motor", "-r", "speed:=spindle")
    assert talker.expect("up").split() == ["up", "/bench/motor", "/bench/spindle"]
    spin_until(lambda: len(got) >= 3)
    assert got[0] == 2.5
    spin_until(lambda: "/bench/motor" in node.get_fully_qualified_node_names())
    talker.stop()
    # A clean end leaves the graph at once.
    spin_until(lambda: "/bench/motor" not in node.get_fully_qualified_node_names())


@pytest.mark.parametrize("program", [TALKER, SILENT], ids=["talking", "silent"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_at_any_time_end_spinning_cleanly(run: Run, program: str, number: int) -> None:
    talker = run(program)
    talker.expect("up")
    assert talker.stop(number) == 0
    assert talker.lines[-1] == "clean"
    assert not any("Traceback" in line for line in talker.lines)


SIGNALLED_WHILE_WAITING = """
import os, signal, threading, time
sent = []
def kill():
    sent.append(time.monotonic())
    os.kill(os.getpid(), int(sys.argv[1]))
threading.Timer(0.3, kill).start()
try:
"""


@pytest.mark.parametrize(
    ("number", "before", "error"),
    [
        (signal.SIGINT, "", "KeyboardInterrupt"),
        (signal.SIGTERM, "", "ExternalShutdownException"),
        # A shell starts background programs with SIGINT ignored; rclpy ends them on it all the same.
        (
            signal.SIGINT,
            "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n",
            "ExternalShutdownException",
        ),
    ],
)
def test_signals_while_waiting(run: Run, number: signal.Signals, before: str, error: str) -> None:
    text = SILENT.replace("\ntry:\n", SIGNALLED_WHILE_WAITING)
    text = text.replace('    print("ended by"', '    print("after", time.monotonic() - sent[0])\n    print("ended by"')
    program = run(before + text, str(number.value))
    assert program.wait() == 0
    assert program.lines[-2:] == [f"ended by {error}", "clean"]
    after = next(line for line in program.lines if line.startswith("after"))
    # The wait is cut in pieces of 50 ms; the rest is room for a loaded machine.
    assert float(after.split()[1]) < 1.0


def test_program_survives_a_killed_peer(run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node("listener")
    got: list[float] = []
    node.create_subscription(Float64, "speed", lambda m: got.append(m.data), 10)
    executor.add_node(node)
    first = run(TALKER)
    first.expect("up")
    spin_until(lambda: got)
    first.stop(signal.SIGKILL)
    second = run(TALKER)
    second.expect("up")
    executor.spin_once(timeout_sec=0.0)
    got.clear()
    spin_until(lambda: len(got) >= 3)
    assert second.stop() == 0


def test_many_starts_and_ends_in_one_program(run: Run) -> None:
    program = run(
        PREAMBLE
        + """
for n in range(5):
    rclpy.init()
    node = Node(f"node_{n}")
    rclpy.spin_once(node, timeout_sec=0.0)
    (node.destroy_node(), rclpy.shutdown()) if n % 2 else (rclpy.shutdown(), node.destroy_node())
    print(n, rclpy.ok())
"""
    )
    assert program.wait() == 0
    assert program.lines == [f"{n} False" for n in range(5)]


def test_plain_dds_peer_speaks_both_ways(run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node()
    executor.add_node(node)
    got: list[float] = []
    node.create_subscription(Float64, "/to_ros", lambda m: got.append(m.data), 10)
    publisher = node.create_publisher(Float64, "from_ros", 10)
    peer = run(PLAIN_PEER, PYTHONPATH=os.environ.get("PYTHONPATH", ""), CYCLONEDDS_URI=CONFIGURED)
    peer.expect("up")
    spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Float64(data=1.25))
    assert peer.expect("got") == "got 1.25"
    spin_until(lambda: got == [2.5])


def test_plain_dds_peer_with_a_default_configuration(run: Run, make_node: MakeNode, spin_until: SpinUntil) -> None:
    publisher = make_node().create_publisher(Float64, "from_ros", 10)
    peer = run(PLAIN_PEER, PYTHONPATH=os.environ.get("PYTHONPATH", ""))
    peer.expect("up")
    spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Float64(data=0.5))
    peer.expect("got 0.5")


def test_late_program_gets_the_trip_signal(run: Run) -> None:
    first = run(
        PREAMBLE
        + """
from rclpy.qos import DurabilityPolicy, QoSProfile
rclpy.init()
node = Node("first")
publisher = node.create_publisher(Float64, "trip", QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL))
for n in range(8):
    publisher.publish(Float64(data=float(n)))
print("up")
rclpy.spin(node)
"""
    )
    first.expect("up")
    second = run(
        PREAMBLE
        + """
from rclpy.qos import DurabilityPolicy, QoSProfile
rclpy.init()
node = Node("second")
got = []
node.create_subscription(
    Float64, "trip", lambda m: got.append(m.data), QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
)
while 7.0 not in got:
    rclpy.spin_once(node)
print(got)
"""
    )
    assert second.expect("7.0") == "[5.0, 6.0, 7.0]"


def test_raw_bytes_between_programs(run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node()
    executor.add_node(node)
    got: list[bytes] = []
    node.create_subscription(Float64, "speed", got.append, 10, raw=True)
    run(TALKER).expect("up")
    spin_until(lambda: got)
    assert got[0] == bytes.fromhex("00010000 0000000000000440")


def test_message_times_are_the_writers(run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node()
    executor.add_node(node)
    infos: list[dict[str, int]] = []
    node.create_subscription(Float64, "speed", lambda _, info: infos.append(info), 10)
    run(TALKER).expect("up")
    spin_until(lambda: len(infos) >= 2)
    assert infos[0]["source_timestamp"] < infos[1]["source_timestamp"]
    assert abs(infos[0]["source_timestamp"] - time.time_ns()) < 60e9


def test_parameter_file_reaches_a_program(run: Run, tmp_path: Any) -> None:
    path = tmp_path / "parameters.yaml"
    path.write_text("/**:\n  ros__parameters: {gain: 2.5}\nworker:\n  ros__parameters: {label: bench}\n")
    program = run(
        PREAMBLE
        + """
rclpy.init()
node = Node("worker")
print(node.declare_parameter("gain", 1.0).value, node.declare_parameter("label", "").value)
""",
        *("--own", "--ros-args", "--params-file", str(path), "--log-level", "debug"),
    )
    program.expect("2.5 bench")


def test_wrong_domain_ends_in_a_sentence(run: Run) -> None:
    program = run(PREAMBLE + "rclpy.init()\n", ROS_DOMAIN_ID="many")
    assert program.wait() == 1
    assert "ROS_DOMAIN_ID is 'many', expected a whole number from 0 to 232" in program.lines[-1]
