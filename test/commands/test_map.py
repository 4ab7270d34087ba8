"""`seat-gear map`: its files, its bands, and how it is used wrongly."""

import argparse
import csv
import json
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.commands import map as map_command
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.description import parse_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.regime_map import RegimeMap

Run = Callable[[str], int]
GRID = "--speed-rpm 600 1100 3 --load 100 100 1 --transient 100 --periods 96"


def parse(words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("--system")
    parser.add_argument("--json", action="store_true")
    map_command.add_arguments(parser)
    return parser.parse_args(shlex.split(words))


@pytest.fixture
def run(make_train: Callable[..., GearTrain], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run the command on a train of fixed parameters that turns chaotic near 900 r/min at 100 N·m."""
    monkeypatch.chdir(tmp_path)
    Path("fixed.yaml").write_text(make_train({"meshes.*.damping_ratio": 0.05}).text, encoding="utf-8")
    return lambda words: map_command.run(parse(f"--system fixed.yaml {words}"))


def test_the_map_is_written_and_its_bands_are_printed(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(f"{GRID} --output f.npz --plot f.png --json") == 0
    printed = json.loads(capsys.readouterr().out)
    train = parse_train(Path("fixed.yaml").read_text(encoding="utf-8"))
    with Path("f.npz").open("rb") as file:
        found = RegimeMap.load(file, train)
    assert found.speeds / RPM == pytest.approx(np.array([600.0, 850.0, 1100.0]))
    (expected,) = found.bands(100.0)
    ((at,),) = ([each["bands"] for each in printed["bands"]],)
    assert at[0]["low_rpm"] == pytest.approx(expected.low / RPM)
    assert (at[0]["low_error_rpm"], at[0]["open_high"]) == (pytest.approx(125.0), True)
    assert (printed["samples"], printed["fingerprint"]) == (0, found.fingerprint)
    assert Path("f.png").read_bytes().startswith(b"\x89PNG")


def test_machines_within_tolerances_give_probabilities_in_a_table(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(f"{GRID} --samples 2 --seed 4 --output f.csv") == 0
    with Path("f.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == map_command.COLUMNS
    assert [float(row["speed_rpm"]) for row in rows] == pytest.approx([600.0, 850.0, 1100.0])
    for row in rows:
        low, p, high = (float(row[name]) for name in ("chaos_low", "chaos_probability", "chaos_high"))
        assert 0 <= low <= p <= high <= 1
        assert high - low > 0.5  # of two machines
    printed = capsys.readouterr()
    assert "probability of chaos of 2 machines within tolerances at least 0.5" in printed.out
    assert "T4 = 100 N·m: " in printed.out
    assert printed.err == ""


def test_no_band_is_said_in_words(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    run("--speed-rpm 300 400 2 --load 600 600 1 --transient 100 --periods 96 --output f.npz")
    assert "T4 = 600 N·m: none" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words",
    [
        "",
        "--output f.txt",
        "--output nowhere/f.npz",
        "--output f.npz --plot f.npz",
        "--output f.npz --threshold 0",
        "--output f.npz --threshold 1.5",
        "--output f.npz --samples -1",
        "--output f.npz --speed-rpm 1 2",
        "--output f.npz --speed-rpm 100 200 2.5",
        "--output f.npz --load 100 200 1",
        "--output f.npz --load 100 200 0",
        "--output f.npz --load 100 200 nan",
    ],
)
def test_wrong_use_exits_with_2_and_leaves_no_file(run: Run, words: str, tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as ended:
        run(words)
    assert ended.value.code == 2
    assert not (tmp_path / "f.npz").exists()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("--speed-rpm 0 100 2", "lowest of the speeds is 0 rad/s"),
        ("--speed-rpm 200 100 2", "each above the one before"),
        ("--speed-rpm 100 100 1", "one speed, expected at least two"),
        ("--speed-rpm 100 200 2 --periods 0", "0 sampled periods"),
    ],
)
def test_impossible_grids_are_one_sentence_and_leave_no_file(
    run: Run, words: str, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(CommandError, match=sentence):
        run(f"{words} --output f.npz")
    assert not (tmp_path / "f.npz").exists()


def test_the_example_in_the_help_is_a_command_line_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _, name, *words = shlex.split(map_command.TEXTS["map"].example)
    assert name == "map"
    assert parse(shlex.join(words)).load == [300.0, 600.0, 2.0]
