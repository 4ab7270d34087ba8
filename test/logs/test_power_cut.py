"""Power cuts: copies of a log cut at any byte, or filled with zeros behind it, hold whatever had been synced before.

What fsync has returned for is on the disk; of what was written later any beginning may be, and a file system may show
zeros where it had noted a length but not yet the data.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from seat_gear_dynamics.logs.disk import DurableFile
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.topics import FLOAT64
from seat_gear_dynamics.logs.writer import BagWriter

NewLog = Callable[..., BagWriter]
MILLISECOND = 1_000_000
STRIDE = 5
"""Bytes between two cuts: what is claimed holds for every byte, the stride only saves time."""


def numbers(path: Path) -> list[int]:
    return [int.from_bytes(message.data[:8], "little") for message in Bag(path).messages()]


@pytest.fixture
def images(new_log: NewLog, monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int, bytes]]:
    """Return (messages synced before, bytes synced before, all bytes) of a file right before each of its fsyncs."""
    taken: list[tuple[int, int, bytes]] = []
    safe, size = 0, 0
    sync = DurableFile.sync

    def noting(file: DurableFile) -> None:
        nonlocal size
        content = file.path.read_bytes()
        taken.append((safe, size, content))
        sync(file)
        size = len(content)

    monkeypatch.setattr(DurableFile, "sync", noting)
    log = new_log(chunk_size=150, compression="zstd", sync_interval_s=0.02)
    log.add_topic("/a", FLOAT64)
    for k in range(60):
        log.write("/a", k.to_bytes(8, "little") + bytes(8), (1 + k) * MILLISECOND, 0)
        safe = log.counters["/a"].written
    log.close()
    taken.append((60, size, log.files[0].read_bytes()))
    return taken


def test_a_copy_cut_at_any_byte_behind_the_last_sync_holds_all_that_was_synced(
    images: list[tuple[int, int, bytes]], tmp_path: Path
) -> None:
    copy = tmp_path / "copy.mcap"
    tried = 0
    for safe, size, content in images:
        # Until the first message is synced nothing is owed; behind it the ending (45 bytes) may be overwritten.
        for end in range(max(size - 45, 0), len(content) + 1, STRIDE):
            if safe == 0:
                break
            copy.write_bytes(content[:end])
            found = numbers(copy)
            assert found == list(range(len(found)))
            assert len(found) >= safe, f"cut at byte {end} of {len(content)}"
            tried += 1
    assert tried > 200


def test_a_finished_file_cut_at_any_byte_gives_a_beginning_of_its_messages(
    images: list[tuple[int, int, bytes]], tmp_path: Path
) -> None:
    whole, copy = images[-1][2], tmp_path / "copy.mcap"
    most = 0
    for end in [*range(0, len(whole), STRIDE), len(whole)]:
        copy.write_bytes(whole[:end])
        try:
            found = numbers(copy)
        except LogError:
            found = []
        assert found == list(range(len(found)))
        assert len(found) >= most, "a longer beginning holds no less"
        most = len(found)
    assert most == 60


def test_zeros_behind_what_was_synced_do_no_harm(images: list[tuple[int, int, bytes]], tmp_path: Path) -> None:
    copy = tmp_path / "copy.mcap"
    tried = 0
    for safe, size, content in images:
        if safe == 0:
            continue
        for begin in range(size, len(content), 4 * STRIDE):
            copy.write_bytes(content[:begin] + bytes(len(content) - begin + 4096))
            found = numbers(copy)
            assert found == list(range(len(found)))
            assert len(found) >= safe
            tried += 1
    assert tried > 20
