"""The journal of a long computation: whatever a crash leaves, it goes on from what is whole, or says why it cannot."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.commands import journal as journal_module
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.commands.journal import Journal

IDENTITY = {"the sweep's": {"points": 3, "range": (1.0, 2.0)}, "the program's": {"package": "1"}}


class Clock:
    """A clock that goes on when it is told to."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def paths(tmp_path: Path) -> list[Path]:
    return [tmp_path / "f.csv", tmp_path / "f_points.csv"]


def journal(paths: list[Path], **changed: Any) -> Journal:
    asked: dict[str, Any] = {"output": paths[0], "files": paths, "identity": IDENTITY, "clock": Clock(), **changed}
    return Journal(**asked)


def entry(number: int) -> tuple[bytes, bytes]:
    return f"row {number}\n".encode(), f"point {number}\n".encode() * number


def filled(paths: list[Path], count: int) -> None:
    """Leave a journal of `count` entries as an interruption leaves it."""
    with journal(paths) as open_journal:
        for number in range(count):
            open_journal.add(entry(number), {"rows": number + 1})


def test_what_was_added_is_in_the_files_and_the_note_goes_with_the_end(paths: list[Path]) -> None:
    with journal(paths) as open_journal:
        for number in range(3):
            open_journal.add(entry(number), {"rows": number + 1})
        assert open_journal.note.name == "f.csv.part"
        open_journal.finish()
    assert [path.read_bytes() for path in paths] == [
        b"".join(parts) for parts in zip(*map(entry, range(3)), strict=True)
    ]
    assert not open_journal.note.exists()


def test_it_goes_on_behind_what_an_interruption_left(paths: list[Path]) -> None:
    filled(paths, 2)
    with journal(paths) as again:
        assert again.reached == {"rows": 2}
        again.add(entry(2), {"rows": 3})
        again.finish()
    assert paths[0].read_bytes() == b"row 0\nrow 1\nrow 2\n"


def test_files_without_a_note_are_begun_anew(paths: list[Path]) -> None:
    paths[0].write_bytes(b"of an earlier run that was completed")
    with journal(paths) as fresh:
        assert fresh.reached == {}
    assert paths[0].read_bytes() == b""


@given(st.integers(0, 4), st.binary(max_size=40), st.binary(max_size=40))
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])  # each waits for the disk
def test_what_lies_behind_the_note_is_cut_off(paths: list[Path], count: int, torn: bytes, more: bytes) -> None:
    # A killed program leaves what it wrote after its last note, whole entries and torn ones.
    paths[0].with_name("f.csv.part").unlink(missing_ok=True)
    filled(paths, count)
    for path, tail in zip(paths, (torn, more), strict=True):
        path.write_bytes(path.read_bytes() + tail)
    with journal(paths) as again:
        assert again.reached.get("rows", 0) == count
        again.finish()
    assert paths[1].read_bytes() == b"".join(entry(number)[1] for number in range(count))


def test_a_note_is_written_a_second_after_the_last_and_at_the_end(paths: list[Path]) -> None:
    clock = Clock()

    def noted() -> Any:
        return json.loads(paths[0].with_name("f.csv.part").read_text())["reached"]

    with journal(paths, clock=clock) as open_journal:
        open_journal.add(entry(0), {"rows": 1})
        assert noted() == {}
        clock.now = journal_module.NOTE_INTERVAL
        open_journal.add(entry(1), {"rows": 2})
        assert noted() == {"rows": 2}
        open_journal.add(entry(2), {"rows": 3})
        assert noted() == {"rows": 2}
    assert noted() == {"rows": 3}


def test_an_interruption_in_the_middle_of_an_entry_leaves_it_out(
    paths: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> int:
        raise KeyboardInterrupt

    with journal(paths) as open_journal:
        open_journal.add(entry(1), {"rows": 1})
        monkeypatch.setattr(journal_module, "crc32", interrupted)  # both files are written, nothing is taken over yet
        with pytest.raises(KeyboardInterrupt):
            open_journal.add(entry(2), {"rows": 2})
    monkeypatch.undo()
    with journal(paths) as again:
        assert again.reached == {"rows": 1}
    assert [path.read_bytes() for path in paths] == list(entry(1))


def test_a_full_disk_leaves_what_the_note_before_says(paths: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    clock = Clock()
    with journal(paths, clock=clock) as open_journal:
        clock.now = journal_module.NOTE_INTERVAL
        open_journal.add(entry(1), {"rows": 1})
        monkeypatch.setattr(os, "fsync", full)
        clock.now *= 2
        with pytest.raises(OSError, match="No space left"):
            open_journal.add(entry(2), {"rows": 2})
    monkeypatch.undo()
    with journal(paths) as again:
        assert again.reached == {"rows": 1}
    assert [path.read_bytes() for path in paths] == list(entry(1))


def shortened(paths: list[Path]) -> None:
    paths[1].write_bytes(paths[1].read_bytes()[:-1])


def edited(paths: list[Path]) -> None:
    paths[0].write_bytes(paths[0].read_bytes().replace(b"1", b"7"))


def removed(paths: list[Path]) -> None:
    paths[0].unlink()


def torn_note(paths: list[Path]) -> None:
    paths[0].with_name("f.csv.part").write_text('{"format": 1, "fil')


def other_note(paths: list[Path]) -> None:
    paths[0].with_name("f.csv.part").write_text('{"format": 7, "files": []}')


@pytest.mark.parametrize(
    ("harm", "sentence"),
    [
        (shortened, r"f_points.csv is not what .*f.csv.part says that was written .its first 24 bytes differ"),
        (edited, "f.csv is not what"),
        (removed, "f.csv is not what"),
        (torn_note, "f.csv.part cannot be read"),
        (other_note, "cannot be read .format 7, expected 1"),
    ],
)
def test_files_that_are_not_what_the_note_says_are_refused_until_a_restart(
    paths: list[Path], harm: Callable[[list[Path]], None], sentence: str
) -> None:
    filled(paths, 3)
    harm(paths)
    with pytest.raises(CommandError, match=sentence) as refused:
        journal(paths)
    assert "--restart" in str(refused.value)
    with journal(paths, restart=True) as fresh:
        assert fresh.reached == {}
    assert paths[0].read_bytes() == b""


@pytest.mark.parametrize(
    ("identity", "words"),
    [
        ({**IDENTITY, "the sweep's": {"points": 4, "range": (1.0, 2.0)}}, "the sweep's points was 3, now 4"),
        ({**IDENTITY, "the sweep's": {"points": 3, "range": (1.0, 3.0)}}, r"range was \[1.0, 2.0\], now \[1.0, 3.0\]"),
        ({"the sweep's": IDENTITY["the sweep's"]}, "the program's package was 1, now None"),
        ({**IDENTITY, "the system's": {"load": 1.0}}, "the system's load was None, now 1.0"),
    ],
)
def test_another_computation_is_refused_in_words_and_left_as_it_is(
    paths: list[Path], identity: dict[str, dict[str, Any]], words: str
) -> None:
    filled(paths, 2)
    before = [path.read_bytes() for path in paths]
    with pytest.raises(CommandError, match=words):
        journal(paths, identity=identity)
    assert [path.read_bytes() for path in paths] == before
    with journal(paths) as own:
        assert own.reached == {"rows": 2}


def test_files_that_another_program_writes_are_left_alone(paths: list[Path]) -> None:
    with journal(paths) as first:
        first.add(entry(1), {"rows": 1})
        with pytest.raises(CommandError, match=r"f.csv is being written by another program"):
            journal(paths, restart=True)
        first.finish()
    assert [path.read_bytes() for path in paths] == list(entry(1))
