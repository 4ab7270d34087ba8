"""`seat-gear basins`: its files, its shares, and how it is used wrongly."""

import argparse
import csv
import json
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from seat_gear_dynamics import load_system
from seat_gear_dynamics.commands import basins as command
from seat_gear_dynamics.commands import main
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.basins import basins

Run = Callable[[str], int]
PLANE = "--deflection -4 6 6 --rate -3 3 4 --transient 100 --periods 60"


@pytest.fixture
def run(make_train: Callable[..., GearTrain], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run the command on a train of fixed parameters."""
    monkeypatch.chdir(tmp_path)
    Path("fixed.yaml").write_text(make_train().text, encoding="utf-8")
    parser = argparse.ArgumentParser()
    parser.add_argument("--system")
    parser.add_argument("--json", action="store_true")
    command.add_arguments(parser)
    return lambda words: command.run(parser.parse_args(["--system", "fixed.yaml", *shlex.split(words)]))


def test_table_and_summary_are_those_of_the_library(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(f"--speed-rpm 1000 --load 600 --damping 0.03 --backlash-um 30 {PLANE} --output found --json") == 0
    printed = json.loads(capsys.readouterr().out)
    system = load_system("fixed.yaml")
    changed = {"damping_ratio": 0.03, "backlash": 30e-6}
    train = system.train.with_mesh(0, **changed).with_mesh(1, **changed)
    at = replace(system, train=train).at(speed=1000 * RPM, load=600.0)
    expected = basins(at, [-4, -2, 0, 2, 4, 6], [-3, -1, 1, 3], transient=100, periods=60)
    assert printed["starts"] == 24
    assert [each["share"] for each in printed["motions"]] == [
        expected.share(index).value for index in range(len(expected.attractors))
    ]
    assert sum(each["share"] for each in printed["motions"]) + printed["diverged"] == pytest.approx(1.0)
    with Path("found/basins.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["motion"]) for row in rows] == expected.labels.ravel().tolist()
    assert Path("found/basins.png").read_bytes().startswith(b"\x89PNG")
    assert printed["files"] == ["found/basins.csv", "found/basins.png"]


def test_words_name_each_motion_with_its_share(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(f"--frequency 0.4 --load 600 {PLANE}") == 0
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith("24 starts settle on ")
    assert "of the starts: " in second
    assert "contact lost" in second


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ("--frequency 1 --load 600 --rate 3 1 4", 2, "--rate asks for 4 values from 3 to 1"),
        ("--frequency 1 --load 600 --deflection 0 1 1", 2, "--deflection asks for 1 values"),
        ("--frequency 1 --load 600 --deflection 0 1 2.5", 2, "expected a whole number of at least 2"),
        ("--load 600", 2, "--speed-rpm --frequency is required"),
        ("--frequency 1 --load 600 --damping -1", 1, "The damping is -1.0"),
        ("--frequency nan --load 600", 1, "frequency is nan"),
    ],
)
def test_wrong_use_is_told_in_one_line(words: str, code: int, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        found = main(["basins", *shlex.split(words)])
    except SystemExit as end:
        found = int(end.code or 0)
    assert found == code
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    assert said in line
