"""Telling tori from slow transients, weak chaos, noise and locked motion."""

from math import cos, log, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.regimes import classify

Array = NDArray[np.float64]
Record = tuple[Array, Array]
GOLDEN = (5**0.5 - 1) / 2


def curves(points: int, count: int, turns: float = GOLDEN, size: float = 0.1) -> Array:
    """A torus of the `count`-th iterate: ovals around the unit circle, visited in turn, `turns` from visit to visit."""
    index = np.arange(points)
    centre = 2 * pi * (index % count) / count
    angle = 2 * pi * turns * (index // count) + centre
    radius = size * (1 + 0.3 * np.cos(2 * angle))
    return np.column_stack([np.cos(centre) + radius * np.cos(angle), np.sin(centre) + 0.4 * radius * np.sin(angle)])


def circle_map(points: int, drive: float, coupling: float) -> Record:
    """Sine circle map θ → θ + Ω − K/(2π)·sin 2πθ on its circle, after 500 steps."""
    theta, section, growth = 0.1, [], []
    for n in range(points + 500):
        if n >= 500:
            section.append((cos(2 * pi * theta), sin(2 * pi * theta)))
            growth.append(log(abs(1 - coupling * cos(2 * pi * theta))))
        theta += drive - coupling / (2 * pi) * sin(2 * pi * theta)
    return np.array(section), np.array(growth)


def delayed_logistic(points: int, a: float) -> Record:
    """x(n + 1) = a·x(n)·(1 − x(n − 1)), after 2000 steps, with the growth of a tangent."""
    x, y, tangent, section, growth = 0.5, 0.4, np.array([1.0, 0.3]), [], []
    for n in range(points + 2000):
        tangent = np.array([[a * (1 - y), -a * x], [1.0, 0.0]]) @ tangent
        x, y = a * x * (1 - y), x
        length = float(np.hypot(*tangent))
        tangent /= length
        if n >= 2000:
            section.append((x, y))
            growth.append(log(length))
    return np.array(section), np.array(growth)


def spiral(points: int, decay: float, turns: float = GOLDEN) -> Record:
    index = np.arange(points)
    angle, size = 2 * pi * turns * index, np.exp(-decay * index)
    return np.column_stack([size * np.cos(angle), size * np.sin(angle)]), np.full(points, -decay)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 8])
@pytest.mark.parametrize("turns", [GOLDEN, 2**0.5 - 1])
def test_a_torus_of_the_nth_iterate_is_quasi_period_n(count: int, turns: float) -> None:
    regime = classify(curves(200 * count, count, turns, 0.5 / count), np.zeros(200 * count), 1.0)
    assert (regime.name, regime.pieces, regime.label) == ("quasi-periodic", count, f"quasi-period-{count}")
    assert regime.winding == pytest.approx(min(turns, 1 - turns), abs=1e-5)
    assert regime.period is None
    assert f"{count} closed curve" in regime.reason


@settings(max_examples=25)
@given(st.integers(1, 3), st.floats(0.1, 0.45), st.floats(0.05, 0.3), st.integers(0, 30))
def test_tori_are_never_taken_for_chaos_nor_settling_ones_for_tori(
    count: int, turns: float, size: float, more: int
) -> None:
    points = 400 + more
    torus = curves(points, count, turns, size / count)
    # Near a resonance a torus may be undecided, and on one (a whole number of turns) it is periodic.
    regime = classify(torus, np.zeros(points), 1.0)
    assert regime.name in ("quasi-periodic", "undecided", "periodic")
    if regime.name == "quasi-periodic":
        assert regime.pieces is not None
        assert regime.pieces % count == 0
    # By 0.1 % a period, towards the middle of each curve.
    middle = curves(points, count, turns, 0.0)
    settling = middle + (torus - middle) * np.exp(-0.001 * np.arange(points))[:, None]
    assert classify(settling, np.full(points, -0.001), 1.0).name in ("undecided", "periodic")


@pytest.mark.parametrize(("drive", "coupling"), [(0.2, 0.5), (0.3, 0.5), (0.45, 0.8)])
def test_the_circle_map_outside_its_tongues_is_quasi_periodic_with_its_winding_number(
    drive: float, coupling: float
) -> None:
    regime = classify(*circle_map(400, drive, coupling), 1.0)
    theta = 0.0
    for _ in range(100_000):
        theta += drive - coupling / (2 * pi) * sin(2 * pi * theta)
    turns = theta / 100_000 % 1.0  # within 1e-5 (Poincaré)
    assert (regime.name, regime.pieces) == ("quasi-periodic", 1)
    assert regime.winding == pytest.approx(min(turns, 1 - turns), abs=2e-5)


def test_the_critical_circle_map_has_the_golden_winding_of_the_literature() -> None:
    # Ω = 0.606661063470 at K = 1 (Shenker 1982, Physica D 5, 405).
    regime = classify(*circle_map(1500, 0.606661063470, 1.0), 6.0)
    assert regime.name == "quasi-periodic"
    assert regime.winding == pytest.approx(1 - GOLDEN, abs=1 / 1500)


@pytest.mark.parametrize(
    ("drive", "coupling", "period"), [(0.1, 0.9, 1), (0.5, 0.9, 2), (0.41, 0.95, 5), (0.143, 0.9, 1)]
)
def test_inside_a_tongue_the_circle_map_is_locked(drive: float, coupling: float, period: int) -> None:
    # The tongue of 0/1 reaches to Ω = K/(2π) = 0.14324 for K = 0.9; that of 1/2 is centred on Ω = 1/2.
    regime = classify(*circle_map(400, drive, coupling), 1.0)
    assert (regime.name, regime.period) == ("periodic", period)
    assert regime.lyapunov is not None
    assert regime.lyapunov < 0


def test_just_outside_a_tongue_the_slow_passages_leave_it_undecided() -> None:
    # Ω = 0.1433 is ε = 6e-5 beyond the edge at K/(2π); to pass its bottleneck ε + πK·x² takes √(π/(εK)) = 240 steps.
    assert classify(*circle_map(400, 0.1433, 0.9), 1.0).name == "undecided"


def test_a_torus_with_a_bottleneck_is_undecided_while_the_0_1_test_objects() -> None:
    # Further out the averages agree already in 400 points; K comes down with the length only.
    early = classify(*circle_map(400, 0.1455, 0.9), 6.0)
    assert early.name == "undecided"
    assert early.zero_one is not None
    assert early.zero_one > 0.8
    assert "as on a torus, 0-1 test" in early.reason
    assert classify(*circle_map(1200, 0.1455, 0.9), 6.0).name == "quasi-periodic"


@pytest.mark.parametrize("a", [2.02, 2.1, 2.16])
def test_the_delayed_logistic_map_is_quasi_periodic_beyond_its_hopf_bifurcation(a: float) -> None:
    # The fixed point loses stability at a = 2, turning by a sixth (Aronson, Chory, Hall & McGehee 1982).
    regime = classify(*delayed_logistic(400, a), 1.0)
    assert (regime.name, regime.pieces) == ("quasi-periodic", 1)
    assert regime.winding == pytest.approx(1 / 6, abs=0.1 * (a - 1.9))


@pytest.mark.parametrize(
    ("a", "name", "period"), [(1.9, "periodic", 1), (2.18, "periodic", 7), (2.27, "chaotic", None)]
)
def test_the_delayed_logistic_map_is_steady_before_locked_to_sevenths_and_chaotic_at_last(
    a: float, name: str, period: int | None
) -> None:
    regime = classify(*delayed_logistic(400, a), 1.0)
    assert (regime.name, regime.period) == (name, period)
    if name == "chaotic":
        assert regime.lyapunov == pytest.approx(0.18312, abs=0.06)  # Sprott 2003


@pytest.mark.parametrize("decay", [1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2])
@pytest.mark.parametrize("turns", [GOLDEN, 0.3373, 0.01, 0.5])
def test_a_spiral_that_still_shrinks_is_settling_however_slowly(decay: float, turns: float) -> None:
    section, growth = spiral(400, decay, turns)
    regime = classify(section, growth, 6.0)
    assert regime.name == "undecided"
    if turns in (GOLDEN, 0.5) and decay < 0.03:
        assert f"still settling, shrinks by {100 * decay:.2g} ±" in regime.reason


def test_a_motion_at_the_edge_of_stability_that_shrinks_as_a_power_of_time_is_settling() -> None:
    # The line through its logarithms is bent, so that its rate has an error; the size goes down by half all the same.
    section, _ = spiral(400, 0.0)
    section /= np.sqrt(1 + np.arange(400) / 100)[:, None]
    regime = classify(section, np.zeros(400), 6.0)
    assert regime.name == "undecided"
    assert "still settling" in regime.reason


@pytest.mark.parametrize("decay", [5e-4, 2e-3, 1e-2])
@pytest.mark.parametrize("period", [1, 2, 3])
def test_a_node_that_is_still_far_from_its_end_is_settling(decay: float, period: int) -> None:
    index = np.arange(300)
    section = np.column_stack([index % period + np.exp(-decay * index), 0.5 * np.exp(-decay * index)])
    regime = classify(section, np.full(300, -decay), 6.0)
    assert regime.name == "undecided"
    assert "still settling" in regime.reason


def test_a_spiral_that_settles_within_the_record_is_periodic_by_its_later_half() -> None:
    section, growth = spiral(400, 0.04)
    regime = classify(section, growth, 6.0)
    assert (regime.name, regime.period) == ("periodic", 1)
    assert regime.reason.startswith("the last 200 of 400 points: recurs after 1")


def test_a_torus_reached_within_the_record_is_told_by_its_later_half() -> None:
    approach, _ = spiral(800, 0.03, 0.2137)
    regime = classify(curves(800, 2) + 0.3 * approach, np.zeros(800), 6.0)
    assert (regime.name, regime.pieces) == ("quasi-periodic", 2)
    assert regime.reason.startswith("the last 400 of 800 points")


@pytest.mark.parametrize(
    ("noise", "names"), [(1e-4, {"quasi-periodic"}), (3e-3, {"quasi-periodic"}), (0.1, {"undecided"})]
)
@pytest.mark.parametrize("seed", range(5))
def test_noise_on_a_torus_is_borne_to_a_hundredth_of_its_size(noise: float, names: set[str], seed: int) -> None:
    section = curves(600, 1, size=1.0) + np.random.default_rng(seed).normal(0, noise, (600, 2))
    assert classify(section, np.zeros(600), 6.0).name in names


@pytest.mark.parametrize("noise", [3e-3, 0.02, 0.1])
@pytest.mark.parametrize("period", [1, 3])
@pytest.mark.parametrize("seed", range(5))
def test_noise_on_a_periodic_motion_makes_no_torus_of_it(noise: float, period: int, seed: int) -> None:
    # Above the tolerance of 0.001 nothing can be said, and the 0-1 test says why.
    section = curves(400, period, size=0.0) + np.random.default_rng(seed).normal(0, noise, (400, 2))
    regime = classify(section, np.full(400, -1e-4), 6.0)
    assert regime.name == "undecided"
    assert "weak chaos or noise" in regime.reason
    assert regime.zero_one == pytest.approx(1, abs=0.1)
    # Once the tolerance allows for it, ten deviations from end to end, it is periodic.
    assert classify(section, np.full(400, -1e-4), 6.0, tolerance=10 * noise).name == "periodic"


@pytest.mark.parametrize("points", [48, 60, 99])
def test_a_torus_is_not_told_from_a_record_too_short(points: int) -> None:
    regime = classify(curves(points, 1), np.zeros(points), 6.0)
    assert regime.name == "undecided"
    assert f"{points} section points, 100 needed to tell a torus" in regime.reason
    assert classify(curves(100, 1), np.zeros(100), 6.0).name == "quasi-periodic"


def test_arcs_that_have_not_come_round_are_undecided_with_their_number() -> None:
    # Three arcs that move by 0.0015 of a turn a round: a fifth of the circle in 400 points.
    angle = 2 * pi * (1 / 3 + 0.0005) * np.arange(400)
    regime = classify(np.column_stack([np.cos(angle), np.sin(angle)]), np.zeros(400), 6.0)
    assert regime.name == "undecided"
    assert "3 arcs that have not come round" in regime.reason


def test_turns_too_few_for_averages_are_undecided() -> None:
    # 400 points of 0.0062 of a turn: two turns and a half.
    angle = 2 * pi * 0.0062 * np.arange(400)
    regime = classify(np.column_stack([np.cos(angle), 0.5 * np.sin(angle)]), np.zeros(400), 6.0)
    assert regime.name == "undecided"


def test_growth_that_comes_and_goes_with_the_phase_does_not_hide_a_torus() -> None:
    # Its block means scatter by more than the exponents that are told from zero, its weighted average does not.
    regime = classify(*delayed_logistic(400, 2.16), 1.0)
    assert regime.lyapunov_error is not None
    assert 3 * regime.lyapunov_error > 0.005
    assert regime.name == "quasi-periodic"


def test_golden_value() -> None:
    regime = classify(*delayed_logistic(400, 2.1), 1.0)
    assert (regime.name, regime.pieces) == ("quasi-periodic", 1)
    assert regime.winding == pytest.approx(0.15610601877508432, abs=1e-9)
    assert regime.zero_one == pytest.approx(0.05647555012047721, abs=1e-9)
    assert regime.lyapunov == pytest.approx(-0.0023594779684245333, abs=1e-9)
