"""Saying so when something is compiled, and only then; code is kept for each kind of processor."""

import os
import platform
import subprocess
import sys
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
from numba import njit

from seat_gear_dynamics.motion.compiling import COMPILING, announced

compiled: Any = njit


def _twice(x: float) -> float:
    return 2 * x


def test_the_first_compilation_is_announced_and_no_other() -> None:
    said: list[str] = []
    with announced(said.append):
        assert said == []
        compiled(_twice)(1.0)
        assert said == [COMPILING]
        compiled(_twice)(1.0)
    assert said == [COMPILING]


def test_a_function_that_is_compiled_already_is_no_news() -> None:
    twice, said = compiled(_twice), list[str]()
    twice(1.0)
    with announced(said.append, "said"):
        twice(1.0)
    assert said == []


def test_nothing_is_said_outside_and_to_nobody() -> None:
    said: list[str] = []
    with announced(said.append):
        pass
    compiled(_twice)(1.0)
    with announced(None):
        compiled(_twice)(1.0)
    assert said == []


def test_a_compilation_in_another_thread_counts() -> None:
    said: list[str] = []
    with announced(said.append, "said"):
        threads = [Thread(target=compiled(_twice), args=(1.0,)) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert said == ["said"]


# Marches a coupled train and prints what was said, then the bits of the motion.
_PROGRAM = """
from seat_gear_dynamics.motion import Inputs, March, load_system
from seat_gear_dynamics.motion.compiling import announced
with announced(lambda text: print("said")):
    march, inputs = March(load_system().train.with_shaft(2.6e4), load=20.0), Inputs(1.3, 20.0)
    march.advance((0.0, inputs), (30.0, inputs))
print(march.whole.tobytes().hex())
"""


def _marched(cache: Path, **settings: str) -> list[str]:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)} | settings
    command = [sys.executable, "-c", _PROGRAM]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.split()


def test_code_is_kept_for_each_processor_and_the_motion_is_the_same_on_all(tmp_path: Path) -> None:
    if platform.machine() != "x86_64":
        pytest.skip("the other processor asked for is an x86-64")
    said, bits = _marched(tmp_path)
    assert said == "said"
    assert _marched(tmp_path) == [bits]
    # The plainest processor of its kind: no wide vectors, no fused multiply-add.
    plain = {"NUMBA_CPU_NAME": "x86-64", "NUMBA_CPU_FEATURES": "+sse2"}
    assert _marched(tmp_path, **plain) == ["said", bits]
    assert _marched(tmp_path, **plain) == [bits]
