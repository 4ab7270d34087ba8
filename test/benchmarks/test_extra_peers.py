"""JiTCODE and heyoka: each ends where the motion does. Collected where the extra `peers` is installed, as in CI."""

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.peers.heyoka_batch import HeyokaBatch
from benchmarks.peers.jitcode_peer import INTEGRATORS, JitCode
from benchmarks.peers.task import Task

Array = NDArray[np.float64]
FORMS = ("printed", "reduced")


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_jitcode_ends_there(task: Task, ends: Array, integrator: str) -> None:
    few, exact = task.some(2), task.pair("printed").of_whole(ends)[[0, -1]]
    assert np.abs(JitCode(few, [], integrator).prepare(1e-9)() - exact).max() < 1e-5


@pytest.mark.parametrize("form", FORMS)
def test_heyoka_ends_there_with_its_own_events(task: Task, ends: Array, form: str) -> None:
    exact = task.pair(form).of_whole(ends)
    # Branches are held between events, so that its order is whole: as small as the tolerance allows.
    assert np.abs(HeyokaBatch(task, [], form=form).prepare(1e-12)() - exact).max() < 1e-9


def test_heyoka_refuses_what_fills_no_batch(task: Task) -> None:
    with pytest.raises(ValueError, match="do not fill batches"):
        HeyokaBatch(task.some(3), [])
