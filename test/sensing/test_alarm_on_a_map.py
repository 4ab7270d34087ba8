"""The alarm on bands that follow the load, with the map's probability, and under noise."""

from collections.abc import Callable, Sequence
from itertools import groupby

import numpy as np
import pytest

from seat_gear_dynamics.gears import ForbiddenBand, GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes import Regime, RegimeMap
from seat_gear_dynamics.sensing import Alarm, AlarmSettings, Level, MapBands, Session, Verdict

OK, WARN, ERROR, STALE = Level.OK, Level.WARN, Level.ERROR, Level.STALE
SETTINGS = AlarmSettings(margin=2.0)


@pytest.fixture
def source(make_map: Callable[..., RegimeMap], train: GearTrain) -> MapBands:
    """30-70 rad/s are forbidden at 100 and 200 N·m, 80-120 rad/s at 300 and 400 N·m; between, either."""
    low, high = [0, 0, 0, 1, 1, 1] + [0] * 10, [0] * 8 + [1, 1, 1] + [0] * 5
    return MapBands(make_map([low, low, high, high]), train)


@pytest.fixture
def feed(calm: Regime) -> Callable[..., list[Verdict]]:
    """Feed speeds in rad/s and loads in N·m, 100 a second."""

    def run(alarm: Alarm, speeds: Sequence[float], loads: Sequence[float], regime: Regime = calm) -> list[Verdict]:
        return [alarm.update(n / 100, v, w, regime) for n, (v, w) in enumerate(zip(speeds, loads, strict=True))]

    return run


Feed = Callable[..., list[Verdict]]


def test_a_load_step_that_moves_a_band_over_the_speed_is_seen_within_the_debounce(source: MapBands, feed: Feed) -> None:
    alarm = Alarm(source, settings=SETTINGS)
    loads = [150.0] * 100 + [350.0] * 100 + [150.0] * 100
    found = feed(alarm, [100.0] * 300, loads)
    assert not any(v.in_band for v in found[:100])
    inside = [n for n, v in enumerate(found) if v.in_band]
    assert inside[0] - 100 == pytest.approx(alarm.settings.debounce * 100, abs=1)
    assert inside[-1] + 1 - 200 == pytest.approx(alarm.settings.hold * 100, abs=1)


def test_a_noisy_load_hides_no_step(source: MapBands, feed: Feed) -> None:
    noise = np.random.default_rng(0).normal(0, 5, 200)
    found = feed(Alarm(source, settings=SETTINGS), [100.0] * 200, np.repeat([150.0, 350.0], 100) + noise)
    assert not any(v.in_band for v in found[:100])
    assert all(v.in_band for v in found[110:])


def test_a_band_that_the_load_brings_is_announced(make_map: Callable[..., RegimeMap], train: GearTrain) -> None:
    # The low edge goes from 55 rad/s at 100 N·m to 35 at 200 N·m: 0.2 rad/s per N·m.
    first, second = [0, 0, 0, 0, 0, 1, 1, 1, 0], [0, 0, 0, 1, 1, 1, 1, 1, 0]
    alarm = Alarm(MapBands(make_map([first, second]), train), settings=SETTINGS)
    calm = Regime("periodic", 1, -0.1, 0.01, "recurs after 1")
    for n in range(60):
        verdict = alarm.update(n / 100, 40.0, 100.0 + n / 2, calm)  # 50 N·m/s
    # At 129.5 N·m the edge stands at 44.1 rad/s and comes at 10 rad/s²: 0.41 s, in which 12 halvings are exact.
    assert verdict.level == WARN
    assert verdict.time_to_band == pytest.approx((50 - 0.2 * 29.5 - 40) / 10, abs=1e-3)
    assert "ahead at the present acceleration" in verdict.reason


def test_outside_the_map_the_level_is_stale_and_the_sentence_names_its_ends(source: MapBands, feed: Feed) -> None:
    for speed, load in ((50.0, 90.0), (50.0, 450.0), (165.0, 200.0)):
        verdict = feed(Alarm(source, settings=SETTINGS), [speed] * 50, [load] * 50)[-1]
        assert (verdict.level, verdict.in_band, verdict.probability) == (STALE, False, None)
        assert "are outside the map, which covers 0 to 1528 r/min and 100 to 400 N·m" in verdict.reason


def test_chaos_outside_the_map_is_an_error_still(source: MapBands, feed: Feed, chaotic: Regime) -> None:
    verdict = feed(Alarm(source, settings=SETTINGS), [50.0] * 60, [450.0] * 60, chaotic)[-1]
    assert (verdict.level, verdict.in_band) == (ERROR, False)


def test_standstill_is_well(source: MapBands, feed: Feed) -> None:
    assert feed(Alarm(source, settings=SETTINGS), [0.0] * 50, [150.0] * 50)[-1].level == OK


def test_the_maps_probability_warns_outside_bands_and_says_so(
    make_map: Callable[..., RegimeMap], train: GearTrain, feed: Feed
) -> None:
    likely = [0.0, 0.0, 0.4, 0.4, 0.4, 0.0, 0.0]
    alarm = Alarm(MapBands(make_map([likely, likely], samples=50), train), settings=SETTINGS)
    verdict = feed(alarm, [40.0] * 50, [150.0] * 50)[-1]
    assert (verdict.level, verdict.in_band) == (WARN, False)
    assert verdict.reason == "the map gives chaos a probability of 40% at 382 r/min and 150 N·m"
    assert verdict.probability == pytest.approx(20.5 / 51)
    assert feed(alarm, [10.0] * 100, [150.0] * 100)[-1].level == OK


def test_two_weak_signs_warn_together_and_both_are_named(
    make_map: Callable[..., RegimeMap], train: GearTrain, feed: Feed
) -> None:
    chance = [0.0, 0.2, 0.2, 0.2, 0.2, 0.9, 0.0]
    alarm = Alarm(MapBands(make_map([chance, chance], samples=50), train), settings=AlarmSettings(margin=10.0))
    (band,) = alarm.source.at(150.0)
    verdict = feed(alarm, [band.low - 11.0] * 50, [150.0] * 50)[-1]
    assert all(each.level == OK for each in verdict.evidence)
    assert verdict.level == WARN
    assert verdict.reason.startswith("no sign alone warns, together they make danger")
    assert "from a forbidden band" in verdict.reason
    assert "the map gives chaos a probability of 2" in verdict.reason


def test_evidence_and_danger_are_told_with_the_verdict(source: MapBands, feed: Feed, chaotic: Regime) -> None:
    inside = feed(Alarm(source, settings=SETTINGS), [50.0] * 50, [150.0] * 50, chaotic)[-1]
    assert [each.kind for each in inside.evidence][:2] == ["band", "motion"]
    assert inside.reason.startswith("477 r/min is inside the forbidden band 286-668 r/min")
    assert inside.danger is not None
    assert inside.danger > 0.99
    assert inside.odds.startswith("prior")
    far = feed(Alarm(source, settings=SETTINGS), [140.0] * 50, [150.0] * 50)[-1]
    assert far.danger is not None
    assert far.danger < 0.27


def test_the_nearest_calm_speed_is_that_of_the_load(source: MapBands, feed: Feed) -> None:
    alarm = Alarm(source, settings=SETTINGS)
    light, heavy = (feed(alarm, [v] * 50, [w] * 50)[-1].calm_speed for v, w in ((60.0, 150.0), (80.0, 350.0)))
    assert light == pytest.approx(70.0 + 2.0)
    assert heavy == pytest.approx(80.0 - 2.0)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("offset", [-3.0, 0.0, 3.0])
def test_noise_of_5_rpm_on_an_edge_changes_the_level_once_at_most(calm: Regime, offset: float, seed: int) -> None:
    alarm = Alarm([ForbiddenBand(1349 * RPM, 1700 * RPM, 600.0)], covered_speed=2100 * RPM)
    speeds = 1349 + offset + np.random.default_rng(seed).normal(0, 5.0, 1500)
    levels = [alarm.update(n / 100, v * RPM, 600.0, calm).level for n, v in enumerate(speeds.tolist())]
    assert len(list(groupby(levels[100:]))) <= 2


def test_bands_without_a_covered_speed_are_refused(bands: tuple[ForbiddenBand, ...]) -> None:
    with pytest.raises(ValueError, match="without covered_speed"):
        Alarm(bands)


def test_a_session_takes_a_map_and_begins_with_the_published_bands(train: GearTrain, source: MapBands) -> None:
    assert Session(train).alarm.source.name == "published"
    session = Session(train, bands=source)
    assert session.alarm.source is source
    assert session.feed(0.0, 50.0, 150.0).verdict.in_band
    assert session.feed(0.01, 50.0, 150.0).verdict.probability is not None


def test_the_transient_of_a_model_that_has_just_begun_is_no_evidence(calm: Regime, chaotic: Regime) -> None:
    alarm = Alarm([], covered_speed=200.0)
    young = [alarm.update(n / 100, 100.0, 600.0, chaotic, settled=False) for n in range(150)]
    assert {v.level for v in young} == {OK}
    # Nor does it count that it has lasted: the first half second is that from now on.
    settled = [alarm.update(1.5 + n / 100, 100.0, 600.0, chaotic) for n in range(60)]
    stated = [v.reason.startswith("the motion is chaotic") for v in settled]
    assert stated.index(True) == 50
    assert all(stated[50:])
