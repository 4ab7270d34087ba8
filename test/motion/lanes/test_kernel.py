"""Compiling and keeping kernels: once, with a word before, and without a folder to keep them in."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes import cache as cache_module
from seat_gear_dynamics.motion.lanes import kernel as kernel_module
from seat_gear_dynamics.motion.lanes import respond_lanes
from seat_gear_dynamics.motion.lanes.cache import cache_folder
from seat_gear_dynamics.motion.lanes.kernel import kernel, kernel_source
from seat_gear_dynamics.motion.lanes.structure import Structure

BARE = Structure(1, False, True, False, tangent=False, statistics=False)


@pytest.fixture
def forgetful(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that has compiled no kernel yet."""
    monkeypatch.setattr(kernel_module, "_kernels", {})


@pytest.mark.usefixtures("forgetful")
def test_a_kernel_is_compiled_once_and_announced_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache_module, "cache_folder", lambda: tmp_path / "new" / "folder")
    said: list[str] = []
    first = kernel(BARE, announce=said.append)
    assert said == ["Compiling the lane kernel for this machine; this takes some seconds, once."]
    assert kernel(BARE, announce=said.append) is first
    files = list((tmp_path / "new" / "folder").glob("seat_gear_lanes_*.py"))
    assert [f.read_text(encoding="utf-8") for f in files] == [kernel_source(BARE, first.width, cache=True)]
    monkeypatch.setattr(kernel_module, "_kernels", {})
    kernel(BARE, announce=said.append)
    assert len(said) == 1, "a kernel that is kept on disk is no news"


@pytest.mark.usefixtures("forgetful")
def test_a_damaged_source_is_written_anew_and_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache_module, "cache_folder", lambda: tmp_path)
    kernel(BARE)
    (path,) = tmp_path.glob("seat_gear_lanes_*.py")
    path.write_text("raise SystemExit(1)\n", encoding="utf-8")
    monkeypatch.setattr(kernel_module, "_kernels", {})
    kernel(BARE)
    assert path.read_text(encoding="utf-8") == kernel_source(BARE, kernel_module.WIDTH, cache=True)


@pytest.mark.usefixtures("forgetful")
def test_without_a_folder_to_write_to_kernels_live_in_memory(
    train: GearTrain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = respond_lanes(train, [0.5, 0.8], 300.0, transient=2, periods=2, tangent=False, statistics=False)
    blocked = tmp_path / "file"
    blocked.write_text("no folder can be made in here")
    monkeypatch.setattr(cache_module, "cache_folder", lambda: blocked / "folder")
    monkeypatch.setattr(kernel_module, "_kernels", {})
    said: list[str] = []
    found = respond_lanes(
        train, [0.5, 0.8], 300.0, transient=2, periods=2, tangent=False, statistics=False, announce=said.append
    )
    assert len(said) == 1
    assert found.section.tobytes() == kept.section.tobytes()
    assert list(tmp_path.iterdir()) == [blocked]


def test_another_process_takes_the_machine_code_from_the_cache(tmp_path: Path) -> None:
    program = (
        "from seat_gear_dynamics.motion import load_system\n"
        "from seat_gear_dynamics.motion.lanes import respond_lanes\n"
        "respond_lanes(load_system().train, 0.5, 600.0, transient=1, periods=1, tangent=False, statistics=False,"
        " announce=print)\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    said = [
        subprocess.run([sys.executable, "-c", program], env=environment, check=True, capture_output=True, text=True)
        for _ in range(2)
    ]
    assert said[0].stdout.startswith("Compiling the lane kernel")
    assert said[1].stdout == ""
    assert list((tmp_path / "seat_gear_dynamics").glob("seat_gear_lanes_*.py"))


def test_the_cache_folder_is_numbas_where_that_is_given_else_the_platforms(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "/somewhere")
    assert cache_folder() == Path("/somewhere/seat_gear_dynamics")
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    assert cache_folder().is_absolute()
    assert "seat_gear_dynamics" in cache_folder().parts


def test_the_source_is_straight_line_code_that_names_its_rows() -> None:
    text = kernel_source(Structure(2, True, False, True, tangent=True, statistics=True), 16, cache=False)
    compile(text, "kernel", "exec")
    step = text[text.index("def advance(") : text.index("def march(")]
    assert step.count("for lane in range(16):") == 2
    loops = [line for line in step.splitlines() if line.lstrip().startswith(("for", "while", "if"))]
    assert len(loops) == 3, "a branch or loop inside the lane loop would keep it from becoming vector code"
    assert np.array([line.count("lanes[") <= 3 for line in step.splitlines()]).all()
