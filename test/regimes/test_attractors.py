"""Telling motions apart as sets, and finding those that coexist."""

from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System, integrate
from seat_gear_dynamics.regimes.attractors import LOST, attractors, same_motion, scatter, separation
from seat_gear_dynamics.regimes.basins import plane_starts

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]


def circle(points: int, radius: float = 1.0, begin: float = 0.0) -> Array:
    angle = begin + 2 * pi * (5**0.5 - 1) / 2 * np.arange(points)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def henon(points: int, x: float) -> Array:
    """Iterate the Hénon map at its classic parameters from (x, 0.1); the first 100 points are left out."""
    y, found = 0.1, []
    for _ in range(points + 100):
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        found.append((x, y))
    return np.array(found[100:])


def test_separation_of_two_points_is_their_distance() -> None:
    assert separation(np.array([[0.0, 0.0]]), np.array([[3.0, 4.0]])) == 5.0


def test_separation_is_the_larger_mean_way() -> None:
    # From {0} to {0, 1} it is 0, back it is (0 + 1)/2.
    assert separation(np.array([[0.0, 0.0]]), np.array([[0.0, 0.0], [1.0, 0.0]])) == 0.5


@given(st.integers(0, 1000), st.floats(0.01, 10), st.floats(-5, 5))
def test_separation_is_symmetric_scales_and_does_not_depend_on_order(seed: int, size: float, shift: float) -> None:
    rng = np.random.default_rng(seed)
    first, second = rng.normal(size=(20, 2)), rng.normal(size=(30, 2))
    found = separation(first, second)
    assert separation(second, first) == found
    # Sums in another order, and coordinates moved away from zero, round in the last digits.
    assert separation(rng.permutation(first), second) == pytest.approx(found, rel=1e-12)
    assert separation(size * first + shift, size * second + shift) == pytest.approx(size * found, rel=1e-9)


def test_an_empty_section_is_refused() -> None:
    with pytest.raises(ValueError, match="Sections of 0 and 1 points were compared"):
        separation(np.empty((0, 2)), np.ones((1, 2)))


def test_scatter_is_nothing_for_periodic_motion_and_the_way_of_a_transient() -> None:
    assert scatter(np.tile([[0.0, 1.0], [2.0, 3.0]], (20, 1))) == 0.0
    assert scatter(np.array([[0.0, 0.0], [1.0, 0.0]])) == 1.0
    assert scatter(np.zeros((1, 2))) == 0.0


def test_the_two_phases_of_a_doubled_motion_are_one_motion() -> None:
    doubled = np.tile([[0.0, 1.0], [2.0, 3.0]], (20, 1))
    assert same_motion(doubled, doubled[1:])
    assert not same_motion(doubled, doubled[::2])


@pytest.mark.parametrize(("start", "points"), [(0.0, 100), (0.3, 200), (0.63, 400)])
def test_two_records_of_one_strange_attractor_are_one_motion(start: float, points: int) -> None:
    assert same_motion(henon(points, 0.1), henon(points, start))


def test_a_strange_attractor_is_not_the_fixed_point_within_it() -> None:
    fixed = (-0.7 + (0.49 + 5.6) ** 0.5) / 2.8  # of the Hénon map
    assert not same_motion(henon(200, 0.1), np.tile([[fixed, 0.3 * fixed]], (200, 1)))


def test_tori_are_told_apart_by_where_they_lie_and_not_by_their_phase() -> None:
    assert same_motion(circle(100), circle(100, begin=1.0))
    assert not same_motion(circle(100), circle(100, radius=1.3))


@pytest.fixture(scope="module")
def folded(make_train: MakeTrain) -> System:
    """A lightly damped train between the folds of its resonance, where two motions coexist."""
    return System(make_train({"meshes.*.damping_ratio": 0.05})).at(frequency=0.7, load=100.0)


def test_motions_that_coexist_are_found_and_stay_where_they_are(folded: System) -> None:
    told: list[tuple[int, int]] = []
    starts = plane_starts(folded, [-2.4, 0.5, 2.0], [0.0])
    found, labels = attractors(
        folded, starts, transient=200, periods=96, workers=2, progress=lambda *done: told.append(done)
    )
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert len(found) == 2
    assert sorted(set(labels.tolist())) == [0, 1]
    assert [each.regime.name for each in found] == ["periodic", "periodic"]
    for each in found:
        onward = integrate(folded, transient=0, periods=96, state=each.state)
        assert same_motion(onward.section, each.section)


def test_the_numbering_follows_the_starts_and_not_the_threads(folded: System) -> None:
    starts = plane_starts(folded, [-2.4, 2.0], [0.0])
    options: Any = {"transient": 60, "periods": 48}
    found, labels = attractors(folded, starts, workers=1, **options)
    again, same = attractors(folded, starts, workers=3, **options)
    assert labels.tolist() == same.tolist()
    assert labels[0] == 0
    assert [each.section.tolist() for each in found] == [each.section.tolist() for each in again]


def test_a_start_that_diverges_is_lost_and_no_motion(folded: System) -> None:
    found, labels = attractors(folded, np.full((1, 24), float("nan")), transient=1, periods=48)
    assert (found, labels.tolist()) == ((), [LOST])


@pytest.mark.parametrize("shape", [(24,), (0, 24), (3, 12)])
def test_starts_of_another_shape_are_refused(folded: System, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"The starts have shape .* expected \(n, 24\)"):
        attractors(folded, np.zeros(shape))
