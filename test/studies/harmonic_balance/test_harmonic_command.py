"""`seat-gear harmonic`: what it prints and writes, and how it says no."""

import argparse
import csv
import json
from pathlib import Path

import pytest

from seat_gear_dynamics.commands import harmonic
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.gears import GearTrain


def run(*arguments: str) -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--system")
    parser.add_argument("--json", action="store_true")
    harmonic.add_arguments(parser)
    return harmonic.run(parser.parse_args(arguments))


@pytest.fixture
def short(train: GearTrain, tmp_path: Path) -> tuple[str, ...]:
    """Arguments for a short curve of the train of fixed parameters, with one pair of folds."""
    described = tmp_path / "train.yaml"
    described.write_text(train.text, encoding="utf-8")
    return ("--system", str(described), "--load", "100", "--start", "0.66", "--stop", "0.78", "--harmonics", "12")


def test_json_is_one_object_and_the_files_are_there(
    short: tuple[str, ...], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    folder = tmp_path / "curve"
    assert run(*short, "--compare", "1", "--output", str(folder), "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["branches"][0]["period"] == 1
    assert (found["start"], found["stop"]) == (0.66, 0.78)
    assert len(found["comparison"]) == 2
    assert [Path(f).name for f in found["files"]] == ["response_curve.csv", "response_curve.png"]
    with (folder / "response_curve.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert len(table) == found["branches"][0]["motions"]
    assert float(table[-1]["value"]) == pytest.approx(0.78)
    assert (folder / "response_curve.png").read_bytes().startswith(b"\x89PNG")


def test_text_lists_branches_and_bifurcations(short: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*short) == 0
    text = capsys.readouterr().out
    assert "branch of period 1" in text
    assert text.count("fold  ") == 2
    assert text.count("two or more stable motions") == 1


def test_values_of_the_parameter_are_in_the_commands_unit(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ("--over", "backlash-um", "--start", "5", "--stop", "20", "--harmonics", "12", "--json")
    assert run(*arguments) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["stop"] == pytest.approx(20)
    assert found["branches"][0]["from"] == pytest.approx(5)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--over", "load"), "give both --start and --stop"),
        (("--start", "2", "--stop", "1"), "the lower one first"),
        (("--damping", "-0.1"), "expected a finite number of at least 0"),
        (("--backlash-um", "nan"), "expected a finite number of at least 0"),
        (("--compare", "0", "--stop", "0.2"), "expected 1 or more values"),
        (("--harmonics", "0"), "expected 1 or more of both"),
    ],
)
def test_what_cannot_be_followed_is_one_sentence(arguments: tuple[str, ...], sentence: str) -> None:
    with pytest.raises(CommandError, match=sentence):
        run(*arguments)
