"""The launch file, run by ROS 2's own launch: transitions by events, respawn, namespace; where ROS 2 is sourced."""

import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml
from harness import Peer
from monitored import Managed
from ros import REAL_RCLPY, program

ROOT = Path(__file__).parents[2]
PACKAGE = "seat_gear_dynamics"
NODES = ("monitor", "recorder", "simulator")
AGGREGATED = ROOT / "config" / "diagnostics_aggregator.yaml"


@pytest.fixture
def prefix(tmp_path: Path) -> Path:
    """An ament prefix that holds the package as colcon installs it, with this checkout's code."""
    folder = tmp_path / "prefix"
    index = folder / "share" / "ament_index" / "resource_index" / "packages"
    programs = folder / "lib" / PACKAGE
    for made in (index, programs):
        made.mkdir(parents=True)
    (index / PACKAGE).touch()
    for node in NODES:
        program = programs / node
        program.write_text(f'#!/bin/sh\nexec {sys.executable} -m {PACKAGE}.nodes.{node} "$@"\n')
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return folder


Launch = Callable[..., "subprocess.Popen[bytes]"]


@pytest.fixture
def launch(prefix: Path, domain_id: int, tmp_path: Path) -> Iterator[Launch]:
    """Run the launch file with arguments; what it says is in `launch.txt` of the test's folder."""
    running: list[subprocess.Popen[bytes]] = []

    def start(*arguments: str) -> "subprocess.Popen[bytes]":
        environment = {**os.environ, "AMENT_PREFIX_PATH": f"{prefix}:{os.environ.get('AMENT_PREFIX_PATH', '')}"}
        environment["ROS_LOG_DIR"] = str(tmp_path / "log")
        words = (tmp_path / "launch.txt").open("wb")
        command = ["ros2", "launch", str(ROOT / "launch" / "bench.launch.py"), *arguments]
        running.append(
            subprocess.Popen(
                command, env=environment, stdout=words, stderr=subprocess.STDOUT, cwd=tmp_path, start_new_session=True
            )
        )
        return running[-1]

    yield start
    for process in running:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()


def words(tmp_path: Path) -> str:
    return (tmp_path / "launch.txt").read_text(errors="replace")


@pytest.mark.parametrize("autostart", ["true", "false"])
@pytest.mark.ros
@pytest.mark.skipif(not REAL_RCLPY, reason="ROS 2 is not sourced")
def test_the_monitor_is_led_by_events_or_left_alone(launch: Launch, peer: Peer, tmp_path: Path, autostart: str) -> None:
    process = launch("record:=false", f"autostart:={autostart}")
    node = Managed(peer)
    if autostart == "true":
        peer.wait(lambda: bool(peer.messages["gear_monitor/mesh_force"]), "forces of the simulated bench")
        assert node.state() == "active"
    else:
        assert node.state() == "unconfigured"
        assert not peer.warnings()
        assert node.change("configure"), "whoever wants may lead it"
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 0, words(tmp_path)
    assert "Traceback" not in words(tmp_path)


@pytest.mark.ros
@pytest.mark.skipif(not REAL_RCLPY, reason="ROS 2 is not sourced")
def test_a_monitor_that_dies_is_started_again_and_led_to_active(launch: Launch, peer: Peer, tmp_path: Path) -> None:
    launch("record:=false", "simulate:=false", "respawn:=true")
    peer.wait(lambda: bool(peer.warnings()), "the first monitor")
    (pid,) = _monitors_of(tmp_path)
    os.kill(pid, signal.SIGKILL)
    peer.wait(lambda: set(_monitors_of(tmp_path)) - {pid} != set(), "the next process")
    peer.warnings().clear()
    peer.wait(lambda: bool(peer.warnings()), "the words of the next monitor")
    assert Managed(peer).state() == "active"


@pytest.mark.ros
@pytest.mark.skipif(not REAL_RCLPY, reason="ROS 2 is not sourced")
def test_one_that_cannot_be_configured_ends_the_launch_with_its_sentence(launch: Launch, tmp_path: Path) -> None:
    process = launch("record:=false", "simulate:=false", "system:=/nowhere.yaml")
    process.wait(90)
    assert "/nowhere.yaml" in words(tmp_path)
    assert "could not be configured" in words(tmp_path)


@pytest.mark.ros
@pytest.mark.skipif(not REAL_RCLPY, reason="ROS 2 is not sourced")
def test_a_namespace_holds_nodes_and_topics(launch: Launch, peer: Peer) -> None:
    launch("record:=false", "namespace:=cell3")
    expected = {"/cell3/gear_monitor/mesh_force", "/cell3/motor/speed", "/diagnostics"}
    peer.wait(lambda: expected <= {name for name, _ in peer.node.get_topic_names_and_types()}, "the topics")
    assert Managed(peer, "/cell3/gear_monitor").state() in ("inactive", "active")


@pytest.mark.ros
@pytest.mark.skipif(
    program("diagnostic_aggregator", "aggregator_node") is None, reason="diagnostic_aggregator is not installed"
)
def test_the_aggregator_that_it_starts_hears_the_nodes_of_a_namespace(launch: Launch, peer: Peer) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    heard: set[str] = set()

    def hear(message: DiagnosticArray) -> None:
        heard.update(each.name for each in message.status)

    peer.node.create_subscription(DiagnosticArray, "/diagnostics_agg", hear, 10)
    launch("record:=false", "namespace:=cell3", f"diagnostics:={AGGREGATED}")
    wanted = {f"/seat bench/{part}/cell3 gear_monitor: {part}" for part in ("qos", "warning")}
    peer.wait(lambda: wanted <= heard, "the groups")


def _monitors_of(folder: Path) -> list[int]:
    """Return the monitors that run in a test's folder, which no other's do."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            command, place = (entry / "cmdline").read_bytes(), (entry / "cwd").readlink()
        except OSError:
            continue
        if f"{PACKAGE}.nodes.monitor".encode() in command and place == folder:
            found.append(int(entry.name))
    return found


def test_the_aggregator_has_a_place_for_every_part() -> None:
    groups = yaml.safe_load(AGGREGATED.read_text(encoding="utf-8"))["analyzers"]["ros__parameters"]
    places = [text for group in groups.values() if isinstance(group, dict) for text in group["contains"]]
    parts = [f"gear_monitor: {part}" for part in ("input", "solver", "warning", "qos")]
    assert sorted(places) == sorted([*parts, "bench_recorder: recording"])
