"""The profiles against their promises: bands, continuity, refusals."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.bench.errors import BenchError
from seat_gear_dynamics.bench.profiles import DEFAULT, PROFILES, RPM, Profile, path, profile

BANDS = ((1349.0, 1359.0), (1589.0, 2060.0))  # r/min, the forbidden bands at 600 N·m
names = st.sampled_from(sorted(PROFILES))


def rpm(name: str, t: float) -> float:
    return PROFILES[name].speed(t) / RPM


def seconds_in(name: str, band: tuple[float, float]) -> float:
    step = 0.005
    times = [i * step for i in range(int(PROFILES[name].duration / step))]
    return step * sum(band[0] <= abs(rpm(name, t)) <= band[1] for t in times)


@pytest.mark.parametrize("band", BANDS)
@pytest.mark.parametrize("name", ["up-down", "run-up", "run-down", "dwell-in-band"])
def test_every_run_through_the_speeds_meets_both_forbidden_bands(name: str, band: tuple[float, float]) -> None:
    assert seconds_in(name, band) > 0.04


def test_the_dwelling_profile_stays_in_each_band_and_approaches_from_below() -> None:
    assert [seconds_in("dwell-in-band", band) >= 8.0 for band in BANDS] == [True, True]
    assert [rpm("dwell-in-band", t) for t in (8.0, 15.0, 26.0)] == pytest.approx([1300.0, 1354.0, 1800.0])


def test_the_load_steps_stay_outside_the_bands_at_constant_speed() -> None:
    stepping = profile("load-step")
    assert [stepping.load(t) for t in (5.0, 15.0, 25.0, 35.0)] == pytest.approx([600.0, 300.0, 500.0, 600.0])
    assert {round(stepping.speed(t) / RPM, 6) for t in (0.0, 9.99, 10.03, 39.0)} == {1046.0}


def test_the_default_goes_up_down_stops_and_reverses() -> None:
    default = profile(DEFAULT)
    speeds = [default.speed(0.01 * i) / RPM for i in range(round(default.duration / 0.01))]
    top, bottom = speeds.index(max(speeds)), speeds.index(min(speeds))
    assert max(speeds) == pytest.approx(2200.0)
    assert min(speeds) == pytest.approx(-1200.0)
    assert top < bottom
    assert 0.0 in speeds[top:bottom]
    assert max(abs(b - a) for a, b in pairwise(speeds)) <= 200.0 * 0.01 + 1e-9
    loads = [default.load(0.01 * i) for i in range(len(speeds))]
    assert 500.0 < min(loads) < max(loads) < 700.0


@given(names, st.floats(0.0, 400.0), st.floats(1e-6, 1e-3))
def test_no_profile_jumps_not_even_from_round_to_round(name: str, t: float, step: float) -> None:
    run = PROFILES[name]
    steepest_speed, steepest_load = 200.0 * RPM, 300.0 / 0.05
    assert abs(run.speed(t + step) - run.speed(t)) <= steepest_speed * step * 1.01 + 1e-9
    assert abs(run.load(t + step) - run.load(t)) <= steepest_load * step * 1.01 + 1e-9


@given(st.sampled_from([p for p in PROFILES.values() if p.repeats]), st.floats(0.0, 40.0), st.integers(1, 5))
def test_a_repeating_profile_repeats(run: Profile, t: float, rounds: int) -> None:
    assert run.speed(t + rounds * run.duration) == pytest.approx(run.speed(t), abs=1e-6)
    assert run.load(t + rounds * run.duration) == pytest.approx(run.load(t), abs=1e-6)


def test_a_single_run_holds_its_last_values() -> None:
    assert profile("run-down").speed(1e6) == 0.0
    assert profile("run-up").speed(1e6) == pytest.approx(2150.0 * RPM)
    assert profile("run-up").speed(-1.0) == 0.0


def test_values_between_points_are_interpolated() -> None:
    run = Profile("x", "", ((0.0, 0.0), (2.0, 100.0), (4.0, -100.0)), ((0.0, 1.0),))
    assert [run.speed(t) / RPM for t in (0.5, 2.0, 3.0, 3.5, 9.0)] == pytest.approx([25, 100, 0, -50, -100])
    assert run.load(3.0) == 1.0
    assert run.duration == 4.0


def test_an_unknown_name_lists_the_names() -> None:
    with pytest.raises(BenchError, match=r"no profile 'up'.*up-down.*load-step"):
        profile("up")


@pytest.mark.parametrize(
    ("speeds", "repeats", "sentence"),
    [
        ((), False, "begin at 0 s"),
        (((1.0, 5.0),), False, "begin at 0 s"),
        (((0.0, 5.0), (0.0, 6.0)), False, "later than the one before"),
        (((0.0, math.nan),), False, "not finite"),
        (((0.0, 5.0), (1.0, 6.0)), True, "make both the same"),
    ],
)
def test_wrong_points_are_refused(speeds: tuple[tuple[float, float], ...], repeats: bool, sentence: str) -> None:
    with pytest.raises(BenchError, match=sentence):
        Profile("x", "", speeds, ((0.0, 600.0),), repeats)


def test_a_leg_of_no_duration_is_refused() -> None:
    with pytest.raises(BenchError, match="later than the one before"):
        Profile("x", "", path(0.0, (100.0, 0.0)), ((0.0, 600.0),))


@pytest.mark.parametrize("t", [math.nan, math.inf, -math.inf])
def test_a_time_that_is_no_time_is_refused(t: float) -> None:
    with pytest.raises(BenchError, match="finite number"):
        profile(DEFAULT).speed(t)
