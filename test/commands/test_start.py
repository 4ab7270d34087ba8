"""How commands start: a help without anything heavy, and a word while the model is compiled."""

import json
import os
import subprocess
import sys
from pathlib import Path

from seat_gear_dynamics.commands import _MODELLING, COMMANDS
from seat_gear_dynamics.motion.compiling import COMPILING

HEAVY = ("numpy", "scipy", "numba", "llvmlite", "matplotlib", "rich", "cyclonedds", "mcap", "rosbags", "distributed")
SIMULATE = "simulate --frequency 0.5 --load 600 --transient 4 --periods 4"
SWEEP = "sweep --over load --start 300 --stop 600 --points 2 --transient 4 --periods 4 --output"


def seat_gear(*arguments: str, **settings: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "seat_gear_dynamics", *arguments]
    return subprocess.run(command, env=os.environ | settings, capture_output=True, text=True, check=True)


def test_no_help_loads_anything_heavy() -> None:
    # One process asks for all helps, the program's own first: what any of them loads is there at the end.
    program = (
        "import contextlib, io, sys\n"
        "from seat_gear_dynamics.commands import COMMANDS, main\n"
        "for arguments in ([], *([name] for name in COMMANDS)):\n"
        "    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()) as told:\n"
        "        main([*arguments, '--help'])\n"
        "    assert 'usage:' in told.getvalue(), arguments\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_wrong_use_is_told_without_loading_the_model() -> None:
    program = (
        "import contextlib, sys\n"
        "from seat_gear_dynamics.commands import main\n"
        "with contextlib.suppress(SystemExit):\n"
        "    main(['simulate', '--load', 'x'])\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_commands_that_run_the_model_are_commands() -> None:
    assert set(COMMANDS) >= _MODELLING


def test_a_first_sweep_says_that_it_compiles_and_the_next_does_not(tmp_path: Path) -> None:
    cache = str(tmp_path / "compiled")
    runs = [seat_gear(*SWEEP.split(), str(tmp_path / f"{n}.csv"), NUMBA_CACHE_DIR=cache) for n in range(2)]
    # A slow machine adds lines of progress.
    assert [run.stderr.splitlines().count(COMPILING) for run in runs] == [1, 0]
    assert (tmp_path / "0.csv").read_text() == (tmp_path / "1.csv").read_text()


def test_with_json_nothing_is_said_while_it_compiles(tmp_path: Path) -> None:
    done = seat_gear(*SIMULATE.split(), "--json", NUMBA_CACHE_DIR=str(tmp_path))
    assert COMPILING not in done.stderr
    assert "regime" in json.loads(done.stdout)
    assert list(tmp_path.rglob("*.nbi")), "nothing was compiled, so this showed nothing"
