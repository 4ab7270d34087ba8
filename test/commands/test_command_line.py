"""The command line: exit codes, JSON, one-line errors, helps."""

import json
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from seat_gear_dynamics.commands import COMMANDS, main
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import load_system
from seat_gear_dynamics.regimes import simulate

ROOT = Path(__file__).parents[2]


def seat_gear(*arguments: str, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "seat_gear_dynamics", *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example_of_itself(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    assert f"seat-gear {command}" in text.split("example:")[1]
    assert "--system" in text
    assert "--json" in text


def test_help_loads_nothing_heavy() -> None:
    heavy = ("numpy", "scipy", "numba", "rich", "matplotlib", "cyclonedds", "mcap")
    code = (
        "import sys; from seat_gear_dynamics.commands import _parser; _parser();"
        f"print([m for m in {heavy!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("arguments", [[], ["fly"], ["simulate"], ["simulate", "--load", "x", "--frequency", "1"]])
def test_wrong_use_exits_with_2(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2


def test_simulate_prints_one_json_object_equal_to_the_library(capsys: pytest.CaptureFixture[str]) -> None:
    run = ["simulate", "--speed-rpm", "1046", "--load", "500", "--transient", "30", "--periods", "60", "--json"]
    assert main(run) == 0
    printed = json.loads(capsys.readouterr().out)
    expected = simulate(load_system(), speed=1046 * RPM, load=500.0, transient=30, periods=60).as_dict()
    assert printed == json.loads(json.dumps(expected))
    assert {"regime", "period", "lyapunov", "load_scale"} <= set(printed)
    assert {"mean", "min", "max", "rms", "contact_loss"} <= set(printed["meshes"]["s1_s2"])


def test_simulate_in_words_names_the_regime_and_the_load_scale(capsys: pytest.CaptureFixture[str]) -> None:
    run = "simulate --frequency 0.5 --load 600 --damping 0.09 --backlash-um 15 --transient 30 --periods 60"
    assert main(run.split()) == 0
    text = capsys.readouterr().out
    assert "motion of s1_s2:" in text
    assert "load scale" in text


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("simulate --frequency 0 --load 600", "frequency is 0"),
        ("simulate --frequency nan --load 600", "expected a finite number"),
        ("simulate --frequency 1 --load 600 --damping -1", "damping is -1.0"),
        ("simulate --frequency 1 --load 600 --system /nowhere.yaml", "cannot be read"),
        ("stiffness --system /nowhere.yaml", "cannot be read"),
        ("analyze /nowhere", "There is no log"),
        ("replay /nowhere", "There is no log"),
        ("replay bags/third_party_bench", "no topic 'gear_monitor/input'"),
        ("monitor --set margin", "expected NAME=VALUE"),
    ],
)
def test_failures_are_one_line_on_standard_error(
    arguments: str, sentence: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    assert main(shlex.split(arguments)) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("error: ")
    assert len(printed.err.strip().splitlines()) == 1
    assert sentence in printed.err


def test_stiffness_reports_computed_beside_published(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stiffness", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["s1_s2"]["contact_ratio"] == pytest.approx(1.6142, abs=1e-4)
    assert printed["s3_s4"]["contact_ratio"] == pytest.approx(1.5912, abs=1e-4)
    assert printed["s1_s2"]["published_mean"] == 2.234e8


def test_analyze_reports_a_foreign_bag(tmp_path: Path) -> None:
    done = seat_gear("analyze", "bags/third_party_bench", "--output", str(tmp_path), "--json")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["topics"]["/motor/speed"]["count"] == 12619
    assert (tmp_path / "report.png").is_file()
