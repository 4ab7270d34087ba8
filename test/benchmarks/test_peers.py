"""The peers: that they integrate the machine's own equations, and that each ends where the motion does."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.peers.measure import cheapest, kernel_error
from benchmarks.peers.pair import pair_of
from benchmarks.peers.scipy_rk45 import ScipyRk45, field
from benchmarks.peers.task import Run, Task, outside_reference, reference, tasks
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import OperatingPoint, System
from seat_gear_dynamics.motion.lanes.reduction import expand_state, reduced

Array = NDArray[np.float64]
FORMS = ("printed", "reduced")


@pytest.mark.parametrize("form", FORMS)
def test_both_forms_are_the_public_equations(train: GearTrain, form: str) -> None:
    pair, random = pair_of(train, 600.0, form=form), np.random.default_rng(1)
    arguments = ScipyRk45(Task("", train, 600.0, np.array([0.8]), 1), [], form=form)._arguments
    system = System(train, OperatingPoint(0.8, 600.0))
    line = reduced(train).line
    for t in (0.0, 1.3, 7.0):
        # Motion along the lines of action, which is all that the reduced form has; some of it within the backlash.
        y = expand_state(random.normal(0.0, 1.0, (1, 16)), line)
        expected = pair.of_whole(system.derivative(t, y[0])[None])[0]
        found = field(t, pair.of_whole(y)[0], 0.8, *arguments)
        # Some twenty terms, none far larger than the largest sum, are added in another order.
        assert found == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())


def test_the_reference_is_where_an_outside_integrator_ends(task: Task, ends: Array) -> None:
    for form in FORMS:
        pair = task.pair(form)
        # DOP853 at 1e-12 over some hundred steps, magnified a little by each impact.
        found = outside_reference(pair, float(task.frequencies[0]), task.periods)
        assert found == pytest.approx(pair.of_whole(ends)[0], abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_scipy_ends_there(task: Task, ends: Array, form: str) -> None:
    few, exact = task.some(2), task.pair(form).of_whole(ends)[[0, -1]]
    errors = [float(np.abs(ScipyRk45(few, [x], form=form).prepare(x)() - exact).max()) for x in (1e-4, 1e-9)]
    assert errors[1] < 1e-5 < errors[0]  # corners leave RK45 an error far above its tolerance


def test_the_kernel_errs_by_what_its_fixed_step_does(train: GearTrain) -> None:
    # Across impacts its order is two: with 272 steps a period some 1e-4, and never the 1e-12 of the reference.
    motion = Task("impacts", train, 150.0, np.array([0.95, 1.05]), 3)
    found, _ = reference(motion)
    assert 1e-9 < kernel_error(motion, 272, "printed", motion.pair("printed").of_whole(found)) < 1e-2


def test_the_tasks_are_spread_about_their_frequencies(train: GearTrain) -> None:
    contact, impacts = tasks(train, points=5, periods=3)
    assert contact.frequencies == pytest.approx([0.396, 0.398, 0.4, 0.402, 0.404], abs=1e-15)
    assert impacts.some(2).frequencies == pytest.approx([0.99, 1.01], abs=1e-15)


class Fake:
    """A peer whose error is its tolerance times ten, but for one setting that is right by luck."""

    settings: Sequence[float] = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)

    def __init__(self) -> None:
        self.prepared: list[float] = []

    def prepare(self, setting: float) -> Run:
        self.prepared.append(setting)
        error = 0.0 if setting == 1e-2 else 10 * setting
        return lambda: np.array([[1.0 + error]])


def test_the_search_ends_once_two_settings_meet_the_mark() -> None:
    peer = Fake()
    met = cheapest(peer, np.array([[1.0]]), 0.02)
    assert met is not None
    assert peer.prepared == [1e-1, 1e-2, 1e-3]
    assert met.error <= 0.02


def test_no_setting_may_meet_the_mark() -> None:
    assert cheapest(Fake(), np.array([[5.0]]), 1e-3) is None
