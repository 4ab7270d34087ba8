"""The reduced coordinates: nothing but motion across the line of action is lost, and the rest is the march's own."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain, Variant
from seat_gear_dynamics.motion import System, coefficients
from seat_gear_dynamics.motion.coefficients import static_state
from seat_gear_dynamics.motion.lanes import structure as structure_module
from seat_gear_dynamics.motion.lanes import supports
from seat_gear_dynamics.motion.lanes.reduction import expand_state, reduce_state, reduced, static_rest

Array = NDArray[np.float64]


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_states_along_the_line_of_action_come_back_from_reduction(train: GearTrain, seed: int) -> None:
    line, state = reduced(train).line, np.random.default_rng(seed).normal(size=(5, 16))
    assert reduce_state(expand_state(state, line), line) == pytest.approx(state, abs=1e-14)  # rounding of a projection


def test_what_reduction_drops_is_across_the_line_of_action_and_closes_no_mesh(train: GearTrain) -> None:
    r, state = reduced(train), np.random.default_rng(0).normal(size=(1, 24))
    dropped = state - expand_state(reduce_state(state, r.line), r.line)
    assert np.abs(dropped).max() > 0.1
    closing = (dropped.reshape(4, 6) * coefficients(train).direction.reshape(2, 6)[[0, 1, 0, 1]]).sum(axis=1)
    assert closing == pytest.approx(np.zeros(4), abs=1e-14)


@pytest.mark.parametrize("shaft", [0.0, 2.6e4])
def test_motion_across_the_line_of_action_is_never_excited(train: GearTrain, shaft: float) -> None:
    kind = train.with_shaft(shaft)
    r = reduced(kind)
    state = expand_state(np.random.default_rng(3).normal(size=(1, 16)), r.line)
    rate = System(kind).at(frequency=0.8, load=200.0).derivative(1.3, state[0])
    assert expand_state(reduce_state(rate[None], r.line), r.line)[0] == pytest.approx(rate, abs=1e-14)


@pytest.mark.parametrize("load", [600.0, 3.0, 0.02, 0.0, -0.02, -40.0])
@pytest.mark.parametrize("shaft", [0.0, 2.6e4])
@pytest.mark.parametrize("variant", [Variant(True, False), Variant(False, False)], ids=str)
def test_static_rest_is_that_of_the_march(train: GearTrain, load: float, shaft: float, variant: Variant) -> None:
    kind = replace(train, variant=variant).with_shaft(shaft)
    for backlash in (20e-6, 0.0):
        cut = kind.with_mesh(0, backlash=backlash).with_mesh(1, backlash=backlash)
        r = reduced(kind)
        found = static_rest(r, np.array([load]), np.full((1, 2), backlash / 2 / r.length_unit))
        state = expand_state(np.hstack([found, np.zeros((1, 8))]), r.line)[0]
        # Both solve the same balance by least squares, whose condition is about 1e6 with these soft torsional supports.
        assert state == pytest.approx(static_state(cut, load), rel=1e-9, abs=1e-10)


def test_static_rest_of_a_lane_does_not_depend_on_its_neighbours(train: GearTrain) -> None:
    r, rng = reduced(train), np.random.default_rng(5)
    load, half = rng.uniform(-300, 600, 37), rng.uniform(0, 2, (37, 2))
    together = static_rest(r, load, half)
    alone = np.concatenate([static_rest(r, load[n : n + 1], half[n : n + 1]) for n in range(37)])
    assert together.tobytes() == alone.tobytes()


def test_every_variant_of_a_described_train_is_supported(make_train: Callable[..., GearTrain]) -> None:
    for train in (make_train(), make_train({"gears.*.eccentricity": 40}).with_shaft(1e4)):
        for variant in (Variant(True, False), Variant(False, True)):
            assert supports(replace(train, variant=variant))


@pytest.mark.parametrize("field", ["stiffness", "damping", "reaction", "drive"])
def test_a_train_held_differently_in_x_and_y_is_not_supported(
    train: GearTrain, monkeypatch: pytest.MonkeyPatch, field: str
) -> None:
    own = coefficients(train)
    changed = getattr(own, field).copy()
    changed[9] += 1e-3  # x4
    monkeypatch.setattr(structure_module, "coefficients", lambda _: replace(own, **{field: changed}))
    assert not supports(train)
