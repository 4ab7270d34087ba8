"""Circular retention, and presets."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from rosbags.highlevel import AnyReader

from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.limits import Limits
from seat_gear_dynamics.logs.presets import PRESETS, codec, preset
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.topics import BOOL, FLOAT64, IN_FORBIDDEN_BAND
from seat_gear_dynamics.logs.writer import BagWriter

NewLog = Callable[..., BagWriter]
SECOND = 1_000_000_000


def fill(log: BagWriter, seconds: int) -> None:
    log.add_topic("/a", FLOAT64)
    for k in range(seconds * 10):
        log.write("/a", k.to_bytes(8, "little") + os.urandom(100), 1 + k * SECOND // 10, 0)


def listed(directory: Path) -> list[str]:
    text = (directory / "metadata.yaml").read_text()
    return list(yaml.safe_load(text)["rosbag2_bagfile_information"]["relative_file_paths"])


def present(directory: Path) -> list[str]:
    return sorted(path.name for path in directory.glob("*.mcap"))


def test_only_the_last_files_are_kept_and_listed(new_log: NewLog) -> None:
    with new_log(max_duration_s=1.0, keep_files=3) as log:
        fill(log, 10)
    assert present(log.directory) == listed(log.directory) == ["log_7.mcap", "log_8.mcap", "log_9.mcap"]
    bag = Bag(log.directory)
    assert [int.from_bytes(m.data[:8], "little") for m in bag.messages()] == list(range(70, 100))
    assert bag.damage is None
    assert bag.custom_data["files let go"] == "7"
    assert bag.custom_data["messages of /a"] == "received 100, written 100, dropped 0"
    with AnyReader([log.directory]) as reader:
        assert sum(1 for _ in reader.messages()) == 30


def test_the_bytes_of_finished_files_stay_within_the_room(new_log: NewLog) -> None:
    with new_log(max_duration_s=1.0, keep_bytes=20_000, compression="none") as log:
        fill(log, 20)
        finished = log.files[:-1]
        assert sum(path.stat().st_size for path in finished) <= 20_000
        assert len(finished) >= 2
    assert present(log.directory) == sorted(listed(log.directory))


def test_metadata_never_lists_a_file_that_is_gone(new_log: NewLog, monkeypatch: pytest.MonkeyPatch) -> None:
    log = new_log(max_duration_s=1.0, keep_files=2)
    unlink = Path.unlink
    checked = 0

    def checking(path: Path, missing_ok: bool = False) -> None:
        nonlocal checked
        if path.suffix == ".mcap":
            assert path.name not in listed(log.directory)
            checked += 1
        unlink(path, missing_ok)

    monkeypatch.setattr(Path, "unlink", checking)
    fill(log, 6)
    log.close()
    assert checked == 4


def test_each_kept_file_still_begins_with_what_is_latched(new_log: NewLog) -> None:
    with new_log(max_duration_s=1.0, keep_files=2) as log:
        log.add_topic("/band", BOOL, IN_FORBIDDEN_BAND.qos)
        log.write("/band", b"\0\1\0\0\1", 1, 0)
        fill(log, 6)
    assert Bag(log.directory).topics["/band"].count == 2


def test_a_file_that_cannot_be_deleted_is_an_error_in_a_sentence(
    new_log: NewLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = new_log(max_duration_s=1.0, keep_files=1)

    def refuse(path: Path, missing_ok: bool = False) -> None:
        raise PermissionError(1, "Operation not permitted", str(path))

    monkeypatch.setattr(Path, "unlink", refuse)
    with pytest.raises(LogError, match=r"has stopped: Operation not permitted \(.*log_0.mcap\)"):
        fill(log, 4)


@pytest.mark.parametrize(
    ("limits", "sizes", "gone"),
    [
        ({}, [5, 5, 5], 0),
        ({"keep_files": 1}, [5, 5, 5], 2),
        ({"keep_files": 3}, [5, 5], 0),
        ({"keep_files": 3}, [5, 5, 5], 1),
        ({"keep_bytes": 10}, [5, 5, 5], 1),
        ({"keep_bytes": 1}, [5, 5, 5], 2),
        ({"keep_files": 9, "keep_bytes": 9}, [], 0),
    ],
)
def test_the_surplus_is_counted_from_the_oldest(limits: dict[str, int], sizes: list[int], gone: int) -> None:
    assert Limits(1, 1.0, None, None, **limits).surplus(sizes) == gone


@pytest.mark.parametrize("name", PRESETS)
def test_each_preset_writes_a_log_that_reads_back(new_log: NewLog, name: str) -> None:
    chosen = preset(name)
    with new_log(compression=chosen.compression, level=chosen.level, chunk_size=chosen.chunk_size) as log:
        fill(log, 5)
    assert len(list(Bag(log.directory).messages())) == 50


def test_presets_are_ordered_by_size_as_their_names_say() -> None:
    body = b"".join(b"%d %d;" % (k, k * k % 977) for k in range(20_000))
    sizes = {name: len(codec(p.compression, p.level)[1](body)) for name, p in PRESETS.items()}
    assert sizes["zstd_small"] < sizes["zstd_fast"] < sizes["fastwrite"] == sizes["none"] == len(body)


def test_an_unknown_preset_is_a_sentence() -> None:
    with pytest.raises(LogError, match="'tiny' is unknown; use one of none, fastwrite, zstd_fast, zstd_small"):
        preset("tiny")


@pytest.mark.parametrize("name", ["keep_files", "keep_bytes"])
def test_a_retention_of_nothing_is_refused(new_log: NewLog, name: str) -> None:
    with pytest.raises(LogError, match=f"{name} is 0; expected a number above 0"):
        new_log(**{name: 0})
