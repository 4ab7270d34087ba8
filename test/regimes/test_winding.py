"""Weighted averages: their speed on tori, the winding numbers they give, and what wanders."""

from itertools import pairwise
from math import pi, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.winding import by_piece, wandering, weighted_mean, winding_number, windowed_means

Array = NDArray[np.float64]
GOLDEN = (5**0.5 - 1) / 2


def circle_map(points: int, drive: float, coupling: float) -> Array:
    """Lift of the sine circle map θ → θ + Ω − K/(2π)·sin 2πθ, (points,), after 500 steps."""
    theta, found = 0.1, []
    for n in range(points + 500):
        if n >= 500:
            found.append(theta)
        theta += drive - coupling / (2 * pi) * sin(2 * pi * theta)
    return np.array(found)


def on_circle(theta: NDArray[np.floating[Any]]) -> Array:
    return np.column_stack([np.cos(2 * pi * theta), np.sin(2 * pi * theta)])


def rotation(points: int, turns: float) -> Array:
    return on_circle(turns * np.arange(points))


@given(st.integers(1, 300), st.floats(-1e3, 1e3))
def test_the_weighted_mean_of_a_constant_is_the_constant(points: int, value: float) -> None:
    assert weighted_mean(np.full((points, 2), value)).tolist() == pytest.approx([value, value])


def test_the_weighted_mean_does_not_depend_on_the_direction_of_time() -> None:
    values = np.random.default_rng(0).normal(size=101)
    assert float(weighted_mean(values[::-1])) == pytest.approx(float(weighted_mean(values)), abs=1e-14)


def test_averages_of_a_rotation_converge_faster_than_any_power() -> None:
    # The average of a rotating phase is 0, and the plain one of order 1/n. An error below every power of 1/n (Das et
    # al. 2017) gains more by each doubling of n than by the one before.
    errors = [float(np.hypot(*weighted_mean(rotation(points, GOLDEN)))) for points in (25, 50, 100, 200)]
    gains = [coarse / fine for coarse, fine in pairwise(errors)]
    assert 64 < gains[0] < gains[1] < gains[2]
    plain = [float(np.hypot(*rotation(points, GOLDEN).mean(axis=0))) for points in (25, 200)]
    assert plain[0] / plain[1] < 64


@pytest.mark.parametrize("points", [2, 3, 10, 11])
def test_windows_are_the_early_the_middle_and_the_late_half(points: int) -> None:
    values, half = np.arange(float(points)), points // 2
    found = windowed_means(values)
    # Of a straight line a symmetric weight gives the middle value of each window.
    assert found[0] == pytest.approx((half - 1) / 2)
    assert found[2] == pytest.approx(points - 1 - (half - 1) / 2)
    assert found[0] <= found[1] <= found[2]


@settings(max_examples=60)
@given(st.floats(0.1, 0.9), st.integers(100, 300))
def test_winding_number_of_a_rotation_is_its_angle_folded(turns: float, points: int) -> None:
    # Ten turns and more: by then the weight has averaged the middle of the curve to about 1e-9 of its radius.
    assert winding_number(rotation(points, turns)) == pytest.approx(min(turns, 1 - turns), abs=1e-8)


def test_golden_winding_of_the_critical_circle_map_is_found_where_the_literature_has_it() -> None:
    # At K = 1 the winding number (√5 − 1)/2 is met at Ω = 0.606661063470 (Shenker 1982, Physica D 5, 405); the critical
    # circle is not smooth, so that the average converges as 1/n² only.
    section = on_circle(circle_map(2000, 0.606661063470, 1.0))
    assert winding_number(section) == pytest.approx(1 - GOLDEN, abs=1 / 2000)


@pytest.mark.parametrize(("drive", "coupling"), [(0.2, 0.5), (0.3, 0.8), (0.45, 0.9)])
def test_winding_of_the_circle_map_is_the_mean_advance_of_its_lift(drive: float, coupling: float) -> None:
    theta = circle_map(200_000, drive, coupling)
    # The mean advance over n steps is within 1/n of the winding number (Poincaré); the other half is the average's.
    expected = (theta[-1] - theta[0]) / (len(theta) - 1)
    assert winding_number(on_circle(theta[:2000])) == pytest.approx(min(expected, 1 - expected), abs=2 / 200_000)


def test_a_curve_bent_by_a_smooth_change_of_variables_winds_as_before() -> None:
    angle = 2 * pi * 0.2137 * np.arange(800)
    bent = angle + 0.4 * np.sin(angle)
    radius = 1 + 0.3 * np.cos(3 * angle)
    section = np.column_stack([2 * radius * np.cos(bent), radius * np.sin(bent) + 5])
    assert winding_number(section) == pytest.approx(0.2137, abs=1e-8)


def test_a_curve_on_which_the_motion_goes_back_and_forth_winds_as_often_as_it_goes_round() -> None:
    # The angle steps back on part of the curve, so that turns lie on both sides of zero.
    angle = 2 * pi * 0.0213 * np.arange(1500)
    section = on_circle(0.0213 * np.arange(1500) + 1.5 / (2 * pi) * np.sin(angle))
    # The middle of a curve gone round 32 times is known to 1e-9 (above); its turns average as well.
    assert winding_number(section) == pytest.approx(0.0213, abs=1e-8)


def test_winding_on_several_curves_is_counted_from_visit_to_visit() -> None:
    index = np.arange(900)
    section = 0.1 * rotation(900, 0.0) + np.column_stack([index % 3, np.zeros(900)])
    section += 0.1 * on_circle(0.3123 * (index // 3))
    assert winding_number(section, pieces=3) == pytest.approx(0.3123, abs=1e-8)


def test_averages_on_a_torus_agree_ever_better_and_those_of_noise_as_the_root_of_its_length() -> None:
    tori = [wandering(rotation(points, GOLDEN)) for points in (100, 200, 400)]
    assert tori[0] > 10 * tori[1] > 100 * tori[2]
    rng = np.random.default_rng(6)
    noise = [np.mean([wandering(rng.normal(size=(points, 2))) for _ in range(200)]) for points in (100, 400)]
    # Means of 200 values that scatter by about a third: known to 2.5 % each.
    assert noise[0] / noise[1] == pytest.approx(2, rel=0.1)


@given(st.floats(1e-3, 1e3), st.floats(-100, 100))
def test_wandering_does_not_depend_on_unit_and_origin(scale: float, shift: float) -> None:
    section = np.random.default_rng(1).normal(size=(60, 2))
    assert wandering(scale * section + shift) == pytest.approx(wandering(section), rel=1e-6)


def test_wandering_of_a_transient_is_what_changed() -> None:
    decay = np.exp(-0.003 * np.arange(400))[:, None]
    assert wandering(decay * rotation(400, GOLDEN)) > 0.1 > 1e5 * wandering(rotation(400, GOLDEN))


def test_each_piece_is_averaged_by_itself() -> None:
    # A fixed order of pieces is no irregularity, and a coordinate that does not move says nothing.
    section = np.tile([[0.0, 0.0], [1.0, 0.0]], (50, 1))
    assert wandering(section, pieces=2) == 0
    section[:, 0] += 1e-3 * np.random.default_rng(2).normal(size=100)
    assert wandering(section, pieces=2) > 0.01


def test_rounds_are_the_newest_whole_ones() -> None:
    section = np.arange(14.0).reshape(7, 2)
    assert by_piece(section, 3).tolist() == section[1:].reshape(2, 3, 2).tolist()


@pytest.mark.parametrize("pieces", [0, -1, 11])
def test_pieces_that_make_no_round_are_refused(pieces: int) -> None:
    with pytest.raises(ValueError, match=rf"{pieces} pieces were asked of 10 section points"):
        by_piece(np.zeros((10, 2)), pieces)


def test_records_too_short_to_average_are_refused() -> None:
    with pytest.raises(ValueError, match="7 points of 2 pieces were given; expected at least 8 points"):
        wandering(np.zeros((7, 2)), pieces=2)
    with pytest.raises(ValueError, match="8 points of 3 pieces were given; expected at least 9 points"):
        winding_number(np.zeros((8, 2)), pieces=3)
