"""What holds for every command: examples that run, one JSON object, wrong use in one line, help in 80 columns."""

import json
import shlex
import shutil
import signal
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from domains import fresh_domain

from seat_gear_dynamics.commands import COMMANDS, main

BAGS = Path(__file__).parents[2] / "bags"
PROGRAM = [sys.executable, "-m", "seat_gear_dynamics"]

# Command -> what is added to its example, so that it takes a second or so: an option given again replaces the first.
SHORTER = {
    "simulate": "",
    "stiffness": "",
    "sweep": "--transient 50 --periods 50",
    "map": "--transient 50 --periods 50",
    "basins": "--deflection -4 6 8 --rate -3 3 8",
    "harmonic": "--start 0.4 --stop 0.44 --compare 1",
    "taguchi": "--array L18",
    "calibrate": "--evaluations 16",
    "quality": "--runs 1 --workers 1",
    "analyze": "--no-model --processes 1",
    "replay": "",
    "recover": "",
    "completion": "",
}
# Served until they are told to end; what they say on either stream once they are at work.
SERVING = {"dashboard": "", "monitor": "ready", "record": "recording to", "simulator": "playing"}
# Run elsewhere: the bench in test_bench.py, whose runs are these, and minutes of reproduction in test/studies.
ELSEWHERE = {"bench", "reproduce"}


def example(command: str) -> list[str]:
    """Return the words of the example after `seat-gear`."""
    texts = import_module(f"seat_gear_dynamics.commands.{COMMANDS[command]}").TEXTS[command]
    program, *words = shlex.split(texts.example)
    assert program == "seat-gear"
    return words


def test_every_command_is_run_here_or_elsewhere() -> None:
    assert {*SHORTER, *SERVING, *ELSEWHERE} == set(COMMANDS)


@pytest.fixture
def workshop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the logs that the examples name, and a network of its own."""
    (tmp_path / "bags").mkdir()
    shutil.copytree(BAGS / "third_party_bench", tmp_path / "bags" / "third_party_bench")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_DOMAIN_ID", str(fresh_domain()))
    return tmp_path


def one_object(text: str) -> dict[str, Any]:
    """Return the JSON object that a text is, and nothing else."""
    assert len(text.splitlines()) == 1
    found = json.loads(text)
    assert isinstance(found, dict)
    return found


@pytest.mark.parametrize("command", SHORTER)
@pytest.mark.parametrize("as_json", [False, True], ids=["words", "json"])
def test_the_example_runs(command: str, as_json: bool, workshop: Path, capfd: pytest.CaptureFixture[str]) -> None:
    if command == "analyze" and as_json:
        pytest.skip("test_command_line.py has it")
    shutil.copytree(BAGS / ("damaged" if command == "recover" else "ramp"), workshop / "my_run")
    capfd.readouterr()
    code = main([*example(command), *SHORTER[command].split(), *["--json"] * as_json])
    printed = capfd.readouterr()
    assert code == 0, printed.err
    if as_json:
        assert one_object(printed.out)
        assert printed.err == "", "with --json nothing is said beside the object"
    else:
        assert printed.out
        assert "\x1b" not in printed.out, "no colours where nobody looks"


@pytest.mark.parametrize("command", SERVING)
def test_what_serves_prints_one_object_and_ends_when_told(command: str, workshop: Path) -> None:
    port = ["--port", "0"] if command == "dashboard" else []
    process = subprocess.Popen(
        [*PROGRAM, *example(command), *port, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stderr is not None
    heard = process.stderr if SERVING[command] else process.stdout
    line = ""
    while not line or SERVING[command] not in line:
        line = next(heard)
    process.send_signal(signal.SIGINT)
    rest, said = process.communicate(timeout=60)
    assert process.returncode == 0, said
    assert "Traceback" not in said
    assert one_object(rest if SERVING[command] else line + rest)


@pytest.mark.parametrize("command", sorted(ELSEWHERE))
def test_an_example_that_runs_elsewhere_is_right_use(command: str) -> None:
    from seat_gear_dynamics.commands import _parser

    assert _parser().parse_args(example(command)).command == command


@pytest.mark.parametrize("command", COMMANDS)
def test_wrong_use_is_one_line_and_exits_with_2(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([command, "--no-such-option", "7"])
    printed = capsys.readouterr()
    assert ended.value.code == 2
    assert printed.out == ""
    assert len(printed.err.splitlines()) == 1
    assert printed.err.startswith("error: ")
    assert "seat-gear" in printed.err


@pytest.mark.parametrize(
    "words",
    [
        "bench --duration 1 --profile sideways",
        "dashboard --map /nowhere.npz",
        "monitor --set margin",
        "record --set output",
        "simulator --set =run-up",
        "simulate --frequency 1 --load 600 --system /nowhere.yaml",
        "stiffness --system /nowhere.yaml",
        "sweep --over load --start 1 --stop 2 --points 2 --output s.csv --system /nowhere.yaml",
        "map --output m.npz --system /nowhere.yaml",
        "harmonic --start 1 --stop 1",
        "taguchi --array L7",
        "calibrate --evaluations 0",
        "reproduce --system /nowhere.yaml",
        "quality --map /nowhere.npz",
        "analyze /nowhere",
        "replay /nowhere",
        "recover /nowhere",
    ],
    ids=lambda words: words.split()[0],
)
def test_what_fails_is_one_line_and_exits_with_1(words: str, workshop: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main([*words.split(), "--json"]) == 1
    printed = capfd.readouterr()
    assert printed.out == ""
    assert len(printed.err.splitlines()) == 1
    assert printed.err.startswith("error: ")


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_the_help_fits_80_columns(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main([*([command] if command else []), "--help"])
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


@pytest.mark.parametrize("command", COMMANDS)
def test_an_example_broken_into_lines_is_still_the_command(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    shown = capsys.readouterr().out.split("example:")[1]
    assert shlex.split(shown.replace("\\\n", "")) == ["seat-gear", *example(command)]
