"""What numbers depend on beside the question, and how a difference is told."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import seat_gear_dynamics
from seat_gear_dynamics.cluster.build import CODE, MACHINE, build, difference

PACKAGE = Path(seat_gear_dynamics.__file__).parent


def test_a_build_names_everything_that_numbers_depend_on() -> None:
    found = build()
    assert set(found) == {*CODE, *MACHINE}
    assert all(found.values())
    assert found["numpy"] == np.__version__
    assert found["package"] == seat_gear_dynamics.__version__


def build_of(folder: Path, **environment: str) -> str:
    """Return the build of another process, whose package is in `folder`."""
    code = "from seat_gear_dynamics.cluster.build import build; print(dict(build()))"
    # Not from here, where Python would find this package first.
    own = {"PYTHONPATH": str(folder), **environment}
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, env=own, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_another_process_of_the_same_package_has_the_same_build_and_one_of_edited_sources_has_not(
    tmp_path: Path,
) -> None:
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, tmp_path / "seat_gear_dynamics", ignore=ignored)
    first = build_of(tmp_path)
    assert build_of(tmp_path) == first
    with (tmp_path / "seat_gear_dynamics" / "motion" / "kernel.py").open("a") as file:
        file.write("# another step\n")
    second = build_of(tmp_path)
    assert second != first
    assert second.split("'sources'")[0] == first.split("'sources'")[0]


def test_another_target_of_the_compiler_is_another_processor() -> None:
    assert "'processor': 'generic-" in build_of(PACKAGE.parent, NUMBA_CPU_NAME="generic")


@pytest.mark.parametrize(
    ("names", "words"),
    [(CODE, "numpy 2, expected 1"), (MACHINE, "processor unknown, expected old"), (("scipy",), None)],
)
def test_the_first_difference_is_told_in_words(names: tuple[str, ...], words: str | None) -> None:
    expected = {"numpy": "1", "scipy": "1", "processor": "old"}
    assert difference(expected, {"numpy": "2", "scipy": "1"}, names) == words
