"""Commands in a terminal (a pseudo one): drawn in 80x24, ended by Ctrl-C from its keyboard, left clean."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from domains import fresh_domain
from harness import Processes
from pseudo_terminal import PseudoTerminal

from seat_gear_dynamics.logs.reader import Bag

SEAT_GEAR = ["-m", "seat_gear_dynamics"]
CTRL_C = b"\x03"
UP = "\x1b[1A"


@pytest.fixture(autouse=True)
def _domain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(fresh_domain()))


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[Processes]:
    folder = tmp_path / "processes"
    folder.mkdir()
    running = Processes(folder)
    yield running
    running.close()


def highest(shown: str) -> int:
    """Return the lines of the highest frame that was redrawn: the cursor goes up to its first."""
    runs = re.findall(r"(?:\x1b\[1A(?:\x1b\[2K)?)+", shown)
    return 1 + max((run.count(UP) for run in runs), default=0)


def widest(text: str) -> int:
    """Return the columns of the widest line of the view, which has a frame around it."""
    before, _, _ = text.partition("^C")  # the terminal may put the key's echo amid a frame
    return max(len(line) for line in re.split(r"[\r\n]+", before) if line[:1] in ("╭", "│", "╰"))


def test_ctrl_c_ends_the_bench_and_leaves_the_terminal_clean(tmp_path: Path) -> None:
    log = tmp_path / "run"
    terminal = PseudoTerminal([*SEAT_GEAR, "bench", "--output", str(log)])
    try:
        terminal.read_until("s1_s2")
        terminal.read_until("recording")
        terminal.type(CTRL_C)
        terminal.read_until("report: ")
        assert terminal.read_to_end() == 0, terminal.shown[-2000:]
        assert "seat-gear bench: up-down" in terminal.text
        assert 10 < highest(terminal.shown) <= 24
        assert widest(terminal.text) == 80
        assert terminal.left_behind() == []
        assert terminal.colours()
        assert "Traceback" not in terminal.shown
    finally:
        terminal.close()
    assert Bag(log).closed


def test_ctrl_c_before_the_log_begins_is_no_error_and_leaves_nothing(tmp_path: Path) -> None:
    terminal = PseudoTerminal([*SEAT_GEAR, "bench", "--output", str(tmp_path / "run")])
    try:
        terminal.read_until("starting the recorder")
        terminal.type(CTRL_C)
        code = terminal.read_to_end()
        # A recorder that was quick has made a log by then, which is reported as any other.
        assert code == (0 if (tmp_path / "run").exists() else 130), terminal.text
        assert "error" not in terminal.text
        assert terminal.left_behind() == []
    finally:
        terminal.close()


def test_the_monitor_shows_the_view_keeps_its_log_above_and_ends_with_ctrl_c(processes: Processes) -> None:
    processes.node("simulator", profile="dwell-in-band")
    terminal = PseudoTerminal([*SEAT_GEAR, "monitor"], NO_COLOR="1")
    try:
        terminal.read_until(lambda text: re.search(r"s1_s2 +-?\d+ N", text) is not None)
        terminal.type(CTRL_C)
        assert terminal.read_to_end() == 0, terminal.text[-2000:]
        assert "seat-gear monitor" in terminal.text
        assert re.search(r"\[gear_monitor\]: ready", terminal.text)
        assert re.search(r"[+-]\d+ r/min", terminal.text), "the speed that the model was fed"
        assert 10 < highest(terminal.shown) <= 24
        assert widest(terminal.text) == 80
        assert not terminal.colours()
        assert terminal.left_behind() == []
        assert "Traceback" not in terminal.shown
    finally:
        terminal.close()


def test_a_small_terminal_gets_one_line() -> None:
    terminal = PseudoTerminal([*SEAT_GEAR, "monitor"], size=(60, 12))
    try:
        terminal.read_until("STALE: no ")
        terminal.type(CTRL_C)
        assert terminal.read_to_end() == 0
        assert "╭" not in terminal.shown
        assert terminal.left_behind() == []
    finally:
        terminal.close()


def test_a_dumb_terminal_gets_plain_lines() -> None:
    terminal = PseudoTerminal([*SEAT_GEAR, "monitor"], TERM="dumb")
    try:
        terminal.read_until("STALE: no ")
        terminal.type(CTRL_C)
        assert terminal.read_to_end() == 0
        assert "\x1b" not in terminal.shown
    finally:
        terminal.close()


def test_a_pipe_gets_plain_lines_whatever_colour_is_forced_and_sigterm_ends_it(tmp_path: Path) -> None:
    command = [sys.executable, *SEAT_GEAR, "monitor"]
    said = tmp_path / "said.txt"
    with said.open("wb") as errors:
        environment = {**os.environ, "FORCE_COLOR": "1"}
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=environment)
        assert process.stdout is not None
        lines = [next(process.stdout)]
        while "STALE: no " not in lines[-1]:
            lines.append(next(process.stdout))
        process.send_signal(signal.SIGTERM)
        rest, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert not re.search(r"\x1b\[\??\d*[A-HJKhl]", "".join(lines) + rest), "no cursor moves in a pipe"
    assert "[gear_monitor]: ready" in said.read_text()


def test_a_monitor_that_cannot_start_says_why_and_leaves_the_terminal_clean() -> None:
    terminal = PseudoTerminal([*SEAT_GEAR, "monitor", "--set", "map=/nowhere.npz"])
    try:
        assert terminal.read_to_end() == 1
        assert terminal.text.count("error: ") == 1
        assert "error: The map /nowhere.npz cannot be read" in terminal.text
        assert terminal.left_behind() == []
    finally:
        terminal.close()


@pytest.mark.parametrize(
    ("command", "seen", "colour"),
    [
        ("sweep --over load --start 100 --stop 600 --points 400 --output sweep.csv", "/400", True),
        ("sweep --over load --start 100 --stop 600 --points 400 --output sweep.csv", "/400", False),
        ("quality --runs 20 --workers 2", "20 runs", True),
        ("harmonic", "/100", True),
        ("simulate --frequency 0.5 --load 600 --periods 1000000", "mesh periods", True),
    ],
    ids=["sweep", "sweep with NO_COLOR", "quality", "harmonic", "simulate"],
)
def test_ctrl_c_ends_a_computation_and_takes_its_bar_away(
    tmp_path: Path, command: str, seen: str, colour: bool
) -> None:
    terminal = PseudoTerminal([*SEAT_GEAR, *command.split()], cwd=tmp_path, NO_COLOR="" if colour else "1")
    try:
        terminal.read_until(seen)
        terminal.type(CTRL_C)
        assert terminal.read_to_end() == 130, terminal.text[-2000:]
        assert terminal.left_behind() == []
        assert bool(terminal.colours()) is colour
        assert "Traceback" not in terminal.text
    finally:
        terminal.close()
