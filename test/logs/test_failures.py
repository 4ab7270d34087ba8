"""Kills, full disks, vanished folders: what was synced stays, nothing else is claimed, nothing crashes."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml
from rosbags.highlevel import AnyReader

from seat_gear_dynamics.logs import disk
from seat_gear_dynamics.logs.counters import Counters
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.topics import FLOAT64
from seat_gear_dynamics.logs.writer import BagWriter

NewLog = Callable[..., BagWriter]
MILLISECOND = 1_000_000
ROOT = Path(__file__).resolve().parents[2]

# Writes 1 kB messages that no codec can shrink, the number of each in its first bytes; tells after each sync
# (or failure) how many are safe.
SCRIPT = """
import random, resource, sys
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.writer import BagWriter
directory, limit, interval = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
log = BagWriter(directory, system_text="", system_hash="", software_version="0", chunk_size=20_000,
                sync_interval_s=interval)
log.add_topic("/a", "std_msgs/msg/Float64")
source, safe, errors = random.Random(1), 0, []
for i in range(5_000_000):
    try:
        log.write("/a", i.to_bytes(8, "little") + source.randbytes(1000), (1 + i) * 1_000_000, 0)
    except LogError as error:
        errors.append(error)
    if errors and i == 5000:
        break
    if log.counters["/a"].written != safe:
        safe = log.counters["/a"].written
        print(safe, flush=True)
log.close()
print(*errors, sep="|")
print(*log.counters["/a"])
"""


def start(directory: Path, limit: int = 0, interval: float = 0.05) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", SCRIPT, str(directory), str(limit), str(interval)]
    return subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)


def numbers(path: Path) -> list[int]:
    return [int.from_bytes(message.data[:8], "little") for message in Bag(path).messages()]


def claimed(directory: Path) -> int:
    text = (directory / "metadata.yaml").read_text()
    return int(yaml.safe_load(text)["rosbag2_bagfile_information"]["message_count"])


def fill(log: BagWriter, begin: int, end: int) -> None:
    for i in range(begin, end):
        log.write("/a", i.to_bytes(8, "little") + os.urandom(1000), (1 + i) * MILLISECOND, 0)


@pytest.fixture
def tmpfs(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    """Mount small file systems at `tmp_path/small`; needs the right to mount."""
    folder = tmp_path / "small"
    folder.mkdir()

    def mount(options: str) -> Path:
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
        if subprocess.run(command, capture_output=True, check=False).returncode:
            pytest.skip("mounting a file system is not permitted here")
        return folder

    yield mount
    subprocess.run(["umount", "-l", str(folder)], capture_output=True, check=False)


@pytest.mark.parametrize("lines", [1, 3, 10, 40])
def test_a_killed_writer_leaves_all_it_had_synced(tmp_path: Path, lines: int) -> None:
    directory = tmp_path / "log"
    with start(directory) as process:
        assert process.stdout is not None
        safe = [int(process.stdout.readline()) for _ in range(lines)][-1]
        process.kill()
    found = numbers(directory)
    assert len(found) >= safe > 0
    assert found == list(range(len(found)))
    assert safe <= claimed(directory) <= len(found)
    bag = Bag(directory)
    assert not bag.closed
    assert bag.topics["/a"].count == len(found)
    # Only a kill in the middle of a write leaves an end that strict readers refuse.
    if bag.damage is None:
        with AnyReader([directory]) as reader:
            assert sum(1 for _ in reader.messages()) == len(found)


@pytest.mark.parametrize("limit", [60_000, 200_001, 1_000_000])
def test_a_file_that_may_not_grow_ends_at_its_last_sync(tmp_path: Path, limit: int) -> None:
    directory = tmp_path / "log"
    with start(directory, limit) as process:
        output, _ = process.communicate()
    *_, errors, counts = output.strip().split("\n")
    received, written, dropped = map(int, counts.split())
    assert errors.count("|") == 0
    assert f"The log {directory} has stopped: File too large" in errors
    assert received == 5001
    assert written + dropped == received
    assert 0 < written < received
    assert numbers(directory) == list(range(written))
    assert claimed(directory) == written
    assert Bag(directory).damage is None
    assert "File too large" in Bag(directory).custom_data["failure"]
    with AnyReader([directory]) as reader:
        assert sum(1 for _ in reader.messages()) == written


def test_a_full_disk_is_a_sentence_and_keeps_what_was_synced(new_log: NewLog, tmpfs: Callable[[str], Path]) -> None:
    directory = tmpfs("size=512k") / "log"
    log = new_log(directory, chunk_size=20_000, sync_interval_s=0.05)
    log.add_topic("/a", FLOAT64)
    with pytest.raises(LogError, match=rf"The log {directory} has stopped: No space left.*new log"):
        fill(log, 0, 10_000)
    assert log.failure is not None
    received, written, dropped = log.counters["/a"]
    assert written + dropped == received
    assert received - written <= 51
    assert not log.write("/a", b"", 10**12, 0)
    log.sync(10**12)
    assert log.split(10**12) is None
    log.close()
    assert log.counters["/a"] == Counters(received + 1, written, dropped + 1)
    assert numbers(directory) == list(range(written))
    assert claimed(directory) <= written


def test_a_full_disk_at_the_end_keeps_the_data_without_the_summary(
    new_log: NewLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = new_log()
    log.add_topic("/a", FLOAT64)
    fill(log, 0, 100)
    put, calls = disk.DurableFile._put, [0]

    def full(file: disk.DurableFile, data: bytes) -> None:
        calls[0] += 1
        if calls[0] > 2:  # the last chunk with its index, and its ending have found room
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        put(file, data)

    monkeypatch.setattr(disk.DurableFile, "_put", full)
    with pytest.raises(LogError, match="No space left on device"):
        log.close()
    assert log.counters["/a"] == Counters(100, 100, 0)
    assert numbers(log.directory) == list(range(100))
    assert claimed(log.directory) == 100
    assert not Bag(log.directory).closed


@pytest.mark.parametrize("moment", ["sync", "split", "close"])
def test_a_disk_that_refuses_to_sync_is_never_believed(
    new_log: NewLog, monkeypatch: pytest.MonkeyPatch, moment: str
) -> None:
    log = new_log()
    log.add_topic("/a", FLOAT64)
    fill(log, 0, 10)
    log.sync(0)
    fill(log, 10, 20)

    def refuse(_: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(LogError, match=r"Input/output error\. 10 messages since the last sync are lost"):
        log.close() if moment == "close" else getattr(log, moment)(10**9)
    monkeypatch.undo()
    assert log.counters["/a"] == Counters(20, 10, 10)
    assert numbers(log.directory) == list(range(10))
    assert claimed(log.directory) == 10


@pytest.mark.parametrize("moment", ["sync", "split", "close"])
def test_a_removed_folder_is_noticed(new_log: NewLog, moment: str) -> None:
    log = new_log()
    log.add_topic("/a", FLOAT64)
    fill(log, 0, 10)
    for path in log.directory.iterdir():
        path.unlink()
    log.directory.rmdir()
    with pytest.raises(LogError, match=r"has stopped: the file has been deleted.*log_0.mcap.*10 messages"):
        log.close() if moment == "close" else getattr(log, moment)(10**9)
    fill(log, 10, 12)
    assert log.counters["/a"] == Counters(12, 0, 12)
    assert not log.directory.exists()


def test_a_file_that_cannot_be_begun_is_not_part_of_the_bag(new_log: NewLog) -> None:
    log = new_log()
    log.add_topic("/a", FLOAT64)
    fill(log, 0, 10)
    (log.directory / "log_1.mcap").mkdir()  # in the way
    with pytest.raises(LogError, match="File exists"):
        log.split(10**9)
    (log.directory / "log_1.mcap").rmdir()
    assert [path.name for path in log.files] == ["log_0.mcap"]
    assert numbers(log.directory) == list(range(10))
    with AnyReader([log.directory]) as reader:
        assert sum(1 for _ in reader.messages()) == 10


def test_the_message_that_meets_a_failing_split_is_counted_as_dropped(new_log: NewLog) -> None:
    log = new_log(max_duration_s=0.01)
    log.add_topic("/a", FLOAT64)
    (log.directory / "log_1.mcap").mkdir()  # in the way
    with pytest.raises(LogError, match=r"File exists.* 1 messages since"):
        fill(log, 0, 20)
    assert log.counters["/a"] == Counters(11, 10, 1)
    assert numbers(log.directory) == list(range(10))


def test_a_folder_that_cannot_be_written_to_is_a_sentence(
    new_log: NewLog, tmp_path: Path, tmpfs: Callable[[str], Path]
) -> None:
    if os.geteuid() == 0:  # permission bits mean nothing to root
        folder, cause = tmpfs("ro"), "Read-only file system"
    else:
        folder, cause = tmp_path / "closed", "Permission denied"
        folder.mkdir(mode=0o555)
    with pytest.raises(LogError, match=rf"log cannot be created: {cause} .*Choose a folder"):
        new_log(folder / "log")


def test_a_disk_too_small_for_a_beginning_is_a_sentence(new_log: NewLog, tmpfs: Callable[[str], Path]) -> None:
    folder = tmpfs("size=4k")  # a page: the text of the system does not fit
    with pytest.raises(LogError, match="cannot be created: No space left"):
        new_log(folder / "log", system_text="x" * 10_000)
    assert list(folder.rglob("*.mcap")) == []


def test_replacing_a_text_leaves_the_old_one_when_the_disk_is_full(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "metadata.yaml"
    disk.replace_text(path, "old")

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        disk.replace_text(path, "new")
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("metadata.yaml", "old")]
