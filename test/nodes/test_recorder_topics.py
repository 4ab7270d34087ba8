"""What the recorder listens to: lists and patterns, quality of service, wrong types, floods, simulated time."""

from pathlib import Path
from typing import Any

import pytest
from harness import Peer, Processes
from recorder_control import Control

from seat_gear_dynamics.logs.reader import Bag

OK, WARN = 0, 1
SECOND = 1_000_000_000


@pytest.fixture
def control(peer: Peer) -> Control:
    return Control(peer)


def publisher(peer: Peer, name: str, kind: Any, **qos: Any) -> Any:
    from rclpy.qos import QoSProfile

    return peer.node.create_publisher(kind, name, QoSProfile(depth=1000, **qos))


def wait_heard(peer: Peer, *publishers: Any) -> None:
    peer.wait(lambda: all(p.get_subscription_count() > 0 for p in publishers), "the recorder to listen")


def test_a_list_and_a_pattern_are_recorded_and_nothing_else(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    from rosidl_runtime_py.utilities import get_message
    from std_msgs.msg import Float64, String

    twist = get_message("geometry_msgs/msg/Twist")
    log = tmp_path / "run"
    named = publisher(peer, "/named", Float64)
    found = publisher(peer, "/cell/found", twist)
    refused = publisher(peer, "/cell/secret", Float64)
    other = publisher(peer, "/other", Float64)
    recorder = processes.node("recorder", output=log, topics="named,late", pattern="^/cell/", exclude="secret")
    wait_heard(peer, named, found)
    late = publisher(peer, "/late", String)
    wait_heard(peer, late)
    for each in (named, refused, other):
        each.publish(Float64(data=1.0))
    found.publish(twist())
    late.publish(String(data="came later"))
    for key in ("/named", "/cell/found", "/late"):
        control.wait_count(f"{key} received", 1)
    assert refused.get_subscription_count() == other.get_subscription_count() == 0
    assert processes.end(recorder) == 0
    bag = Bag(log)
    assert {name: (info.type, info.count) for name, info in bag.topics.items()} == {
        "/named": ("std_msgs/msg/Float64", 1),
        "/cell/found": ("geometry_msgs/msg/Twist", 1),
        "/late": ("std_msgs/msg/String", 1),
    }
    assert [message.message.data for message in bag.decoded("/late")] == ["came later"]
    assert bag.custom_data["messages of /late"] == "received 1, written 1, dropped 0"


def test_a_level_that_cannot_be_is_one_sentence(processes: Processes, tmp_path: Path) -> None:
    recorder = processes.node("recorder", output=tmp_path / "run", snapshot_on="stale")
    assert recorder.wait(60) == 1
    words = processes.words(recorder)
    assert "error: The parameter snapshot_on is 'stale', expected 'error', 'warn' or 'never'." in words
    assert "Traceback" not in words
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("contract", "[", ""), "parameter pattern is '\\[', which is no regular expression"),
        (("contract", "", "("), "parameter exclude is '\\(', which is no regular expression"),
        (("1bad", "", ""), "has a name that cannot be"),
    ],
)
def test_a_choice_that_cannot_be_is_a_sentence(peer: Peer, arguments: tuple[str, str, str], sentence: str) -> None:
    from seat_gear_dynamics.nodes.process import StartError
    from seat_gear_dynamics.nodes.recorder_topics import choose

    with pytest.raises(StartError, match=sentence):
        choose(peer.node, *arguments)


@pytest.mark.parametrize(
    ("arguments", "taken", "left"),
    [
        (("all", "", ""), {"/a", "/b/c"}, {"/_hidden", "/b/_hidden"}),
        (("all", "", "^/b"), {"/a"}, {"/b/c"}),
        (("a, /b/_hidden", "", ""), {"/a", "/b/_hidden"}, {"/b/c"}),
        (("", "c$", ""), {"/b/c"}, {"/a", "/_hiddenc"}),
        (("contract", "", ""), set(), {"/a"}),
        (("/a", "", "a"), set(), {"/a"}),
    ],
)
def test_what_a_choice_takes(peer: Peer, arguments: tuple[str, str, str], taken: set[str], left: set[str]) -> None:
    from seat_gear_dynamics.nodes.recorder_topics import choose

    choice = choose(peer.node, *arguments)
    assert {name for name in taken | left if choice.takes(name)} == taken


def test_a_topic_of_a_wrong_type_is_said_and_the_others_go_on(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    from std_msgs.msg import Float64, String

    log = tmp_path / "run"
    wrong = publisher(peer, "/cell/motor/speed", String)
    right = publisher(peer, "/cell/load/torque", Float64)
    recorder = processes.node("recorder", "-r", "__ns:=/cell", output=log)
    wait_heard(peer, right)
    wrong.publish(String(data="fast"))
    right.publish(Float64(data=1.0))
    control.wait_level(WARN, "/cell/motor/speed is published as std_msgs/msg/String by test_peer")
    control.wait_count("load/torque received", 1)
    peer.node.destroy_publisher(wrong)
    control.wait_level(OK, "recording")
    assert processes.end(recorder) == 0
    assert (Bag(log).topics["/cell/motor/speed"].count, Bag(log).topics["/cell/load/torque"].count) == (0, 1)


def test_a_latched_topic_offered_volatile_is_heard_too(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    from std_msgs.msg import Bool

    trip = publisher(peer, "/cell/gear_monitor/in_forbidden_band", Bool)
    recorder = processes.node("recorder", "-r", "__ns:=/cell", output=tmp_path / "run")
    wait_heard(peer, trip)
    trip.publish(Bool(data=True))
    control.wait_count("gear_monitor/in_forbidden_band received", 1)
    assert "volatile" in processes.words(recorder)
    assert processes.end(recorder) == 0


def test_a_latched_message_of_before_the_recorder_is_recorded(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    from rclpy.qos import DurabilityPolicy
    from std_msgs.msg import String

    log = tmp_path / "run"
    latched = publisher(peer, "/description", String, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    latched.publish(String(data="once"))
    recorder = processes.node("recorder", output=log, topics="/description")
    control.wait_count("/description received", 1)
    assert control.call("split").success
    assert processes.end(recorder) == 0
    assert len(Bag(log).files) == 2
    assert Bag(log).topics["/description"].count == 2, "repeated at the beginning of the second file"


# Publishes on one topic as fast as it can until somebody ends it.
FLOOD = """
import seat_gear_dynamics.nodes
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray
rclpy.init(args=[])
publisher = Node("flood").create_publisher(Float64MultiArray, "/flood", 10)
message = Float64MultiArray(data=[0.5] * 100)
while rclpy.ok():
    publisher.publish(message)
"""


def test_a_flood_on_one_topic_costs_the_others_nothing(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log, topics="contract /flood", snapshot_bytes=1_000_000)
    peer.wait_for_subscriber("motor/speed")
    flood = processes.start("-c", FLOOD)
    control.wait_count("/flood received", 1)
    for sent in range(1, 201):
        peer.drive(500.0 + sent)
    control.wait_received(200)
    processes.end(flood)
    assert processes.end(recorder) == 0
    bag = Bag(log)
    assert bag.closed
    assert bag.topics["/motor/speed"].count == bag.topics["/load/torque"].count == 200
    assert bag.topics["/flood"].count > 0
    assert bag.damage is None


def test_simulated_time_is_obeyed_and_may_step_back_an_hour(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    from rosgraph_msgs.msg import Clock

    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log, use_sim_time="true")
    clock = publisher(peer, "/clock", Clock)
    peer.wait_for_subscriber("motor/speed")
    wait_heard(peer, clock)
    peer.drive(500.0)
    control.wait_received(1)
    assert int(control.values()["came while not recording"]) >= 2, "nothing is recorded before the clock runs"
    heard = 1

    def drive_at(seconds: int) -> None:
        nonlocal heard
        message = Clock()
        message.clock.sec = seconds
        clock.publish(message)
        peer.wait(lambda: peer.messages["/diagnostics"][-1].header.stamp.sec == seconds, f"the time {seconds}")
        peer.drive(500.0)
        heard += 1
        control.wait_received(heard)

    for seconds in (10_000, 6_400):
        drive_at(seconds)
    assert processes.end(recorder) == 0
    bag = Bag(log)
    times = sorted(message.log_time_ns // SECOND for message in bag.messages("/motor/speed"))
    assert times == [6_400, 10_000]
    assert bag.damage is None
    assert bag.closed
