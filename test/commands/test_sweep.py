"""`seat-gear sweep`: its files, its words and its wrong uses."""

import argparse
import csv
import json
import shlex
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.commands import sweep
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.regimes import Regime
from seat_gear_dynamics.regimes.sweep import Row, Sweep
from seat_gear_dynamics.regimes.sweep_table import lines

CONTRACT = "value,regime,period,lyapunov,contact_loss,force_min,force_max,force_mean,force_rms"
Run = Callable[[str], int]

SWEEP = import_module("seat_gear_dynamics.regimes.sweep")


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
    assert head == f"{CONTRACT},direction,lyapunov_error"
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


def test_a_picture_of_too_many_points_leaves_values_out_in_both_directions_alike(
    run: Run, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn: list[Sweep] = []
    files = import_module("seat_gear_dynamics.commands.sweep_files")
    figures = import_module("seat_gear_dynamics.views.figures.bifurcation")
    draw = figures.bifurcation_figure

    def kept(found: Sweep) -> Any:
        drawn.append(found)
        return draw(found)

    monkeypatch.setattr(files, "MOST_DRAWN", 4 * 48)  # of 10 rows of 48: every third value
    monkeypatch.setattr(figures, "bifurcation_figure", kept)
    run(f"--over load --start 100 --stop 300 --points 5 --direction both --plot f.png {SHORT}")
    (found,) = drawn
    assert [(row.direction, row.value) for row in found.rows] == [
        ("up", 100.0),
        ("down", 250.0),
        ("up", 250.0),
        ("down", 100.0),
    ]
    points = table("f_points.csv")
    for row in found.rows:
        own = [line for line in points if (line["value"], line["direction"]) == (str(row.value), row.direction)]
        assert row.section.tolist() == [[float(line["delta"]), float(line["rate"])] for line in own]
    assert "picture: f.png (one of 3 values)" in capsys.readouterr().out


def test_what_is_summed_up_from_the_files_is_what_the_sweep_itself_says(
    run: Run, train: GearTrain, capsys: pytest.CaptureFixture[str]
) -> None:
    from seat_gear_dynamics.motion import System
    from seat_gear_dynamics.regimes.sweep import intervals, sweep

    # A lightly damped pair beside its resonance: up and down part (test/regimes/test_sweep has the fold).
    asked = "--over frequency --start 0.78 --stop 0.98 --points 5 --direction both --load 200 --damping 0.05"
    run(f"{asked} --transient 100 --periods 64 --output f.csv --json")
    printed = json.loads(capsys.readouterr().out)
    light = train.with_mesh(0, damping_ratio=0.05).with_mesh(1, damping_ratio=0.05)
    options: Any = {"over": "frequency", "start": 0.78, "stop": 0.98, "points": 5, "direction": "both"}
    found = sweep(System(light).at(load=200.0), transient=100, periods=64, **options)
    assert printed["coexisting"] == list(found.coexisting()) != []
    assert [tuple(each) for each in printed["chaotic"]] == list(intervals(found, "chaotic"))
    assert printed["rows"] == [row.as_dict() for row in found.rows]


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
    monkeypatch.setattr(SWEEP, "sweep_each", lambda *_, **__: (line for line in [lines(lost)]))
    run(f"--over load --start 1 --stop 2 --points 2 {SHORT}")
    assert Path("f.csv").read_text(encoding="utf-8").splitlines()[1] == "1.0,undecided,,,,,,,,cold,"


def test_the_example_in_the_help_is_a_command_line_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _, name, *words = shlex.split(sweep.TEXTS["sweep"].example)
    assert name == "sweep"
    assert parse(shlex.join(words)).over == "load"
