"""`seat-gear bench` end to end: three processes over DDS, a live view, a log, a report."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest
from domains import fresh_domain
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from seat_gear_dynamics.commands import main
from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.logs.analysis.band_source import band_source
from seat_gear_dynamics.logs.analysis.rerun import rerun
from seat_gear_dynamics.logs.analysis.what_if import recorded_bands
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.run import read_run
from seat_gear_dynamics.logs.topics import DIAGNOSTICS, TOPICS
from seat_gear_dynamics.sensing import packaged_map

BENCH = [sys.executable, "-m", "seat_gear_dynamics", "bench"]


@pytest.fixture(scope="module")
def environment() -> dict[str, str]:
    return {**os.environ, "ROS_DOMAIN_ID": str(fresh_domain())}


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory, environment: dict[str, str]) -> tuple[Path, dict[str, Any]]:
    """One bounded run that all checks below look at."""
    log = tmp_path_factory.mktemp("bench") / "run"
    command = [*BENCH, "--duration", "12", "--profile", "up-down", "--output", str(log), "--json"]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240)
    assert ended.returncode == 0, ended.stderr
    assert len(ended.stdout.strip().splitlines()) == 1, "one JSON object and nothing else"
    return log, json.loads(ended.stdout)


def test_the_summary_is_one_json_object(done: tuple[Path, dict[str, Any]]) -> None:
    log, summary = done
    assert summary["ended"] == "duration"
    assert summary["log"] == str(log)
    assert summary["damage"] is None
    assert summary["warning_time"]["OK"] > 0
    assert summary["warning_time"]["WARN"] > 0, "the ramp to 1300 r/min ends near a band"
    assert Path(summary["report"]).read_bytes().startswith(b"\x89PNG")


def test_the_log_opens_with_rosbags_and_has_every_declared_topic(done: tuple[Path, dict[str, Any]]) -> None:
    with AnyReader([done[0]]) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        for topic in TOPICS:
            assert counts.get(topic.absolute(), 0) > 0, topic.name
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)


def test_the_log_opens_with_mcap_and_its_counts_are_those_of_its_metadata(done: tuple[Path, dict[str, Any]]) -> None:
    with (done[0] / "run_0.mcap").open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == sum(1 for _ in reader.iter_messages())
        assert reader.get_header().profile == "ros2"


def test_no_topic_has_a_gap_longer_than_two_publish_periods(done: tuple[Path, dict[str, Any]]) -> None:
    periods = {
        "/motor/speed": 0.02,
        "/load/torque": 0.02,
        "/joint_states": 0.02,
        "/gear_monitor/mesh_state": 0.02,
        "/gear_monitor/mesh_force": 0.02,
        "/gear_monitor/poincare": 0.1,
        "/gear_monitor/chaos_warning": 0.1,
        "/gear_monitor/in_forbidden_band": 0.1,
        DIAGNOSTICS.name: 1.0,
    }
    flows = {flow.topic: flow for flow in read_run(done[0]).flows}
    gaps = {topic: flows[topic].longest_gap / period for topic, period in periods.items()}
    assert max(gaps.values()) <= 2.0, gaps


def test_a_replay_gives_the_logged_forces_bit_for_bit(done: tuple[Path, dict[str, Any]]) -> None:
    result = rerun(done[0], load_train())
    assert result.messages > 100
    assert result.first_difference is None
    assert result.equal == result.messages


def test_ctrl_c_ends_an_open_run_on_a_map_cleanly_with_a_complete_log(
    tmp_path: Path, environment: dict[str, str]
) -> None:
    log = tmp_path / "run"
    process = subprocess.Popen(
        [*BENCH, "--output", str(log), "--profile", "dwell-in-band", "--map", "packaged"],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    lines = 0
    for line in process.stdout:  # a line a second once the bench runs
        lines += " r/min  " in line
        if lines == 3:
            break
    process.send_signal(signal.SIGINT)
    rest, errors = process.communicate(timeout=60)
    assert process.returncode == 0, errors
    assert "report:" in rest
    assert "Traceback" not in rest + errors
    bag = Bag(log)
    assert bag.closed
    assert bag.damage is None
    assert all(bag.topics[topic.absolute()].count > 0 for topic in TOPICS)
    assert recorded_bands(bag) == band_source(load_train(), packaged_map(), None).label


def test_a_map_that_is_none_is_refused_before_anything_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "run"
    (tmp_path / "map.npz").write_bytes(b"no map")
    assert main(["bench", "--output", str(log), "--map", str(tmp_path / "map.npz")]) == 1
    assert "map.npz cannot be used" in capsys.readouterr().err
    assert not log.exists()


def test_a_node_that_dies_ends_the_run_with_a_sentence_and_a_closed_log(
    tmp_path: Path, environment: dict[str, str]
) -> None:
    log = tmp_path / "run"
    process = subprocess.Popen(
        [*BENCH, "--output", str(log)], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    for line in process.stdout:
        if " r/min  " in line:
            break
    monitor = child_of(process.pid, "seat_gear_dynamics.nodes.monitor")
    os.kill(monitor, signal.SIGKILL)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "The monitor ended by itself" in errors
    assert Bag(log).closed


def child_of(parent: int, name: str) -> int:
    begin = monotonic()
    while monotonic() - begin < 10:
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    command = (entry / "cmdline").read_text()
                    status = (entry / "status").read_text()
                except OSError:
                    continue
                if name in command and f"PPid:\t{parent}\n" in status:
                    return int(entry.name)
        sleep(0.05)
    raise AssertionError(f"no child {name} of {parent}")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--profile", "sideways"], "choose one of up-down"),
        (["--duration", "-3"], "expected more than 0"),
        (["--duration", "nan"], "expected more than 0"),
        (["--system", "/nowhere.yaml"], "cannot be read"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_starts(arguments: list[str], sentence: str, tmp_path: Path) -> None:
    ended = subprocess.run([*BENCH, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert ended.returncode == 1
    assert sentence in ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_an_existing_log_is_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    command = [*BENCH, "--output", str(tmp_path / "run")]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert ended.returncode == 1
    assert "exists already" in ended.stderr
