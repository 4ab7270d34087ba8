"""Sweeps and maps that were interrupted: the same command goes on, and its files are those of one that was not."""

import argparse
import json
import shlex
import signal
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from interrupted import ended_amid

from seat_gear_dynamics.cluster import build as build_module
from seat_gear_dynamics.commands import journal as journal_module
from seat_gear_dynamics.commands import map as map_command
from seat_gear_dynamics.commands import sweep
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.commands.journal import Journal
from seat_gear_dynamics.commands.map_files import MapFiles
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes import RegimeMap
from seat_gear_dynamics.regimes.map_nodes import MapGrid
from seat_gear_dynamics.regimes.workers import Threads

Run = Callable[[str], int]

COLD = "sweep --over load --start 100 --stop 300 --points 70 --transient 2 --periods 48"
BOTH = "sweep --over load --start 100 --stop 300 --points 4 --direction both --transient 2 --periods 48"
MAP = "map --speed-rpm 600 1100 40 --load 100 200 2 --transient 2 --periods 48"
DRAWN = f"{MAP} --samples 2 --seed 3"
FILES = {"sweep": ("csv", "_points.csv"), "map": ("npz",)}


def command(words: str) -> tuple[ModuleType, argparse.Namespace]:
    name, *rest = shlex.split(words)
    module = {"sweep": sweep, "map": map_command}[name]
    parser = argparse.ArgumentParser()
    parser.add_argument("--system")
    parser.add_argument("--json", action="store_true")
    module.add_arguments(parser)
    return module, parser.parse_args(rest)


@pytest.fixture
def run(train: GearTrain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run a command on the train of fixed parameters in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    Path("fixed.yaml").write_text(train.text, encoding="utf-8")

    def run_words(words: str) -> int:
        module, arguments = command(f"{words} --system fixed.yaml")
        return int(module.run(arguments))

    return run_words


def contents(folder: Path = Path()) -> dict[str, bytes]:
    """Return what stands in a folder, but for the description and pictures, which carry their date."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".csv", ".npz", ".part")}


@pytest.fixture
def interrupt(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Have Ctrl-C come when so many entries have been added to a journal, its first line included."""
    add = Journal.add

    def after(entries: int) -> None:
        left = iter(range(entries))

        def counted(self: Journal, parts: Any, reached: Any) -> None:
            if next(left, None) is None:
                raise KeyboardInterrupt
            add(self, parts, reached)

        monkeypatch.setattr(Journal, "add", counted)

    return after


@pytest.fixture
def resumed(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Have no further Ctrl-C."""
    add = Journal.add
    return lambda: monkeypatch.setattr(Journal, "add", add)


@pytest.mark.parametrize(
    ("words", "entries"),
    [(COLD, 0), (COLD, 1), (COLD, 41), (COLD, 70), (BOTH, 2), (BOTH, 5), (BOTH, 8), (MAP, 0), (MAP, 2), (DRAWN, 4)],
)
def test_the_same_command_goes_on_and_ends_with_the_same_bytes(
    run: Run,
    interrupt: Callable[[int], None],
    resumed: Callable[[], None],
    capsys: pytest.CaptureFixture[str],
    words: str,
    entries: int,
) -> None:
    output = "--output f.csv" if words.startswith("sweep") else "--output f.npz"
    run(f"{words} {output}")
    expected, said = contents(), capsys.readouterr().out
    for path in expected:
        Path(path).unlink()
    interrupt(entries)
    with pytest.raises(KeyboardInterrupt):
        run(f"{words} {output}")
    assert "; the same command goes on from there" in capsys.readouterr().err
    resumed()
    run(f"{words} {output}")
    assert contents() == expected
    assert capsys.readouterr().out == said


def test_nothing_is_computed_twice(
    run: Run, interrupt: Callable[[int], None], resumed: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    compute = Threads.compute

    def counted(self: Threads, work: Any, blocks: Any) -> Iterator[Any]:
        def told() -> Iterator[Any]:
            for block in blocks:
                asked.append(block)
                yield block

        return compute(self, work, told())

    interrupt(1 + 64)  # the heads, and 64 rows of 70
    with pytest.raises(KeyboardInterrupt):
        run(f"{COLD} --output f.csv")
    resumed()
    monkeypatch.setattr(Threads, "compute", counted)
    run(f"{COLD} --output f.csv")
    assert asked == [range(64, 70)]


def test_ctrl_c_says_how_far_it_came(
    run: Run, interrupt: Callable[[int], None], capsys: pytest.CaptureFixture[str]
) -> None:
    interrupt(1 + 3)
    with pytest.raises(KeyboardInterrupt):
        run(f"{BOTH} --output f.csv")
    assert capsys.readouterr().err == "interrupted at row 3 of 8; the same command goes on from there\n"
    interrupt(3)  # two blocks of 32 and one of 16 nodes are the nominal machine
    with pytest.raises(KeyboardInterrupt):
        run(f"{DRAWN} --output f.npz")
    assert "interrupted at node 80 of 80; the same" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "changed", "sentence"),
    [
        (COLD, COLD.replace("--points 70", "--points 71"), "the sweep's points was 70, now 71"),
        (COLD, f"{COLD} --damping 0.2", "the system's fingerprint was"),
        (COLD, f"{COLD} --frequency 0.6", "the system's frequency was 0.5, now 0.6"),
        (MAP, f"{MAP} --samples 1", "the map's samples was 0, now 1"),
    ],
)
def test_what_stands_of_another_run_is_refused_and_kept_until_a_restart(
    run: Run, interrupt: Callable[[int], None], resumed: Callable[[], None], words: str, changed: str, sentence: str
) -> None:
    output = "--output f.csv"
    interrupt(2)
    with pytest.raises(KeyboardInterrupt):
        run(f"{words} {output}")
    resumed()
    before = contents()
    with pytest.raises(CommandError, match=sentence):
        run(f"{changed} {output}")
    assert contents() == before
    run(f"{changed} {output} --restart")
    assert not Path("f.csv.part").exists()


def test_rows_of_another_build_are_not_gone_on_with(
    run: Run, interrupt: Callable[[int], None], resumed: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt(10)
    with pytest.raises(KeyboardInterrupt):
        run(f"{COLD} --output f.csv")
    resumed()
    other = {**build_module.build(), "sources": "edited since"}
    monkeypatch.setattr(build_module, "build", lambda: other)
    with pytest.raises(CommandError, match=r"the program's sources was .*, now edited since"):
        run(f"{COLD} --output f.csv")


@pytest.mark.parametrize(("number", "stands"), [(signal.SIGKILL, 0), (signal.SIGINT, 45)])
def test_a_sweep_that_was_killed_goes_on_from_what_is_on_disk(run: Run, number: int, stands: int) -> None:
    ended_amid(f"{COLD} --output f.csv --system fixed.yaml".split(), number, 45)
    # A killed program has its last note, which may be a second old; one that was asked to end writes a last one.
    assert json.loads(Path("f.csv.part").read_text())["reached"].get("rows", 0) >= stands
    # The row in hand may not have left the program yet; those before it have.
    assert len(Path("f.csv").read_bytes().splitlines()) >= 1 + 44
    run(f"{COLD} --output f.csv")
    resumed = contents()
    assert not Path("f.csv.part").exists()
    run(f"{COLD} --output whole.csv")
    assert contents()["whole.csv"] == resumed["f.csv"]
    assert contents()["whole_points.csv"] == resumed["f_points.csv"]


def test_a_note_stands_from_the_first_moment(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    # Killed before anything was found: the files are empty, and the same command still knows them for its own.
    def killed(*_: object) -> None:
        raise SystemExit

    monkeypatch.setattr(journal_module.Journal, "add", killed)
    with pytest.raises(SystemExit):
        run(f"{COLD} --output f.csv")
    assert json.loads(Path("f.csv.part").read_text())["reached"] == {}


def peak(run: Run, words: str) -> tuple[int, int]:
    """Return the most memory that Python held in a run, and how much it left on disk, bytes."""
    tracemalloc.start()
    try:
        run(words)
        return tracemalloc.get_traced_memory()[1], sum(map(len, contents().values()))
    finally:
        tracemalloc.stop()


def test_rows_are_let_go_once_they_are_written(run: Run) -> None:
    words = "sweep --over load --start 100 --stop 300 --transient 0 --periods 48 --json --output f.csv --points"
    run(f"{words} 256")  # whatever is loaded and kept once
    (low, small), (high, large) = (peak(run, f"{words} {points}") for points in (256, 1024))
    # Held rows would add at least their text; in flight are four blocks of 32 in both.
    assert high - low < (large - small) / 4


def test_a_map_reads_its_nodes_from_disk(train: GearTrain, tmp_path: Path) -> None:
    grid = MapGrid(np.array([60.0, 90.0, 120.0]), np.array([100.0, 200.0]), 0, 48)
    files = MapFiles(tmp_path / "f.npz", train, grid)
    with Journal(tmp_path / "f.npz", [files.nodes, files.machines], {}) as open_journal:
        files.find_nodes(open_journal, Threads(), lambda done, total: None)
        open_journal.flush()
        found = files.regime_map(0)
        for name in ("codes", "period", "lyapunov", "contact_loss", "force_max", "chaos"):
            column = getattr(found, name)
            assert isinstance(column, np.memmap)
            assert np.array_equal(
                column,
                getattr(RegimeMap.compute(System(train), grid.speeds, grid.loads, transient=0, periods=48), name),
                equal_nan=True,
            )
