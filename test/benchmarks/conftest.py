"""The benchmarks are no part of the package: their folder's parent is put where imports look."""

import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from benchmarks.machine import installed  # noqa: E402
from benchmarks.peers.task import Task, reference  # noqa: E402
from seat_gear_dynamics.gears import GearTrain  # noqa: E402

# `scripts/test` alone brings no peers: 360 MB, and a C compiler, to measure against others. CI has them.
collect_ignore = [] if installed("jitcode") and installed("heyoka") else ["test_extra_peers.py"]


@pytest.fixture(scope="module")
def task(train: GearTrain) -> Task:
    """A motion that loses contact many times."""
    return Task("impacts", train, 150.0, np.linspace(0.95, 1.05, 8), 12)


@pytest.fixture(scope="module")
def ends(task: Task) -> NDArray[np.float64]:
    """Where it is at the end of the run, by steps that locate each change of contact."""
    found, changes = reference(task)
    assert (changes > 5).all()
    return found
