"""Classifying systems whose regime is known from the literature."""

from math import cos, log, pi
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.regimes import Regime, classification, classify
from seat_gear_dynamics.regimes.classification import SHORTEST_RECORD, warm_up
from seat_gear_dynamics.regimes.pieces import pieces
from seat_gear_dynamics.regimes.zero_one import zero_one

Array = NDArray[np.float64]


def henon(points: int, a: float = 1.4, b: float = 0.3) -> tuple[Array, Array]:
    """Iterate the Hénon map and its tangent; return section and growth."""
    x, y, tangent = 0.1, 0.1, np.array([1.0, 0.0])
    section, growth = [], []
    for n in range(points + 200):
        tangent = np.array([[-2 * a * x, 1.0], [b, 0.0]]) @ tangent
        norm = float(np.linalg.norm(tangent))
        tangent /= norm
        x, y = 1 - a * x * x + y, b * x
        if n >= 200:
            section.append((x, y))
            growth.append(log(norm))
    return np.array(section), np.array(growth)


def logistic(points: int, r: float) -> tuple[Array, Array]:
    """Iterate x → r·x(1 − x); return section (x and the next x) and growth."""
    x, section, growth = 0.3123, [], []
    for n in range(points + 500):
        slope = abs(r * (1 - 2 * x))
        following = r * x * (1 - x)
        if n >= 500:
            section.append((x, following))
            growth.append(log(max(slope, 1e-12)))
        x = following
    return np.array(section), np.array(growth)


def rotation(points: int, turns: float = (5**0.5 - 1) / 2, radius: float = 1.0) -> tuple[Array, Array]:
    angle = 2 * pi * turns * np.arange(points)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]), np.zeros(points)


def spiral(points: int, decay: float) -> tuple[Array, Array]:
    """A fixed point approached by a decaying rotation; both section and tangent shrink by exp(−decay) a period."""
    section, _ = rotation(points)
    return section * np.exp(-decay * np.arange(points))[:, None], np.full(points, -decay)


def test_henon_map_is_chaotic_with_the_published_exponent() -> None:
    # 0.41922 per iteration (Sprott 2003, Chaos and Time-Series Analysis).
    regime = classify(*henon(4000), 1.0)
    assert (regime.name, regime.period) == ("chaotic", None)
    assert regime.lyapunov == pytest.approx(0.41922, abs=0.02)


@pytest.mark.parametrize("interval", [0.5, 12.0])
def test_exponent_is_per_unit_of_time_and_not_per_period(interval: float) -> None:
    regime = classify(*henon(4000), interval)
    assert regime.lyapunov == pytest.approx(0.41922 / interval, rel=0.05)


def test_logistic_map_at_four_is_chaotic_with_ln_2() -> None:
    regime = classify(*logistic(2000, 4.0), 1.0)
    assert regime.name == "chaotic"
    assert regime.lyapunov == pytest.approx(log(2), abs=0.03)


@pytest.mark.parametrize(("r", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.55, 8), (3.83, 3), (3.63, 6), (3.74, 5)])
def test_windows_of_the_logistic_map_have_their_published_periods_and_negative_exponents(r: float, period: int) -> None:
    regime = classify(*logistic(400, r), 1.0)
    assert (regime.name, regime.period) == ("periodic", period)
    assert regime.lyapunov is not None
    assert regime.lyapunov < 0


def test_rotation_by_an_irrational_angle_is_quasi_periodic() -> None:
    regime = classify(*rotation(400), 1.0)
    assert (regime.name, regime.period) == ("quasi-periodic", None)
    assert regime.lyapunov == 0


@given(st.integers(1, 16))
def test_rotation_by_a_fraction_of_a_turn_is_periodic(parts: int) -> None:
    regime = classify(*rotation(100, 1 / parts), 1.0)
    assert (regime.name, regime.period) == ("periodic", parts)


def test_a_fixed_point_is_periodic_with_period_one() -> None:
    regime = classify(np.ones((60, 2)), np.full(60, -0.1), 1.0)
    assert (regime.name, regime.period) == ("periodic", 1)
    assert regime.lyapunov == pytest.approx(-0.1)


def test_a_spiral_is_undecided_while_it_settles_and_periodic_after() -> None:
    section, growth = spiral(800, 0.02)
    early = classify(section[:100], growth[:100], 20.0)
    assert early.name == "undecided"
    assert "still settling" in early.reason
    late = classify(section[400:], growth[400:], 20.0)
    assert (late.name, late.period) == ("periodic", 1)


@settings(max_examples=30)
@given(st.floats(0.005, 0.5), st.floats(1.0, 20.0))
def test_a_settling_spiral_is_never_taken_for_irregular_motion(decay: float, interval: float) -> None:
    assert classify(*spiral(200, decay), interval).name in ("undecided", "periodic")


@pytest.mark.parametrize("points", [0, 1, 15, 47])
def test_a_record_too_short_is_undecided_and_says_how_short(points: int) -> None:
    regime = classify(np.zeros((points, 2)), np.zeros(points), 1.0)
    assert regime == Regime("undecided", None, None, None, f"{points} section points, 48 needed")


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
@pytest.mark.parametrize("where", ["section", "growth", "everything"])
def test_numbers_that_are_not_finite_are_undecided_and_never_an_exponent(value: float, where: str) -> None:
    section, growth = henon(400)
    if where != "growth":
        section[200 if where == "section" else slice(None)] = value
    if where != "section":
        growth[200 if where == "growth" else slice(None)] = value
    regime = classify(section, growth, 1.0)
    assert (regime.name, regime.period, regime.lyapunov, regime.lyapunov_error) == ("undecided", None, None, None)
    assert "not finite" in regime.reason


def test_random_points_with_an_unsure_exponent_are_undecided() -> None:
    rng = np.random.default_rng(1)
    regime = classify(rng.normal(size=(64, 2)), rng.normal(0.05, 1.0, 64), 1.0)
    assert regime.name == "undecided"
    assert regime.lyapunov is not None
    assert "more time needed" in regime.reason


def test_evidence_of_chaos_is_said_to_build_before_it_is_sure() -> None:
    # An exponent of two standard errors: not sure, but leaning. The same, negative or sure, does not lean.
    growth = np.repeat([0.1, 0.9, -0.3, 0.8, -0.2, 0.7, 0.5, -0.1], 8)
    section = np.random.default_rng(2).normal(size=(64, 2))
    assert classify(section, growth, 1.0).leans_chaotic
    assert not classify(section, -growth, 1.0).leans_chaotic
    assert not classify(section, np.full(64, 0.4), 1.0).leans_chaotic
    assert classify(section, np.full(64, 0.4), 1.0).name == "chaotic"


def test_the_tolerance_decides_how_exact_a_recurrence_must_be() -> None:
    section = np.random.default_rng(3).normal(0, 0.005, (100, 2))
    growth = np.full(100, -0.1)
    assert classify(section, growth, 1.0, tolerance=0.1).name == "periodic"
    assert classify(section, growth, 1.0).name == "undecided"


def duffing(forcing: float, points: int) -> tuple[Array, Array]:
    """March x″ + 0.3x′ − x + x³ = forcing·cos(1.2t) with its tangent by Runge-Kutta, 100 steps a period."""

    def rates(t: float, s: Array) -> Array:
        x, v, a, b = s
        return np.array([v, forcing * cos(1.2 * t) - 0.3 * v + x - x**3, b, (1 - 3 * x * x) * a - 0.3 * b])

    state, h, section, growth = np.array([1.0, 0.0, 1.0, 0.0]), 2 * pi / 1.2 / 100, [], []
    for period in range(points + 60):
        for step in range(100):
            t = (100 * period + step) * h
            k1 = rates(t, state)
            k2 = rates(t + h / 2, state + h / 2 * k1)
            k3 = rates(t + h / 2, state + h / 2 * k2)
            k4 = rates(t + h, state + h * k3)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        norm = float(np.hypot(state[2], state[3]))
        state[2:] /= norm
        if period >= 60:
            section.append(state[:2].copy())
            growth.append(log(norm))
    return np.array(section), np.array(growth)


@pytest.mark.parametrize(
    ("forcing", "name", "period"), [(0.20, "periodic", 1), (0.28, "periodic", 2), (0.50, "chaotic", None)]
)
def test_duffings_oscillator_takes_the_published_road_to_chaos(forcing: float, name: str, period: int | None) -> None:
    # α = −1, β = 1, δ = 0.3, ω = 1.2: Jordan & Smith 2007, Nonlinear Ordinary Differential Equations.
    section, growth = duffing(forcing, 120)
    regime = classify(section, growth, 2 * pi / 1.2)
    assert (regime.name, regime.period) == (name, period)
    # Volume shrinks by exp(−0.3·period), so no exponent of a periodic motion is below −0.3.
    assert regime.lyapunov is not None
    assert -0.3 < regime.lyapunov < 1


@pytest.mark.parametrize(
    ("r", "bands", "label"), [(3.575, 4, "4-band chaos"), (3.6, 2, "2-band chaos"), (3.8, 1, "chaos")]
)
def test_chaos_is_given_with_its_bands(r: float, bands: int, label: str) -> None:
    # Bands merge at 3.5926 and 3.6786 (Grossmann & Thomae 1977).
    regime = classify(*logistic(800, r), 1.0)
    assert (regime.name, regime.pieces, regime.label) == ("chaotic", bands, label)
    assert ("bands" in regime.reason) == (bands > 1)


def test_labels_are_the_literatures_short_forms() -> None:
    assert classify(*logistic(400, 3.2), 1.0).label == "period-2"
    assert classify(*rotation(400), 1.0).label == "quasi-period-1"
    assert classify(*rotation(10), 1.0).label == "undecided"


@pytest.mark.parametrize("interval", [1.0, 10.0])
@pytest.mark.parametrize("points", [400, 1200])
def test_the_accumulation_point_of_doublings_is_nothing_that_has_a_name(points: int, interval: float) -> None:
    # r∞ = 3.5699456718 (Feigenbaum 1978): no period, exponent zero, a Cantor set of points and no curve.
    regime = classify(*logistic(points, 3.5699456718), interval)
    assert regime.name == "undecided"
    assert regime.lyapunov == pytest.approx(0, abs=0.02)


@pytest.mark.parametrize("r", [3.5699456718, 3.571, 3.575, 3.6, 3.7, 3.9])
def test_chaos_too_slow_to_be_told_from_zero_is_undecided_and_never_quasi_periodic(r: float) -> None:
    # Over 200 units of time a period the exponent of any of these is below 0.0025.
    regime = classify(*logistic(600, r), 200.0)
    assert regime.name == "undecided"
    assert regime.lyapunov is not None
    assert regime.lyapunov < 0.005


def test_a_half_that_looks_quasi_periodic_by_chance_does_not_outweigh_the_0_1_test_of_the_whole() -> None:
    # About one stretch of 240 points of this chaos in two hundred has averages that agree as a torus's do.
    section, growth = (values[3461:3941] for values in logistic(4000, 3.6))
    assert classify(section[240:], growth[240:], 200.0).name == "quasi-periodic"
    whole = classify(section, growth, 200.0)
    assert whole.name == "undecided"
    assert whole.zero_one == pytest.approx(1, abs=0.1)


def test_a_period_of_a_long_lock_is_found_beyond_the_longest_looked_for_by_itself() -> None:
    # Sixth doubling of the logistic map: 32 points between 3.5688 and 3.5697.
    regime = classify(*logistic(400, 3.5692), 1.0)
    assert (regime.name, regime.period) == ("periodic", 32)


def test_a_motion_that_recurs_while_its_tangent_grows_is_undecided() -> None:
    # The fixed point 1 − 1/r of the logistic map, held by rounding alone for some fifty steps.
    regime = classify(np.full((60, 2), 0.75), np.full(60, log(2)), 1.0)
    assert regime.name == "undecided"
    assert regime.leans_chaotic
    assert "recurs after 1 within 0.001 b_c, but exponent 0.6931" in regime.reason


def test_chaos_that_ends_within_the_record_is_undecided_and_then_periodic() -> None:
    chaos, after = logistic(300, 3.9), logistic(400, 3.2)
    section, growth = (np.concatenate(both) for both in zip(chaos, after, strict=True))
    growth[300:] = -0.1
    assert classify(section[:320], growth[:320], 1.0).name == "chaotic"
    # A quarter of the record is over: the exponent of the whole is still surely positive.
    still = classify(section[:400], growth[:400], 1.0)
    assert still.name == "undecided"
    assert still.leans_chaotic
    assert "the last 100 points recur after 2: a transient, or intermittency" in still.reason
    assert still.pieces is None
    ended = classify(section[200:], growth[200:], 1.0)
    assert (ended.name, ended.period) == ("periodic", 2)
    assert ended.reason.startswith("the last 250 of 500 points: recurs after 2")
    assert ended.lyapunov == pytest.approx(-0.1)


def test_an_exponent_barely_sure_is_not_believed_against_averages_that_agree() -> None:
    # A rotation whose tangent is said to grow: three to six standard errors do not outweigh its closed curve.
    section, _ = rotation(400)
    growth = np.repeat([0.1, 0.7, 0.2, 0.6, 0.1, 0.7, 0.2, 0.6], 50)
    regime = classify(section, growth, 1.0)
    assert regime.name == "undecided"
    assert "averages agree to" in regime.reason
    assert classify(*(np.random.default_rng(0).normal(size=(400, 2)), growth), 1.0).name == "chaotic"
    assert classify(section, np.full(400, 0.4), 1.0).name == "chaotic"


def test_the_same_record_gives_the_same_regime() -> None:
    section, growth = rotation(300, 0.137 + 1e-5)
    kept = section.copy()
    assert classify(section, growth, 1.0) == classify(section, growth, 1.0)
    assert (section == kept).all()


def test_warming_up_goes_through_all_that_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    tree, walk = Mock(wraps=pieces), Mock(wraps=zero_one)
    monkeypatch.setattr(classification, "pieces", tree)
    monkeypatch.setattr(classification, "zero_one", walk)
    warm_up()
    assert tree.called
    assert walk.called


@settings(max_examples=60)
@given(st.integers(0, 10_000), st.integers(SHORTEST_RECORD, 220), st.floats(1e-3, 10), st.floats(0.1, 50))
def test_any_finite_record_gets_a_name_and_a_reason(seed: int, points: int, size: float, interval: float) -> None:
    rng = np.random.default_rng(seed)
    kind = rng.integers(4)
    section = rng.normal(size=(points, 2))
    if kind == 1:
        section = np.cumsum(section, axis=0)
    elif kind == 2:
        section[:, 1] = 0
    elif kind == 3:
        section = np.round(section)
    regime = classify(size * section, rng.normal(0, 0.5, points), interval)
    assert regime.name in ("periodic", "quasi-periodic", "chaotic", "undecided")
    assert regime.reason
    assert regime.lyapunov is not None
    assert (regime.period is not None) == (regime.name == "periodic")
    assert (regime.pieces is not None) == (regime.name in ("quasi-periodic", "chaotic"))
    assert (regime.winding is not None) == (regime.name == "quasi-periodic")
