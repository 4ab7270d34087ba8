"""The compiled right-hand side against the plain one, on free and on held branches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.motion.integrators import right_hand_side
from seat_gear_dynamics.motion.integrators.field import FREE, _evaluate, field_of


@pytest.mark.parametrize("frequency", [1.3, 0.0, -0.6])
def test_the_compiled_right_hand_side_is_the_plain_one_in_every_variant(variant: GearTrain, frequency: float) -> None:
    system = System(variant).at(frequency=frequency, load=300.0)
    compiled, rng = right_hand_side(system), np.random.default_rng(3)
    for _ in range(30):
        tau, state = rng.uniform(0, 300), rng.normal(0, 1.5, 24)  # in and out of the backlash of ±1
        # Both add some hundred products of the order of 1: rounding alone.
        assert compiled(tau, state) == pytest.approx(system.derivative(tau, state), rel=1e-12, abs=1e-11)


@given(st.integers(0, 2**32 - 1))
def test_a_branch_that_delta_is_on_changes_nothing_by_being_held(train: GearTrain, seed: int) -> None:
    rng = np.random.default_rng(seed)
    system = System(train).at(frequency=1.1, load=100.0)
    tau, state = rng.uniform(0, 100), rng.normal(0, 1.5, 24)
    delta, _ = system.deflections(tau, state)
    held = np.where(delta > 1, 1, np.where(delta < -1, -1, 0))
    found = _evaluate(tau, state[None], held, field_of(system))
    assert found == pytest.approx(_evaluate(tau, state[None], np.full(2, FREE), field_of(system)), abs=1e-12)


@pytest.mark.parametrize("branches", [(1, 0), (0, -1), (-1, 1)])
def test_a_held_branch_is_one_affine_law_on_both_sides_of_its_boundary(
    variant: GearTrain, branches: tuple[int, int]
) -> None:
    system, held, rng = System(variant).at(frequency=0.8, load=200.0), np.array(branches), np.random.default_rng(5)
    field = field_of(system)
    near, far = rng.normal(0, 0.1, 24), rng.normal(0, 3.0, 24)  # inside the backlash, and anywhere

    def rates(state: np.ndarray) -> np.ndarray:
        return np.asarray(_evaluate(7.0, state[None], held, field))

    assert rates((near + far) / 2) == pytest.approx((rates(near) + rates(far)) / 2, rel=1e-12, abs=1e-12)
    for j, branch in enumerate(branches):  # where δ is on the branch, the law is that of (1)
        if branch:
            state = np.zeros(24)
            state[[2, 8]] = 3.0 * held  # δ of both meshes beyond the held flank or, at 0, in the middle
            own = slice(12 + 6 * j, 18 + 6 * j)
            assert rates(state)[own] == pytest.approx(system.derivative(7.0, state)[own], rel=1e-12, abs=1e-12)
