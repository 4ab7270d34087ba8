"""`seat-gear sweep`: its files, its words, and what an interruption leaves of it."""

import argparse
import csv
import json
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Generator
from importlib import import_module
from pathlib import Path
from time import sleep
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.commands import sweep
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.regimes import MeshForce, Regime
from seat_gear_dynamics.regimes.sweep import Row

CONTRACT = "value,regime,period,lyapunov,contact_loss,force_min,force_max,force_mean,force_rms"
Run = Callable[[str], int]

# As `seat-gear` itself gives a command its parser; every line of the table is flushed as it is found.
PROGRAM = """
import argparse, sys
from seat_gear_dynamics.commands import sweep
parser = argparse.ArgumentParser()
parser.add_argument("--system")
parser.add_argument("--json", action="store_true")
sweep.add_arguments(parser)
sys.exit(sweep.run(parser.parse_args()))
"""


def parse(words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("--system")
    parser.add_argument("--json", action="store_true")
    sweep.add_arguments(parser)
    return parser.parse_args(shlex.split(words))


@pytest.fixture
def run(train: GearTrain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run the command on the train of fixed parameters in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    Path("fixed.yaml").write_text(train.text, encoding="utf-8")
    return lambda words: sweep.run(parse(f"--system fixed.yaml {words}"))


def table(path: str = "f.csv") -> list[dict[str, str]]:
    with Path(path).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


SHORT = "--transient 5 --periods 48 --output f.csv"


def test_the_table_has_the_columns_that_programs_rely_on(run: Run) -> None:
    assert run(f"--over load --start 100 --stop 300 --points 3 --frequency 0.5 {SHORT}") == 0
    head, *lines = Path("f.csv").read_text(encoding="utf-8").splitlines()
    assert head == f"{CONTRACT},direction"
    assert [line.split(",")[0] for line in lines] == ["100.0", "200.0", "300.0"]
    for row in table():
        assert row["regime"] in ("periodic", "quasi-periodic", "chaotic", "undecided")
        assert (row["period"] != "") == (row["regime"] == "periodic")
        assert float(row["force_min"]) <= float(row["force_mean"]) <= float(row["force_rms"]) <= float(row["force_max"])
        assert 0 <= float(row["contact_loss"]) <= 1
        assert row["direction"] == "cold"


def test_every_section_point_is_in_the_table_of_points(run: Run) -> None:
    run(f"--over speed-rpm --start 1000 --stop 1400 --points 2 --load 100 --direction both {SHORT}")
    points = table("f_points.csv")
    assert list(points[0]) == ["value", "direction", "delta", "rate"]
    assert len(points) == 4 * 48
    assert [(row["value"], row["direction"]) for row in points[::48]] == [
        (row["value"], row["direction"]) for row in table()
    ]
    assert all(np.isfinite([float(row["delta"]), float(row["rate"])]).all() for row in points)


def test_json_is_one_object_that_holds_what_the_table_holds(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(f"--over damping --start 0.05 --stop 0.1 --points 2 --direction down --json {SHORT}") == 0
    printed = json.loads(capsys.readouterr().out)
    assert {"over", "unit", "rows", "chaotic", "coexisting", "diverged", "output", "section_points"} <= set(printed)
    assert [row["value"] for row in printed["rows"]] == [0.1, 0.05]
    for row, line in zip(printed["rows"], table(), strict=True):
        assert {name: "" if value is None else str(value) for name, value in row.items()} == line
    assert json.loads(json.dumps(printed, allow_nan=False)) == printed


def test_in_words_it_names_regimes_chaos_and_files(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    run(f"--over backlash-um --start 5 --stop 20 --points 2 --damping 0.1 --direction both {SHORT}")
    printed = capsys.readouterr()
    for part in ("4 rows over backlash-um, 5 to 20 µm", "chaotic:", "up and down on different motions at:", "f.csv"):
        assert part in printed.out
    assert printed.err == ""  # no progress where standard error is no terminal


def test_fixed_values_are_used(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    from seat_gear_dynamics.motion import load_system
    from seat_gear_dynamics.regimes import simulate

    run(f"--over load --start 100 --stop 200 --points 2 --frequency 0.7 --damping 0.2 --backlash-um 8 --json {SHORT}")
    row = json.loads(capsys.readouterr().out)["rows"][1]
    options: Any = {"frequency": 0.7, "damping": 0.2, "backlash": 8 * 1e-6, "transient": 5, "periods": 48}
    expected = simulate(load_system("fixed.yaml"), load=200.0, **options)
    assert row["force_max"] == pytest.approx(expected.meshes["s1_s2"].max, rel=1e-9)


def test_the_picture_is_drawn(run: Run) -> None:
    run(f"--over load --start 100 --stop 200 --points 2 --plot f.png {SHORT}")
    assert Path("f.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "words",
    [
        "--over load --start 1 --stop 2 --points 2",
        "--over colour --start 1 --stop 2 --points 2 --output f.csv",
        "--over load --start 1 --stop 2 --points 2 --output nowhere/f.csv",
        "--over load --start 1 --stop 2 --points 2 --output .",
        "--over load --start 1 --stop 2 --points 2 --output f.csv --plot f.txt",
        "--over load --load 3 --start 1 --stop 2 --points 2 --output f.csv",
        "--over frequency --speed-rpm 3 --start 1 --stop 2 --points 2 --output f.csv",
        "--over load --frequency 1 --speed-rpm 3 --start 1 --stop 2 --points 2 --output f.csv",
    ],
)
def test_wrong_use_exits_with_2_and_leaves_no_file(run: Run, words: str, tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as ended:
        run(words)
    assert ended.value.code == 2
    assert not (tmp_path / "f.csv").exists()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("--over load --start 2 --stop 1 --points 2", "from 2.0 to 1.0, expected finite numbers, the lower first"),
        ("--over load --start 1 --stop 2 --points 1", "1 points, expected at least 2"),
        ("--over frequency --start 0 --stop 2 --points 3", "frequency is 0"),
        ("--over load --start 1 --stop 2 --points 2 --damping -1", "damping ratio is -1.0"),
        ("--over load --start 1 --stop 2 --points 2 --frequency 0", "frequency is 0"),
    ],
)
def test_impossible_values_are_one_sentence_and_leave_no_file(
    run: Run, words: str, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(CommandError, match=sentence):
        run(f"{words} {SHORT}")
    assert not (tmp_path / "f.csv").exists()


def test_a_diverged_row_leaves_its_fields_empty(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    lost = Row(1.0, "cold", Regime("undecided", None, None, None, "diverged"), None, np.empty((0, 2)))

    def rows(*_: object, **__: object) -> Generator[Row, None, None]:
        yield lost

    monkeypatch.setattr(import_module("seat_gear_dynamics.regimes.sweep"), "sweep_rows", rows)
    run(f"--over load --start 1 --stop 2 --points 2 {SHORT}")
    assert Path("f.csv").read_text(encoding="utf-8").splitlines()[1] == "1.0,undecided,,,,,,,,cold"


def test_an_interruption_between_rows_leaves_the_rows_before_it(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    force = MeshForce(1.0, 0.0, 2.0, 1.1, 0.0, 1.0)
    closed = []

    def rows(*_: object, **__: object) -> Generator[Row, None, None]:
        try:
            for value in (1.0, 2.0):
                yield Row(value, "up", Regime("chaotic", None, 0.1, 0.0, ""), force, np.zeros((3, 2)))
            raise KeyboardInterrupt
        finally:
            closed.append(True)

    monkeypatch.setattr(import_module("seat_gear_dynamics.regimes.sweep"), "sweep_rows", rows)
    with pytest.raises(KeyboardInterrupt):
        run(f"--over load --start 1 --stop 9 --points 9 {SHORT}")
    assert [row["value"] for row in table()] == ["1.0", "2.0"]
    assert len(table("f_points.csv")) == 6
    assert closed == [True]


def test_ctrl_c_leaves_whole_rows_and_their_points(run: Run, tmp_path: Path) -> None:
    words = "--over load --start 1 --stop 9999 --points 9999 --transient 0 --periods 8 --output f.csv"
    command = [sys.executable, "-c", PROGRAM, "--system", "fixed.yaml", *words.split()]
    process = subprocess.Popen(command, stderr=subprocess.PIPE)
    path = tmp_path / "f.csv"
    try:
        while process.poll() is None and not (path.exists() and path.read_text().count("\n") > 3):
            sleep(0.05)
        assert process.poll() is None, process.stderr and process.stderr.read()
        process.send_signal(signal.SIGINT)
        process.communicate()
    finally:
        process.kill()
        process.wait()
    text = path.read_text()
    assert text.endswith("\n")
    rows = table()
    assert len(rows) >= 3
    assert all(None not in row.values() and row["direction"] == "cold" for row in rows)
    counts = [sum(point["value"] == row["value"] for point in table("f_points.csv")) for row in rows]
    assert set(counts) == {8}


def test_the_example_in_the_help_is_a_command_line_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _, name, *words = shlex.split(sweep.TEXTS["sweep"].example)
    assert name == "sweep"
    assert parse(shlex.join(words)).over == "load"
