"""Watching the regime of a running drive from section points made here."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.sensing import RegimeWatch

Array = NDArray[np.float64]


def points(n: int, period: int = 1, growth: float = -0.5, start: int = 0, irregular: float = 0.0) -> Array:
    """Return n section points (τ, δ, rate, growth of P12, growth of P34) of a motion of that period."""
    index = np.arange(start, start + n)
    wander = irregular * np.random.default_rng(0).normal(size=n)
    return np.column_stack([10.0 * index, 0.5 * (index % period) + wander, wander, np.full(n, growth), np.zeros(n)])


def test_a_steady_periodic_drive_is_recognised_with_its_period_and_exponent() -> None:
    regime = RegimeWatch().add(points(160, period=3), 0.9, 100.0)
    assert (regime.name, regime.period) == ("periodic", 3)
    assert regime.lyapunov == pytest.approx(-0.05)


def test_a_steady_irregular_drive_with_growing_tangent_is_chaotic() -> None:
    regime = RegimeWatch().add(points(160, growth=0.4, irregular=1.0), 0.9, 100.0)
    assert regime.name == "chaotic"
    assert regime.lyapunov == pytest.approx(0.04)


def test_it_is_undecided_until_there_are_enough_points() -> None:
    watch = RegimeWatch()
    decided = [watch.add(points(4, start=n), 0.9, 100.0).name != "undecided" for n in range(0, 160, 4)]
    first = decided.index(True)
    assert 4 * (first + 1) >= 32 + 48
    assert all(decided[first:])


def test_points_of_the_transient_are_left_out() -> None:
    watch = RegimeWatch()
    watch.add(points(30, irregular=5.0), 0.9, 100.0)
    assert watch.add(points(100, start=30), 0.9, 100.0).name == "periodic"


@pytest.mark.parametrize(
    ("frequency", "load"), [(0.92, 100.0), (0.88, 100.0), (0.9, 106.0), (0.9, 94.0), (-0.9, 100.0)]
)
def test_a_change_of_drive_makes_it_undecided_and_starts_a_new_record(frequency: float, load: float) -> None:
    watch = RegimeWatch()
    assert watch.add(points(160), 0.9, 100.0).name == "periodic"
    regime = watch.add(points(4, start=160), frequency, load)
    assert (regime.name, regime.reason) == ("undecided", "the drive is not steady")
    assert watch.add(points(120, start=164, period=2), frequency, load).period == 2


@pytest.mark.parametrize(("frequency", "load"), [(0.908, 100.0), (0.892, 100.0), (0.9, 104.9), (0.9, 95.1)])
def test_small_changes_of_drive_keep_the_record(frequency: float, load: float) -> None:
    watch = RegimeWatch()
    watch.add(points(160), 0.9, 100.0)
    assert watch.add(points(4, start=160), frequency, load).name == "periodic"


def test_a_slow_drift_is_measured_from_where_the_record_began() -> None:
    # 0.2 % a call is steady from call to call, but 1 % away from the record's beginning before there are points enough.
    drifting, steady = RegimeWatch(), RegimeWatch()
    for n in range(40):
        assert drifting.add(points(8, start=8 * n), 0.9 * (1 + 0.002 * n), 100.0).name == "undecided"
        steady.add(points(8, start=8 * n), 0.9, 100.0)
    assert steady.regime.name == "periodic"


def test_a_reset_forgets_and_says_why() -> None:
    watch = RegimeWatch()
    watch.add(points(160), 0.9, 100.0)
    watch.reset("the model restarted (gap)")
    assert (watch.regime.name, watch.regime.reason) == ("undecided", "the model restarted (gap)")
    assert watch.add(points(40), 0.9, 100.0).name == "undecided"


def test_old_points_are_forgotten() -> None:
    # 192 points are judged: what was irregular before them no longer counts.
    watch = RegimeWatch()
    assert watch.add(points(160, growth=0.4, irregular=1.0), 0.9, 100.0).name == "chaotic"
    assert watch.add(points(192, start=160), 0.9, 100.0).name == "periodic"


def test_calls_without_points_change_nothing() -> None:
    watch = RegimeWatch()
    before = watch.add(points(160), 0.9, 100.0)
    for _ in range(50):
        assert watch.add(np.empty((0, 5)), 0.9, 100.0) is before


def test_measured_noise_does_not_hide_a_period() -> None:
    # Within 0.05 b_c a motion under a noisy speed still recurs.
    assert RegimeWatch().add(points(160, period=2, irregular=0.008), 0.9, 100.0).period == 2
