"""What lanes refuse, in sentences, and what they make of numbers for all lanes."""

from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.lanes import LanePoints, in_reach, respond_lanes, respond_trains
from seat_gear_dynamics.motion.lanes.excitation import level_of
from seat_gear_dynamics.motion.lanes.points import checked
from seat_gear_dynamics.motion.tables import LEVELS

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"frequency": [0.5, NAN], "load": 1.0}, "frequency of lane 1 is nan, expected a finite"),
        ({"frequency": [0.5, 0.0], "load": 1.0}, "frequency of lane 1 is 0, where there is no mesh period"),
        ({"frequency": 0.5, "load": [INF]}, "load of lane 0 is inf, expected a finite"),
        ({"frequency": 0.5, "load": 1.0, "damping_ratio": [0.1, -0.2]}, "damping ratio of lane 1 is -0.2, expected at"),
        ({"frequency": 0.5, "load": 1.0, "backlash": -1e-6}, "backlash of lane 0 is -1e-06, expected at least 0"),
        ({"frequency": [0.5, 0.6], "load": [1.0, 2.0, 3.0]}, "numbers of lanes: frequency 2, load 3; give all"),
        ({"frequency": [0.5, 0.6], "load": 1.0, "state": np.zeros((3, 24))}, "numbers of lanes: frequency 2, state 3"),
        ({"frequency": 0.5, "load": 1.0, "state": np.zeros(24)}, "states have shape (24,), expected (lanes, 24)"),
        ({"frequency": [[0.5]], "load": 1.0}, "expected numbers or arrays with one axis"),
        ({"frequency": 0.5, "load": 1.0, "transient": -1}, "-1 transient and 1 sampled periods; expected at least"),
        ({"frequency": 0.5, "load": 1.0, "periods": 0}, "0 transient and 0 sampled periods; expected at least"),
        ({"frequency": 0.5, "load": 1.0, "threads": 0}, "0 threads, expected at least 1"),
        ({"frequency": 0.5, "load": 1.0, "meshes": 3}, "3 meshes; expected 1 (P12) or 2"),
        (
            {"frequency": [0.5, -0.003], "load": 1.0},
            "lane 1 is -0.003, below the slowest that lanes can march, 0.00361",
        ),
    ],
)
def test_impossible_points_are_refused_in_one_sentence(train: GearTrain, given: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011  # the words are compared below
        respond_lanes(train, **({"transient": 0, "periods": 1} | given))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_half_of_a_coupled_train_is_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="2 where a shaft couples them"):
        respond_lanes(train.with_shaft(1e4), 0.5, 1.0, transient=0, periods=1, meshes=1)


def test_numbers_hold_for_all_lanes_and_states_count_them() -> None:
    found = checked(LanePoints(0.5, [1.0, 2.0], damping_ratio=0.1))
    assert found.frequency.tolist() == [0.5, 0.5]
    assert found.damping_ratio is not None
    assert found.damping_ratio.tolist() == [0.1, 0.1]
    assert found.backlash is None
    assert checked(LanePoints(0.5, 1.0, state=np.zeros((4, 24)))).load.tolist() == [1.0] * 4


def test_no_lanes_give_no_answers(train: GearTrain) -> None:
    found = respond_lanes(train, np.zeros(0), np.zeros(0), transient=1, periods=3)
    assert found.section.shape == (0, 3, 2)
    assert found.growth.shape == (0, 3)
    assert found.windows.shape == (0, 1, 6)
    assert found.state.shape == (0, 24)
    assert respond_trains([], transient=1, periods=3) == []


def test_levels_are_the_coarsest_with_steps_short_enough(train: GearTrain) -> None:
    base, longest = 272, 0.1
    slowest = 2 * np.pi / (longest * base * 2 ** (LEVELS - 1))
    frequency = np.array([2.0, 0.24, 0.23, 0.02, slowest * 1.0001, slowest * 0.999])
    level = level_of(frequency, base, longest)
    assert level.tolist() == [0, 0, 1, 4, LEVELS - 1, LEVELS]
    step = 2 * np.pi / (frequency * base * 2.0**level)
    assert (step[:-1] <= longest).all()
    assert (2 * step[level > 0][:-1] > longest).all()
    assert in_reach(train, frequency).tolist() == [True] * 5 + [False]
    assert level_of(-frequency, base, longest).tolist() == level.tolist()
