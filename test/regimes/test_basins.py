"""Basins of attraction over the plane of initial states of P12."""

from collections.abc import Callable
from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import STATE_NAMES, System
from seat_gear_dynamics.regimes.attractors import LOST
from seat_gear_dynamics.regimes.basins import Basins, basins, plane_starts

MakeTrain = Callable[..., GearTrain]


@settings(max_examples=20)
@given(delta=st.floats(-5, 5), rate=st.floats(-3, 3), frequency=st.floats(0.1, 2), load=st.floats(0, 600))
def test_starts_have_the_deflection_and_rate_asked_for_and_turn_s1_alone(
    train: GearTrain, delta: float, rate: float, frequency: float, load: float
) -> None:
    system = System(train).at(frequency=frequency, load=load)
    (start,) = plane_starts(system, [delta], [rate])
    found = system.deflections(0.0, start)
    assert (found[0][0], found[1][0]) == pytest.approx((delta, rate), abs=1e-12)
    moved = [name for name, a, b in zip(STATE_NAMES, start, system.static_state(), strict=True) if a != b]
    assert set(moved) <= {"u1", "u1'"}


def test_starts_run_through_the_plane_row_by_row(train: GearTrain) -> None:
    system = System(train).at(frequency=0.5, load=100.0)
    starts = plane_starts(system, [0.0, 1.0, 2.0], [-1.0, 1.0])
    found = np.array([[each[0] for each in system.deflections(0.0, start)] for start in starts])
    expected = [[d, r] for r in (-1.0, 1.0) for d in (0.0, 1.0, 2.0)]
    assert found == pytest.approx(np.array(expected), abs=1e-12)


def test_a_linear_train_has_one_basin(make_train: MakeTrain, steady: Callable[[GearTrain], GearTrain]) -> None:
    edits = {"meshes.*.backlash": 0, "*damping_ratio": 0.3, "*.torsional_stiffness": 2e7}
    system = System(steady(make_train(edits))).at(frequency=0.6, load=300.0)
    found = basins(system, [-3.0, 3.0], [-1.0, 1.0], transient=40, periods=48)
    assert found.labels.tolist() == [[0, 0], [0, 0]]
    assert (found.attractors[0].regime.name, found.attractors[0].regime.period) == ("periodic", 1)
    assert (found.share(0).value, found.share(0).error) == (1.0, 0.0)
    assert found.share(LOST).value == 0.0


def test_a_train_between_its_folds_has_a_basin_for_each_of_its_two_motions(make_train: MakeTrain) -> None:
    system = System(make_train({"meshes.*.damping_ratio": 0.05})).at(frequency=0.7, load=100.0)
    found = basins(system, [-2.4, 0.5, 2.0], [-0.3, 0.0], transient=200, periods=96, workers=2)
    assert found.labels.shape == (2, 3)
    assert len(found.attractors) == 2
    losses = [each.force.contact_loss for each in found.attractors]
    assert abs(losses[0] - losses[1]) > 0.2
    shares = [found.share(label) for label in range(2)]
    assert sum(share.value for share in shares) == pytest.approx(1.0)
    assert shares[0].error == shares[1].error > 0


def test_the_error_of_a_share_is_the_binomial_one() -> None:
    labels = np.array([[0, 0, 0, 1], [LOST, 0, 0, 1]])
    found = Basins(np.arange(4.0), np.arange(2.0), labels, ())
    assert found.share(0).value == 5 / 8
    assert found.share(0).error == pytest.approx(sqrt(5 / 8 * 3 / 8 / 8))
    assert found.share(LOST).value == 1 / 8


@pytest.mark.parametrize(
    ("deflections", "rates", "sentence"),
    [
        ([1.0, 0.0], [0.0], "The deflections are .* expected finite numbers of b_c"),
        ([0.0], [float("nan")], "The rates are .* expected finite numbers of b_c per τ"),
        ([], [0.0], "The deflections are"),
    ],
)
def test_planes_that_do_not_increase_are_refused(
    train: GearTrain, deflections: list[float], rates: list[float], sentence: str
) -> None:
    with pytest.raises(ValueError, match=sentence):
        basins(System(train), deflections, rates)
