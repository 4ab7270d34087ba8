"""The recorder as a process meets its hard ends: kills, two on one folder, folders that vanish, disks that fill."""

import shutil
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from harness import Peer, Processes
from recorder_control import Control

from seat_gear_dynamics.logs.reader import Bag

WARN, ERROR = 1, 2
MB = 1_000_000


@pytest.fixture
def control(peer: Peer) -> Control:
    return Control(peer)


@pytest.fixture
def tmpfs(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    """Mount a small file system at `tmp_path/small`; needs the right to mount."""
    folder = tmp_path / "small"
    folder.mkdir()

    def mount(options: str) -> Path:
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
        if subprocess.run(command, capture_output=True, check=False).returncode:
            pytest.skip("mounting a file system is not permitted here")
        return folder

    yield mount
    subprocess.run(["umount", "-l", str(folder)], capture_output=True, check=False)


def send(peer: Peer, number: int) -> None:
    for i in range(number):
        peer.drive(500.0 + i)


def test_a_killed_recorder_leaves_what_it_said_was_written(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log, sync_interval=0.1)
    peer.wait_for_subscriber("motor/speed")
    send(peer, 150)
    control.wait_count("motor/speed written", 100)
    written = int(control.values()["motor/speed written"])
    processes.end(recorder, signal.SIGKILL)
    bag = Bag(log)
    assert not bag.closed
    assert bag.topics["/motor/speed"].count >= written
    again = processes.node("recorder", output=log)
    assert again.wait(60) == 1
    assert "exists already" in processes.words(again), "the log of the killed one is left alone"
    assert Bag(log).topics["/motor/speed"].count >= written


def test_of_two_recorders_told_one_folder_the_second_is_refused_and_the_first_goes_on(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    both = [processes.node("recorder", output=log) for _ in range(2)]
    peer.wait(lambda: any(each.poll() is not None for each in both), "one of the two to give up")
    peer.wait_for_subscriber("motor/speed")
    ended, running = sorted(both, key=lambda each: each.poll() is None)
    assert ended.poll() == 1
    words = processes.words(ended)
    assert "exists already; choose another name" in words
    assert "Traceback" not in words
    send(peer, 20)
    control.wait_received(20)
    assert processes.end(running) == 0
    assert Bag(log).topics["/motor/speed"].count == 20
    assert Bag(log).closed


def test_a_folder_removed_underneath_is_an_error_and_the_node_goes_on(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log)
    peer.wait_for_subscriber("motor/speed")
    send(peer, 10)
    control.wait_count("motor/speed written", 10)
    shutil.rmtree(log)
    send(peer, 5)
    control.wait_level(ERROR, "the file has been deleted")
    control.wait_count("motor/speed dropped", 5)
    started = control.call("start")
    assert started.success, started.message
    assert started.message.endswith("run_run2")
    send(peer, 7)
    control.wait_received(22)
    assert processes.end(recorder) == 0
    assert Bag(tmp_path / "run_run2").topics["/motor/speed"].count == 7
    assert not log.exists()


def test_a_disk_that_fills_is_warned_of_and_the_log_is_ended_whole(
    processes: Processes, peer: Peer, control: Control, tmpfs: Callable[[str], Path]
) -> None:
    disk = tmpfs("size=20m")
    log = disk / "run"
    recorder = processes.node("recorder", output=log, disk_reserve_bytes=5 * MB)
    peer.wait_for_subscriber("motor/speed")
    send(peer, 30)
    control.wait_count("motor/speed written", 30)
    (disk / "other").write_bytes(bytes(13 * MB))
    control.wait_level(WARN, "the disk is nearly full")
    (disk / "more").write_bytes(bytes(4 * MB))
    control.wait_level(ERROR, "was ended because its disk is full")
    assert recorder.poll() is None
    assert not control.call("start").success, "there is no room for another"
    bag = Bag(log)
    assert bag.closed
    assert bag.topics["/motor/speed"].count == 30
    (disk / "other").unlink()
    peer.wait(lambda: float(control.values()["disk free (MB)"]) > 10, "the recorder to see the room")
    assert control.call("start").success
    assert processes.end(recorder) == 0
    assert Bag(disk / "run_run2").closed


def test_a_disk_that_is_full_at_once_keeps_what_was_synced(
    processes: Processes, peer: Peer, control: Control, tmpfs: Callable[[str], Path]
) -> None:
    disk = tmpfs("size=2m")
    log = disk / "run"
    recorder = processes.node("recorder", output=log, disk_reserve_bytes=0, disk_warn_seconds=0.0)
    peer.wait_for_subscriber("motor/speed")
    send(peer, 30)
    control.wait_count("motor/speed written", 30)
    with pytest.raises(OSError, match="No space left"):
        (disk / "other").write_bytes(bytes(3 * MB))
    send(peer, 3000)
    control.wait_level(ERROR, "log")
    assert recorder.poll() is None
    assert processes.end(recorder) == 0
    assert "Traceback" not in processes.words(recorder)
    assert Bag(log).topics["/motor/speed"].count >= 30
    assert Bag(log).damage is None


def test_a_read_only_folder_is_one_sentence(processes: Processes, tmpfs: Callable[[str], Path]) -> None:
    recorder = processes.node("recorder", output=tmpfs("ro") / "run")
    assert recorder.wait(60) == 1
    words = processes.words(recorder)
    assert "cannot be created: Read-only file system" in words
    assert "Traceback" not in words


def test_files_are_let_go_as_new_ones_are_begun(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log, keep_files=2, preset="none")
    peer.wait_for_subscriber("motor/speed")
    for k in range(4):
        send(peer, 10)
        control.wait_received(10 * (k + 1))
        assert control.call("split").success
    assert processes.end(recorder) == 0
    # The last finished one and the one that was being written.
    assert sorted(path.name for path in log.glob("*.mcap")) == ["run_3.mcap", "run_4.mcap"]
    assert Bag(log).topics["/motor/speed"].count == 10
