"""The nodes on real rclpy, seen with ROS 2's own tools; runs where ROS 2 Jazzy is sourced."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from harness import Peer, Processes
from ros import REAL_RCLPY

pytestmark = [pytest.mark.ros, pytest.mark.skipif(not REAL_RCLPY, reason="ROS 2 is not sourced")]

BAG = Path(__file__).parents[2] / "bags" / "third_party_bench"


def ros2(*arguments: str) -> str:
    """Run a ros2 command without its daemon's memory and return what it printed."""
    done = subprocess.run(["ros2", *arguments], env=os.environ.copy(), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_topic_echo_node_list_param_and_service_work_on_the_nodes(
    processes: Processes, peer: Peer, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log)
    processes.node("monitor")
    processes.node("simulator", profile="dwell-in-band")
    peer.wait(lambda: bool(peer.messages["gear_monitor/mesh_force"]), "forces")
    names = ros2("node", "list", "--no-daemon", "--spin-time", "3")
    assert {"/gear_monitor", "/bench_recorder", "/bench_simulator"} <= set(names.split())
    echoed = ros2("topic", "echo", "--once", "--no-daemon", "--spin-time", "3", "/gear_monitor/mesh_force")
    assert "s1_s2/mean" in echoed
    assert "effort:" in echoed
    assert "margin_rpm" in ros2("param", "list", "/gear_monitor", "--no-daemon", "--spin-time", "3")
    got = ros2("param", "get", "/gear_monitor", "margin_rpm", "--no-daemon", "--spin-time", "3")
    assert got.strip() == "Double value is: 40.0"
    described = ros2("param", "describe", "/gear_monitor", "margin_rpm", "--no-daemon", "--spin-time", "3")
    assert "Max value: 1000.0" in described
    called = ros2("service", "call", "/bench_recorder/split", "std_srvs/srv/Trigger")
    assert "success=True" in called
    assert processes.end(recorder) == 0
    if shutil.which("ros2") and "bag" in ros2("--help"):
        info = ros2("bag", "info", str(log))
        assert "/gear_monitor/chaos_warning | Type: diagnostic_msgs/msg/DiagnosticStatus" in info


def test_ros2_bag_play_drives_the_monitor(processes: Processes, peer: Peer) -> None:
    if "bag" not in ros2("--help"):
        pytest.skip("rosbag2 is not installed")
    processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    player = subprocess.Popen(
        ["ros2", "bag", "play", str(BAG), "--disable-keyboard-controls"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        peer.wait(lambda: len(peer.messages["gear_monitor/mesh_force"]) > 100, "forces from the played bag")
        peer.wait(lambda: peer.level() in (1, 2), "a warning as the drive nears a band", patience=40)
    finally:
        os.killpg(player.pid, 2)
        player.wait(20)
