"""The simulated bench against the analytic motor, the bounds of the counter, the statistics of noise."""

from __future__ import annotations

import math
from itertools import islice
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.bench.drive import SPEED_NOISE, BenchSample, SimulatedBench
from seat_gear_dynamics.bench.errors import BenchError
from seat_gear_dynamics.bench.profiles import RPM, Profile, profile


def constant(rpm: float, load: float = 600.0) -> Profile:
    return Profile("constant", "", ((0.0, rpm),), ((0.0, load),))


def run(bench: SimulatedBench, count: int) -> list[BenchSample]:
    return list(islice(iter(bench.step, None), count))


def quiet(run_of: Profile, **arguments: Any) -> SimulatedBench:
    return SimulatedBench(run_of, speed_noise=0.0, load_noise=0.0, **arguments)


@pytest.mark.parametrize("sample_time", [0.001, 0.01, 0.05])
@pytest.mark.parametrize("lag", [0.02, 0.08, 0.5])
def test_a_step_is_answered_by_the_exact_exponential(sample_time: float, lag: float) -> None:
    # The command leaps within a thousandth of the first sample, before its middle, where it is read.
    leap = Profile("leap", "", ((0.0, 0.0), (1e-3 * sample_time, 1000.0)), ((0.0, 600.0),))
    samples = run(quiet(leap, sample_time=sample_time, motor_time_constant=lag), 60)
    expected = [1000.0 * RPM * (1.0 - math.exp(-s.t / lag)) for s in samples]
    assert [s.true_speed for s in samples] == pytest.approx(expected, rel=1e-12)


def test_a_ramp_is_followed_at_the_analytic_distance() -> None:
    # ω(t) = a (t - τ (1 - e^(-t/τ))) for the command a t; the held command leaves an error of order a T²/τ.
    lag, sample_time, slope = 0.08, 0.01, 200.0 * RPM
    ramp = Profile("ramp", "", ((0.0, 0.0), (10.0, 2000.0)), ((0.0, 600.0),))
    for s in run(quiet(ramp, sample_time=sample_time, motor_time_constant=lag), 500):
        expected = slope * (s.t - lag * (1.0 - math.exp(-s.t / lag)))
        assert s.true_speed == pytest.approx(expected, abs=slope * sample_time**2 / lag)


def test_a_motor_without_lag_has_the_commanded_speed() -> None:
    bench = quiet(profile("run-up"), motor_time_constant=0.0)
    assert run(bench, 100)[-1].true_speed == pytest.approx(profile("run-up").speed(0.995))


@given(
    st.floats(-2500.0, 2500.0),
    st.integers(1, 5000),
    st.floats(0.001, 0.1),
)
@settings(max_examples=60)
def test_quantisation_stays_within_one_step_and_comes_in_whole_steps(
    rpm: float, pulses: int, sample_time: float
) -> None:
    bench = quiet(constant(rpm), hall_pulses_per_revolution=pulses, sample_time=sample_time)
    assert bench.speed_step == pytest.approx(60.0 / (pulses * sample_time) * RPM)
    for s in run(bench, 50):
        assert abs(s.speed - s.true_speed) <= bench.speed_step * (1.0 + 1e-9)
        assert s.speed / bench.speed_step == pytest.approx(round(s.speed / bench.speed_step), abs=1e-6)
        assert s.speed * rpm >= 0.0


def test_the_default_sensor_is_within_two_rpm_and_shows_its_steps() -> None:
    samples = run(quiet(constant(1353.3)), 400)
    errors = [(s.speed - s.true_speed) / RPM for s in samples]
    assert max(abs(error) for error in errors) < 2.0
    assert sorted({round(s.speed / RPM, 6) for s in samples}) == [1352.0, 1354.0]


@given(st.floats(-2500.0, 2500.0))
@settings(max_examples=30)
def test_counting_loses_nothing_in_the_long_run(rpm: float) -> None:
    bench = quiet(constant(rpm))
    samples = run(bench, 500)
    mean = sum(s.speed for s in samples) / len(samples)
    assert mean == pytest.approx(rpm * RPM, abs=bench.speed_step / len(samples) * 1.001)


def test_noise_has_the_stated_mean_and_spread() -> None:
    count = 20_000
    samples = run(SimulatedBench(constant(1046.0), hall_pulses_per_revolution=10**9, load_noise=5.0), count)
    for errors, sigma in (
        (np.array([s.speed - s.true_speed for s in samples]), SPEED_NOISE),
        (np.array([s.load - s.true_load for s in samples]), 5.0),
    ):
        assert abs(errors.mean()) < 5.0 * sigma / math.sqrt(count)
        assert errors.std() == pytest.approx(sigma, rel=5.0 / math.sqrt(2.0 * count))


def test_a_shaft_at_rest_reads_zero_in_spite_of_the_noise() -> None:
    samples = run(SimulatedBench(constant(0.0), speed_noise=1.0), 200)
    assert {s.speed for s in samples} == {0.0}
    assert len({s.load for s in samples}) == 200


def test_the_shaft_comes_to_rest_after_a_run_down() -> None:
    samples = run(SimulatedBench(profile("run-down")), 4300)
    assert {s.speed for s in samples[-100:]} == {0.0}


def test_reversing_keeps_the_sign() -> None:
    bench = quiet(profile("up-down"))
    samples = run(bench, round(profile("up-down").duration / 0.01))
    assert min(s.speed for s in samples) / RPM == pytest.approx(-1200.0, abs=2.0)
    assert max(s.speed for s in samples) / RPM == pytest.approx(2200.0, abs=2.0)
    assert all(s.speed * s.true_speed >= 0.0 for s in samples if abs(s.true_speed) > 2.0 * bench.speed_step)


def test_one_seed_one_sequence() -> None:
    first, again, other = (run(SimulatedBench(profile("up-down"), seed=s), 300) for s in (7, 7, 8))
    assert first == again
    assert [s.load for s in first] != [s.load for s in other]
    assert [s.true_speed for s in first] == [s.true_speed for s in other]


def test_time_is_counted_without_drift() -> None:
    samples = run(SimulatedBench(constant(100.0), sample_time=0.01), 10_000)
    assert samples[0].t == 0.01
    assert samples[-1].t == 100.0


@pytest.mark.parametrize(
    ("argument", "value", "sentence"),
    [
        ("sample_time", 0.0, "sample_time is 0.0; expected above 0 s"),
        ("sample_time", math.nan, "sample_time is nan"),
        ("motor_time_constant", -0.1, "motor_time_constant is -0.1; expected 0 s or more"),
        ("hall_pulses_per_revolution", 0, "a whole number from 1 up"),
        ("hall_pulses_per_revolution", 2.5, "a whole number from 1 up"),
        ("hall_pulses_per_revolution", math.inf, "a whole number from 1 up"),
        ("speed_noise", -1.0, "0 rad/s or more"),
        ("load_noise", math.inf, "0 N·m or more"),
        ("seed", -1, "a whole number, 0 or more"),
    ],
)
def test_wrong_arguments_are_refused(argument: str, value: float, sentence: str) -> None:
    arguments: dict[str, Any] = {argument: value}
    with pytest.raises(BenchError, match=sentence):
        SimulatedBench(constant(100.0), **arguments)
