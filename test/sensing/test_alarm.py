"""The alarm over drives: levels in order, ahead of time, steady under noise."""

from collections.abc import Callable
from itertools import groupby

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes import Regime
from seat_gear_dynamics.sensing import Alarm, AlarmSettings, Level, Verdict

Run = Callable[..., list[Verdict]]
Bands = tuple[ForbiddenBand, ...]
OK, WARN, ERROR, STALE = Level.OK, Level.WARN, Level.ERROR, Level.STALE


def levels(verdicts: list[Verdict]) -> list[Level]:
    """Return the levels in order, each once for as long as it lasts."""
    return [level for level, _ in groupby(v.level for v in verdicts)]


def test_a_ramp_through_both_bands_warns_trips_and_recovers_at_each(alarm: Alarm, run: Run) -> None:
    up = run(alarm, np.arange(1200, 2300, 0.5))  # 50 r/min a second
    assert levels(up) == [OK, WARN, ERROR, WARN, OK, WARN, ERROR, WARN, STALE]
    assert [inside for inside, _ in groupby(v.in_band for v in up)] == [False, True, False, True, False]


def test_a_ramp_down_gives_the_same_sequence_backward(alarm: Alarm, run: Run) -> None:
    down = run(alarm, np.arange(2080, 1200, -0.5))
    assert levels(down) == [WARN, ERROR, WARN, OK, WARN, ERROR, WARN, OK]


def test_trip_comes_within_the_debounce_of_the_edge_and_goes_with_hysteresis_and_hold(alarm: Alarm, run: Run) -> None:
    speeds = np.arange(1300, 1420, 0.5)
    verdicts = run(alarm, speeds)
    inside = [n for n, v in enumerate(verdicts) if v.in_band]
    entered, left = int(np.argmax(speeds >= 1349)), int(np.argmax(speeds > 1359 + 4))
    settings = alarm.settings
    assert inside[0] - entered == pytest.approx(settings.debounce * 100, abs=1)
    assert inside[-1] + 1 - left == pytest.approx(settings.hold * 100, abs=1)
    assert len(inside) == inside[-1] - inside[0] + 1


@settings(max_examples=40)
@given(st.floats(20, 500), st.booleans())
def test_time_to_band_on_a_constant_ramp_is_distance_over_slope(bands: Bands, run: Run, slope: float, up: bool) -> None:
    direction, begin, edge = (1, 1100.0, 1349.0) if up else (-1, 1580.0, 1359.0)
    speeds = begin + direction * slope * np.arange(30) / 100
    verdict = run(Alarm(bands, covered_speed=300.0), speeds)[-1]
    assert verdict.time_to_band == pytest.approx(abs(edge - speeds[-1]) / slope, rel=1e-6)


def test_a_band_within_the_horizon_warns_though_it_is_far_in_speed(alarm: Alarm, run: Run) -> None:
    verdicts = run(alarm, np.arange(900, 1300, 3.0))  # 300 r/min a second: 1 s ahead is 300 r/min ahead
    first = next(n for n, v in enumerate(verdicts) if v.level == WARN)
    assert 900 + 3 * first == pytest.approx(1349 - 300, abs=3 * (alarm.settings.debounce * 100 + 2))
    assert "ahead at the present acceleration" in verdicts[first].reason


def test_no_band_is_ahead_while_the_speed_moves_away(alarm: Alarm, run: Run) -> None:
    assert run(alarm, np.arange(1200, 800, -2.0))[-1].time_to_band is None
    assert run(alarm, [1200.0] * 40)[-1].time_to_band is None


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("edge", [1349, 1359, 1589, 2060])
def test_noise_on_an_edge_is_one_change_of_the_trip_signal(alarm: Alarm, run: Run, edge: int, seed: int) -> None:
    noise = np.random.default_rng(seed).uniform(-3, 3, 1000)
    verdicts = run(alarm, edge + noise)
    assert len([k for k, _ in groupby(v.in_band for v in verdicts)]) <= 2
    assert verdicts[-1].in_band
    assert levels(verdicts) in ([WARN, ERROR], [ERROR])


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_a_spike_shorter_than_the_debounce_is_not_shown(alarm: Alarm, run: Run, samples: int) -> None:
    verdicts = run(alarm, [1300.0] * 50 + [1354.0] * samples + [1300.0] * 50)
    assert not any(v.in_band for v in verdicts)
    assert ERROR not in levels(verdicts)


def test_what_is_held_back_is_said(alarm: Alarm, run: Run) -> None:
    verdict = run(alarm, [1200.0] * 50 + [1354.0])[-1]
    assert verdict.level == OK
    assert verdict.reason.endswith("inside the forbidden band 1349-1359 r/min (holding OK)")


def test_the_first_sample_is_judged_at_once(alarm: Alarm, run: Run) -> None:
    (verdict,) = run(alarm, [1700.0])
    assert (verdict.level, verdict.in_band) == (ERROR, True)
    assert verdict.time_to_band == 0
    assert verdict.distance == pytest.approx(-111 * RPM)


DRIVES = st.lists(st.tuples(st.floats(0, 2400), st.integers(1, 60)), min_size=1, max_size=8)


@settings(max_examples=60)
@given(DRIVES, st.booleans(), st.integers(0, 100))
def test_longer_inside_a_band_than_the_debounce_is_always_error_and_in_band(
    bands: Bands, run: Run, drive: list[tuple[float, int]], backward: bool, seed: int
) -> None:
    alarm = Alarm(bands, covered_speed=2101.6 * RPM)
    held = np.concatenate([np.full(n, v) for v, n in drive]) + np.random.default_rng(seed).uniform(-1, 1)
    inside = 0
    for speed, verdict in zip(held, run(alarm, -held if backward else held), strict=True):
        inside = inside + 1 if any(b.low <= abs(speed * RPM) <= b.high for b in bands) else 0
        if inside > alarm.settings.debounce * 100 + 1:
            assert (verdict.level, verdict.in_band) == (ERROR, True)


@settings(max_examples=60)
@given(DRIVES)
def test_further_outside_every_band_than_the_hysteresis_for_longer_than_the_hold_never_trips(
    bands: Bands, run: Run, drive: list[tuple[float, int]]
) -> None:
    alarm = Alarm(bands, covered_speed=2101.6 * RPM)
    held = np.concatenate([np.full(n, v) for v, n in drive])
    outside = 0
    for speed, verdict in zip(held, run(alarm, held), strict=True):
        clear = all(speed * RPM < b.low - 5 * RPM or speed * RPM > b.high + 5 * RPM for b in bands)
        outside = outside + 1 if clear else 0
        if outside > alarm.settings.hold * 100 + 1:
            assert not verdict.in_band


def test_levels_that_alternate_do_not_keep_a_trip_signal_alive(alarm: Alarm, run: Run, calm: Regime) -> None:
    # Out of the band, with evidence of chaos coming and going from sample to sample.
    leaning = Regime("undecided", None, 0.1, 0.05, "building")
    run(alarm, [1354.0] * 50)
    for n in range(100):
        verdict = alarm.update(0.5 + n / 100, 1000 * RPM, 600.0, leaning if n % 2 else calm)
    assert not verdict.in_band
    assert verdict.level in (OK, WARN)


def test_trouble_that_alternates_between_warning_and_error_is_shown(
    alarm: Alarm, run: Run, calm: Regime, chaotic: Regime
) -> None:
    # Near a band, and judged chaotic every second sample: at no moment all is well.
    run(alarm, [1000.0] * 50)
    for n in range(50):
        verdict = alarm.update(0.5 + n / 100, 1330 * RPM, 600.0, chaotic if n % 2 else calm)
    assert verdict.level in (WARN, ERROR)


def test_negative_speeds_are_judged_by_their_magnitude(bands: Bands, run: Run) -> None:
    forward, backward = (Alarm(bands, covered_speed=2101.6 * RPM) for _ in range(2))
    speeds = np.arange(1200, 1700, 1.0)
    for a, b in zip(run(forward, speeds), run(backward, -speeds), strict=True):
        assert (a.level, a.in_band, a.band, a.distance, a.time_to_band) == (
            b.level,
            b.in_band,
            b.band,
            b.distance,
            b.time_to_band,
        )
        assert a.calm_speed is not None
        assert b.calm_speed == -a.calm_speed


def test_beyond_the_studied_range_nothing_is_claimed(alarm: Alarm, run: Run) -> None:
    verdict = run(alarm, [2500.0] * 50)[-1]
    assert (verdict.level, verdict.in_band) == (STALE, False)
    assert "beyond the studied range, which ends at 2102 r/min" in verdict.reason


def test_standstill_is_well(alarm: Alarm, run: Run) -> None:
    verdict = run(alarm, [0.0] * 50)[-1]
    assert (verdict.level, verdict.in_band, verdict.time_to_band, verdict.calm_speed) == (OK, False, None, 0.0)


def test_chaos_outside_a_band_is_an_error_that_does_not_trip(alarm: Alarm, run: Run, chaotic: Regime) -> None:
    verdicts = run(alarm, [1000.0] * 60, regime=chaotic)
    assert (verdicts[-1].level, verdicts[-1].in_band) == (ERROR, False)
    assert levels(verdicts[1:]) == [WARN, ERROR], "chaos of a moment warns, and one that lasts is an error"
    verdict = verdicts[-1]
    assert verdict.reason == "the motion is chaotic at 1000 r/min and 600 N·m: exponent 0.1000"


def test_chaos_beyond_the_studied_range_is_an_error(alarm: Alarm, run: Run, chaotic: Regime) -> None:
    assert run(alarm, [2500.0] * 60, regime=chaotic)[-1].level == ERROR


def test_building_evidence_of_chaos_warns(alarm: Alarm, run: Run) -> None:
    leaning = Regime("undecided", None, 0.1, 0.05, "exponent 0.1 ± 0.05")
    verdict = run(alarm, [1000.0] * 50, regime=leaning)[-1]
    assert verdict.level == WARN
    assert verdict.reason == "evidence of chaos is building: exponent 0.1 ± 0.05"


def test_a_clock_that_steps_back_starts_the_alarm_afresh(alarm: Alarm, run: Run) -> None:
    run(alarm, [1700.0] * 50, start=100.0)
    (verdict,) = run(alarm, [1000.0], start=50.0)
    assert (verdict.level, verdict.in_band, verdict.time_to_band) == (OK, False, None)


def test_missing_input_is_stale_and_the_next_update_starts_afresh(alarm: Alarm, run: Run) -> None:
    run(alarm, [1700.0] * 50)
    verdict = alarm.stale("no speed for 1 s")
    assert verdict == Verdict(STALE, "no speed for 1 s", False, None, None, None, None, bands="published")
    assert run(alarm, [1000.0], start=1.0)[0].level == OK


def test_samples_of_one_time_are_no_acceleration(alarm: Alarm, calm: Regime) -> None:
    for rpm in (1000, 1010, 1020, 1030):
        verdict = alarm.update(1.0, rpm * RPM, 600.0, calm)
    assert alarm.acceleration() == 0
    assert verdict.time_to_band is None


@pytest.mark.parametrize("name", ["margin", "horizon", "hysteresis", "debounce", "hold", "slope_window"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_impossible_settings_are_refused_by_name_and_value(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"The alarm's {name} is {value!r}, expected a finite number of at least 0"):
        AlarmSettings(**{name: value})


def test_a_slope_window_without_length_is_refused() -> None:
    with pytest.raises(ValueError, match="slope_window is 0 s, expected more than 0"):
        AlarmSettings(slope_window=0.0)
