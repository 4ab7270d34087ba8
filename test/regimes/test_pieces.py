"""Counting closed curves and bands of sections that are known."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist, squareform

from seat_gear_dynamics.regimes.pieces import Pieces, pieces
from seat_gear_dynamics.regimes.pieces import _shortest_tree as shortest_tree

Array = NDArray[np.float64]
GOLDEN = (5**0.5 - 1) / 2


def curves(points: int, count: int, turns: float = GOLDEN, size: float = 0.1) -> Array:
    """A motion that visits `count` ovals around the unit circle in turn, by `turns` of a turn from visit to visit."""
    index = np.arange(points)
    centre = 2 * pi * (index % count) / count
    angle = 2 * pi * turns * (index // count) + centre
    radius = size * (1 + 0.3 * np.cos(2 * angle))
    return np.column_stack([np.cos(centre) + radius * np.cos(angle), np.sin(centre) + 0.4 * radius * np.sin(angle)])


def logistic(points: int, r: float) -> Array:
    x, section = 0.3123, []
    for n in range(points + 2000):
        following = r * x * (1 - x)
        if n >= 2000:
            section.append((x, following))
        x = following
    return np.array(section)


@settings(max_examples=40)
@given(st.integers(1, 10), st.sampled_from([GOLDEN, 2**0.5 - 1, 0.137, 0.29]), st.integers(0, 40))
def test_as_many_curves_are_found_as_there_are(count: int, turns: float, more: int) -> None:
    found = pieces(curves(40 * count + more, count, turns, 0.5 / count))
    assert (found.count, found.closed, found.filled) == (count, True, True)


@pytest.mark.parametrize(("r", "bands"), [(3.575, 4), (3.58, 4), (3.6, 2), (3.65, 2), (3.7, 1), (3.9, 1), (4.0, 1)])
def test_bands_of_the_logistic_map_merge_where_the_literature_has_it(r: float, bands: int) -> None:
    # Four bands merge into two at r = 3.5926 and two into one at 3.6786 (Grossmann & Thomae 1977).
    assert pieces(logistic(600, r)).count == bands


def test_an_orbit_of_period_three_has_three_pieces_without_extent() -> None:
    section = np.tile([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]], (20, 1))
    assert pieces(section).count == 3
    assert pieces(section).gap == 0


def test_points_in_no_order_are_one_piece_however_they_cluster() -> None:
    section = curves(300, 3)
    assert pieces(np.random.default_rng(0).permutation(section)).count == 1


def test_arcs_are_closed_once_the_motion_has_come_round_on_them() -> None:
    # A third of a turn and 0.0005: 0.0015 a round of three, so a curve closes after 3/0.0015 = 2000 points.
    angle = 2 * pi * (1 / 3 + 0.0005) * np.arange(4000)
    section = np.column_stack([np.cos(angle), np.sin(angle)])
    assert (pieces(section[:400]).count, pieces(section[:400]).closed) == (3, False)
    assert (pieces(section[:1200]).count, pieces(section[:1200]).closed) == (1, True)


def test_a_single_slow_arc_is_not_closed() -> None:
    angle = 2 * pi * 0.001 * np.arange(400)
    found = pieces(np.column_stack([np.cos(angle), np.sin(angle)]))
    assert (found.count, found.closed) == (1, False)
    assert found.gap < 0.01


def test_the_cantor_set_at_the_accumulation_point_is_not_filled_at_any_length() -> None:
    # r∞ = 3.5699456718 (Feigenbaum 1978). Each piece falls into two, with the same relative hole at every scale.
    gaps = [pieces(logistic(points, 3.5699456718)).gap for points in (200, 400, 800)]
    assert all(0.4 < gap < 0.5 for gap in gaps)


def test_no_more_pieces_are_looked_for_than_asked() -> None:
    assert pieces(curves(480, 12, size=0.04), most=12).count == 12
    assert pieces(curves(480, 12, size=0.04), most=6).count < 7


@settings(max_examples=30)
@given(st.floats(0, 6.3), st.floats(1e-3, 1e3), st.floats(-10, 10))
def test_turning_scaling_and_moving_the_section_changes_nothing(angle: float, scale: float, shift: float) -> None:
    section = curves(240, 3)
    turned = scale * section @ np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]]) + shift
    expected, found = pieces(section), pieces(turned)
    assert (found.count, found.closed) == (expected.count, expected.closed)


@given(st.integers(16, 60), st.integers(0, 1000))
def test_the_tree_is_as_short_as_scipys_and_knows_each_nearest_point(points: int, seed: int) -> None:
    section = np.random.default_rng(seed).normal(size=(points, 2))
    _, _, length, nearest = shortest_tree(section)
    # The shortest total is unique where the tree may not be; sums of at most 60 lengths differ by rounding.
    assert length.sum() == pytest.approx(minimum_spanning_tree(squareform(pdist(section))).sum(), rel=1e-12)
    assert nearest.tolist() == cKDTree(section).query(section, k=2)[1][:, 1].tolist()


def test_a_constant_is_one_piece_that_is_not_gone_round() -> None:
    assert pieces(np.ones((50, 2))) == Pieces(1, False, 0.0)


@pytest.mark.parametrize("section", [np.empty((0, 2)), np.zeros((15, 2)), np.zeros((40, 3)), np.zeros(40)])
def test_sections_of_other_shapes_are_refused(section: Array) -> None:
    with pytest.raises(ValueError, match=r"expected \(n, 2\) with n of at least 16"):
        pieces(section)
