"""The whole state of a march: a motion set to it goes on as the motion it was taken from, bit for bit."""

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March
from seat_gear_dynamics.motion.march import WHOLE_NAMES


def drive(march: March, begin: float, frequency: float, load: float = 600.0) -> tuple[list[object], np.ndarray]:
    """Advance by 30 units of τ; return the windows, and the section points met."""
    inputs = Inputs(frequency, load)
    pieces: list[np.ndarray] = []
    windows = [march.advance((begin + k, inputs), (begin + k + 1, inputs), pieces.append) for k in range(30)]
    return list(windows), np.concatenate(pieces) if pieces else np.empty((0, 5))


# 1e-4 turns by less than a grid step at each step: the creep, whose unspent phase is part of the state.
@pytest.mark.parametrize("frequency", [0.5, -1.31, 1e-4])
def test_a_march_set_to_the_whole_state_goes_on_bit_for_bit(train: GearTrain, frequency: float) -> None:
    first = March(train, load=600.0)
    drive(first, 0.0, 0.9)
    begin = first.tau
    second = March(train, load=10.0)
    second.whole = first.whole
    windows, points = drive(first, begin, frequency)
    again, points_again = drive(second, begin, frequency)
    assert again == windows
    assert points_again.tolist() == points.tolist()
    assert second.whole.tolist() == first.whole.tolist()


def test_the_state_alone_is_not_enough(train: GearTrain) -> None:
    """The 24 numbers leave out the mesh phase: without it the motion goes on differently."""
    first = March(train, load=600.0)
    drive(first, 0.0, 0.9)
    second = March(train, load=600.0)
    second.state = first.state
    assert drive(second, 0.0, 0.5)[0] != drive(first, first.tau, 0.5)[0]


def test_it_is_a_copy_both_ways(train: GearTrain) -> None:
    march = March(train, load=600.0)
    drive(march, 0.0, 0.5)
    taken = march.whole
    march.whole = taken
    taken[:] = 0.0
    assert march.whole.any()
    march.whole[:] = 0.0
    assert march.whole.any()


def test_each_number_has_a_name(train: GearTrain) -> None:
    assert len(set(WHOLE_NAMES)) == len(WHOLE_NAMES) == len(March(train).whole) == 54


@pytest.mark.parametrize("shape", [(24,), (55,), (54, 1), (0,)])
def test_another_shape_is_refused(train: GearTrain, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"expected \(54,\)"):
        March(train).whole = np.zeros(shape)
