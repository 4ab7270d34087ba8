"""The recorder as a process: what it records, its services, and what it does when it cannot."""

import signal
from pathlib import Path

import pytest
from harness import Peer, Processes
from recorder_control import Control

from seat_gear_dynamics.gears import packaged_description
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.topics import TOPICS


@pytest.fixture
def control(peer: Peer) -> Control:
    return Control(peer)


def count(log: Path, topic: str = "/motor/speed") -> int:
    return Bag(log).topics[topic].count


def send(peer: Peer, number: int) -> None:
    for i in range(number):
        peer.drive(500.0 + i)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_log_is_complete_after(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path, number: signal.Signals
) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log)
    peer.wait_for_subscriber("motor/speed")
    peer.wait_for_subscriber("load/torque")
    send(peer, 200)
    control.wait_received(200)
    assert processes.end(recorder, number) == 0
    bag = Bag(log)
    assert bag.closed
    assert set(bag.topics) >= {topic.absolute() for topic in TOPICS}
    assert count(log) == count(log, "/load/torque") == 200
    assert bag.metadata is not None
    assert bag.metadata["system"] == packaged_description().read_text()


def test_start_stop_pause_resume_split_and_snapshot_are_services(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log, autostart="false")
    peer.wait_for_subscriber("motor/speed")
    assert not control.call("stop").success
    assert "stopped" in control.call("stop").message
    assert control.call("start").success
    assert not control.call("start").success, "it records already"
    send(peer, 10)
    control.wait_received(10)
    assert control.call("pause").success
    send(peer, 20)
    control.wait_received(30)
    assert control.call("resume").success
    send(peer, 5)
    control.wait_received(35)
    split = control.call("split")
    assert split.success
    assert split.message.endswith("run_1.mcap")
    send(peer, 7)
    control.wait_received(42)
    snapshot = control.call("snapshot")
    assert snapshot.success
    assert control.call("stop").success
    assert control.call("start").success, "a second run gets a folder of its own"
    assert processes.end(recorder) == 0
    assert count(log) == 10 + 5 + 7
    assert sorted(file.name for file in log.glob("*.mcap")) == ["run_0.mcap", "run_1.mcap"]
    assert count(tmp_path / "run_snapshot1") == 10 + 20 + 5 + 7, "the ring holds what came while paused as well"
    assert (tmp_path / "run_run2").is_dir()


def test_a_publisher_of_best_effort_is_recorded_too(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from std_msgs.msg import Float64

    log = tmp_path / "run"
    qos = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = peer.node.create_publisher(Float64, "/cell/motor/speed", qos)
    recorder = processes.node("recorder", "-r", "__ns:=/cell", output=log)
    peer.wait(lambda: publisher.get_subscription_count() > 0, "the recorder to follow best effort")
    publisher.publish(Float64(data=1.0))
    control.wait_received(1)
    assert "best effort" in processes.words(recorder)
    assert processes.end(recorder) == 0
    assert count(log, "/cell/motor/speed") == 1


@pytest.mark.parametrize("name", ["existing", "file/below"])
def test_a_folder_that_cannot_be_is_one_sentence(processes: Processes, tmp_path: Path, name: str) -> None:
    (tmp_path / "existing").mkdir()
    (tmp_path / "file").write_text("a file, not a folder")
    recorder = processes.node("recorder", output=tmp_path / name)
    assert recorder.wait(60) == 1
    assert "error: The log" in processes.words(recorder)
    assert "Traceback" not in processes.words(recorder)
