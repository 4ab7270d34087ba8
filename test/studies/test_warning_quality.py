"""The labelled suite: its runs, its truth and its scores, on records made by hand; and a few runs whole."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.bench.profiles import Profile, path
from seat_gear_dynamics.gears import ForbiddenBand, GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes import RegimeMap, simulate
from seat_gear_dynamics.sensing import AlarmSettings, Level, PublishedBands
from seat_gear_dynamics.studies.warning_quality.assess import Assessment, assess, gathered, known_motions, outcome
from seat_gear_dynamics.studies.warning_quality.machine import drawn_machine, machine_motions, machine_samples
from seat_gear_dynamics.studies.warning_quality.run import SCORES, Record, play
from seat_gear_dynamics.studies.warning_quality.scenarios import FAMILIES, Scenario, suite
from seat_gear_dynamics.studies.warning_quality.score import (
    MEMORY,
    Tally,
    poisson_upper,
    rates,
    samples,
    spans,
    tally,
)
from seat_gear_dynamics.studies.warning_quality.truth import Truth, around, is_steady, motions, steady_points, truth

STEP = 0.01
N = 1000
OK, WARN, ERROR = Level.OK, Level.WARN, Level.ERROR
NO = np.zeros(N, dtype=bool)
Flags = NDArray[np.bool_]


def between(begin: float, end: float) -> Flags:
    """Return flags that are true from `begin` to `end`, s."""
    time = STEP * np.arange(1, N + 1)
    return np.asarray((time > begin + 1e-9) & (time <= end + 1e-9))


def record(error: Flags = NO, warn: Flags = NO, family: str = "inside", acceleration: float = 0.0) -> Record:
    """Return a record of 10 s at a steady drive with these levels."""
    profile = Profile("p", "p", path(1000.0, (1000.0, 10.0)), path(600.0, (600.0, 10.0)))
    level = np.where(error, int(ERROR), np.where(warn, int(WARN), int(OK)))
    scores = np.zeros((N, len(SCORES)))
    time = np.array([STEP * k for k in range(1, N + 1)])
    run = Scenario(family, profile, acceleration=acceleration)
    return Record(run, time, np.full(N, 100.0), np.full(N, 600.0), level, error, NO, scores)


def told(inside: Flags = NO, chaotic: Flags = NO, doubt: Flags = NO, edge: Flags = NO) -> Truth:
    distance = np.where(inside | edge, -20.0, 100.0)
    entry = np.where(inside, 0.0, np.inf)
    return Truth(distance, inside, ~(inside | edge), ~NO, chaotic, ~(chaotic | doubt), entry)


def scored(found: Record, true: Truth) -> Tally:
    return tally(found, true, AlarmSettings())


def test_a_stay_that_is_seen_in_time_is_no_miss_and_its_delay_is_known() -> None:
    found = scored(record(error=between(3.1, 5.2)), told(inside=between(3, 5)))
    assert (found.stays, found.missed, found.unseen, found.false_errors) == (1, 0, 0, 0)
    assert found.delays == [pytest.approx(0.1)]


@pytest.mark.parametrize(("until", "missed", "unseen"), [(3.0, 1, 1), (3.49, 0, 0), (3.6, 1, 0)])
def test_a_stay_longer_than_half_a_second_has_half_a_second(until: float, missed: int, unseen: int) -> None:
    error = NO if until == 3.0 else between(until, 5)
    found = scored(record(error=error), told(inside=between(3, 5)))
    assert (found.stays, found.missed, found.unseen) == (1, missed, unseen)


def test_a_short_crossing_is_no_stay() -> None:
    assert scored(record(), told(inside=between(3, 3.5))).stays == 0
    assert scored(record(), told(inside=between(3, 3.52))).stays == 1


def test_an_error_without_cause_is_false_and_once_for_each_stretch() -> None:
    found = scored(record(error=between(2, 3) | between(5, 5.01)), told())
    assert (found.false_errors, found.doubtful_errors) == (2, 0)
    assert found.per_hour(found.false_errors) == pytest.approx(720)


def test_an_error_is_explained_for_as_long_as_hold_and_record_take_and_no_longer() -> None:
    cause = told(inside=between(2, 3))
    assert scored(record(error=between(2, 3 + MEMORY)), cause).false_errors == 0
    assert scored(record(error=between(2, 3 + MEMORY + 0.05)), cause).false_errors == 1
    assert scored(record(error=between(1.9, 3)), cause).false_errors == 1


def test_chaos_and_an_edge_explain_an_error_and_doubt_is_counted_apart() -> None:
    error = record(error=between(2, 3))
    assert scored(error, told(chaotic=between(2, 3))).false_errors == 0
    assert scored(error, told(edge=between(2, 3))).false_errors == 0
    found = scored(error, told(doubt=between(2, 3)))
    assert (found.false_errors, found.doubtful_errors) == (0, 1)


def test_a_warning_far_from_everything_is_false_and_one_at_the_margin_is_not() -> None:
    found = record(warn=between(2, 3))
    assert scored(found, told()).false_warnings == 1
    near = replace(told(), distance=np.full(N, 40 * RPM))
    assert scored(found, near).false_warnings == 0
    soon = replace(told(), ahead=np.full(N, 1.2))
    assert scored(found, soon).false_warnings == 0


def test_notice_is_what_stood_without_a_break_before_a_ramps_entry() -> None:
    inside = between(4, 6)

    def notices(warn: Flags, true: Flags, acceleration: float = 200.0) -> list[tuple[float, float]]:
        return scored(record(true, warn, "ramp", acceleration), told(inside=true)).notices

    assert notices(between(1, 2) | between(3.2, 4), inside) == [pytest.approx((200.0, 0.8))]
    assert notices(between(0, 4), inside) == [(200.0, 2.0)]
    assert notices(NO, inside) == [(200.0, 0.0)]
    assert notices(NO, between(1.1, 2)) == []
    assert notices(NO, inside, 0.0) == []


def test_a_notice_goes_with_the_time_since_its_ramp_began() -> None:
    inside = between(4, 6)
    still = record(inside, NO, "ramp", 200.0)
    moving = replace(still, speed=still.speed + np.where(still.time >= 2.5, 10 * RPM, 0.0))
    found = scored(moving, told(inside=inside))
    assert found.leads == [pytest.approx(1.5, abs=0.02)]
    early = Tally(notices=[(200.0, 0.4), (200.0, 0.9), (50.0, 1.0)], leads=[0.5, 1.5, 2.0])
    score = Assessment(early, {}, {}, {})
    assert score.median_notice(200.0) == pytest.approx(0.65)
    assert score.median_notice(200.0, lead=1.0) == 0.9
    assert np.isnan(score.median_notice(400.0, lead=1.0))


def test_chatter_is_counted_on_edges_once_settled() -> None:
    flicker = between(0.2, 0.4) | between(3, 4) | between(6, 7)
    found = scored(record(error=flicker, family="edge"), told(edge=~NO))
    assert (found.edge_runs, found.edge_changes, found.chattering) == (1, 4, 1)
    assert scored(record(error=flicker), told(edge=~NO)).edge_runs == 0


def test_chaos_outside_bands_is_looked_for() -> None:
    chaos = between(2, 4) | between(6, 6.9)
    assert scored(record(error=between(3, 4)), told(chaotic=chaos)).chaos_seen == 1
    found = scored(record(), told(chaotic=chaos))
    assert (found.chaos_stays, found.chaos_seen) == (1, 0)


def test_tallies_add_up_field_by_field() -> None:
    one = scored(record(error=between(3.1, 5)), told(inside=between(3, 5)))
    both = one + one
    assert (both.runs, both.stays, both.delays) == (2, 2, one.delays * 2)
    assert sum([one, one], Tally()) == both


def test_poisson_bounds_are_those_of_the_tables() -> None:
    # Garwood 1936: one-sided 95 % bounds of 0, 1 and 5 events are 2.996, 4.744 and 10.513.
    assert [poisson_upper(n) for n in (0, 1, 5)] == pytest.approx([2.9957, 4.7439, 10.5130], abs=1e-4)


def test_the_roc_of_a_perfect_of_a_useless_and_of_a_known_score() -> None:
    label = np.arange(1000) >= 500
    assert rates(label.astype(float), label).area == pytest.approx(1.0)
    assert rates(np.full(1000, 0.3), label).area == pytest.approx(0.5)
    generator = np.random.default_rng(0)
    normal = generator.normal(size=20000) + np.repeat([0.0, 1.0], 10000)
    # Two normals one deviation apart: area Phi(1/sqrt 2) = 0.7602; 10 000 of each give it to 0.0033, three of these.
    assert rates(1 / (1 + np.exp(-normal)), np.arange(20000) >= 10000).area == pytest.approx(0.7602, abs=0.01)
    with pytest.raises(ValueError, match="0 positive and 1000 negative samples"):
        rates(label.astype(float), NO)


def test_samples_of_the_roc_are_those_with_a_sure_label() -> None:
    true = told(inside=between(3, 4), doubt=between(6, 8), edge=between(2.5, 3))
    true = replace(true, ahead=np.where(between(2, 3), 0.2, true.ahead))
    scores, now, ahead = samples(record(), true)
    # 10 s less 1 s to settle, less 2 s in doubt and 0.5 s on the edge, every fifth sample.
    assert len(scores) == len(now) == pytest.approx(6.5 * 20, abs=2)
    assert now.sum() == pytest.approx(20, abs=1)
    assert ahead.sum() == pytest.approx(30, abs=1)


def test_spans_are_runs_of_true() -> None:
    assert spans(np.array([True, False, True, True])) == [(0, 1), (2, 4)]
    assert spans(NO) == []


@pytest.fixture(scope="module")
def published(train: GearTrain) -> PublishedBands:
    return PublishedBands.of(train)


def test_a_suite_is_repeatable_and_does_not_depend_on_its_length(published: PublishedBands) -> None:
    first, longer = (suite(published, (500.0, 650.0), seed=3, count=n) for n in (10, 25))
    assert longer[:10] == first
    assert suite(published, (500.0, 650.0), seed=4, count=10) != first
    assert {each.family for each in longer} == {name.removesuffix(" again") for name in FAMILIES}


@pytest.mark.parametrize("seed", range(8))
def test_runs_do_what_their_family_says(published: PublishedBands, seed: int) -> None:
    bands = np.array([(band.low, band.high) for band in published.at(600.0)]) / RPM
    for run in suite(published, (500.0, 650.0), seed=seed, count=30):
        speeds = np.array([v for _, v in run.profile.speed_points])
        inside = ((speeds[:, None] >= bands[:, 0]) & (speeds[:, None] <= bands[:, 1])).any(axis=1)
        assert np.abs(speeds).max() <= published.covered_speed / RPM
        if run.family in ("inside", "coarse sensor"):
            assert inside.tolist() == [False, False, True, True, False, False]
        elif run.family in ("beside", "noise", "stop"):
            assert not inside.any()
        elif run.family == "edge":
            assert np.abs(speeds[0] - bands).min() <= 3.0
            assert run.speed_noise == pytest.approx(5 * RPM)
        elif run.family == "ramp":
            assert run.acceleration == pytest.approx(
                abs(speeds[2] - speeds[1]) / np.diff([t for t, _ in run.profile.speed_points][1:3])[0]
            )


def test_a_source_without_bands_is_refused() -> None:
    with pytest.raises(ValueError, match="have none between 500 and 650"):
        suite(PublishedBands([], 200.0), (500.0, 650.0), seed=1, count=1)


def test_steady_is_where_the_last_half_second_stood_still() -> None:
    speed = np.concatenate([np.full(100, 100.0), np.linspace(100, 120, 100), np.full(100, 120.0)])
    still = is_steady(speed, np.full(300, 600.0), STEP)
    # 2 r/min of tolerance are 0.2 rad/s: one sample of this ramp.
    assert [int(k) for k in np.flatnonzero(np.diff(still.astype(int)))] == pytest.approx([49, 100, 248], abs=2)


def test_motions_around_a_point_must_agree(train: GearTrain) -> None:
    calm, rest = (train.speed(0.4), 600.0), (0.0, 600.0)
    found = motions(train, [calm, rest], transient=300, periods=200)
    assert found == {calm: "calm", rest: "calm"}


def test_a_moving_drive_is_held_against_the_maps_nodes_around_it(train: GearTrain) -> None:
    codes = np.array([[0, 0, 2, 2], [0, 2, 2, 2]])
    zeros = np.zeros((2, 4))
    speeds, loads = np.array([10.0, 20.0, 30.0, 40.0]), np.array([100.0, 200.0])
    nominal = RegimeMap(speeds, loads, codes, codes, zeros, zeros, zeros, zeros, 0, "made", 1, 48)
    found = [around(nominal, v, 150.0) for v in (5.0, 15.0, 25.0, -35.0, 45.0)]
    assert found == ["calm", "either", "either", "chaotic", "either"]
    assert around(nominal, 15.0, 100.0) == "calm"
    assert around(nominal, 15.0, 250.0) == "either"


@pytest.fixture(scope="module")
def nominal(train: GearTrain) -> RegimeMap:
    """A coarse map of the fixed train, whose nodes the moving drives are held against."""
    speeds = [train.speed(each) for each in (0.25, 0.5, 0.75, 1.0)]
    return RegimeMap.compute(System(train), speeds, [500.0, 700.0], transient=100, periods=100)


@pytest.fixture(scope="module")
def source(train: GearTrain) -> PublishedBands:
    """One band, in the middle of speeds at which the fixed train is calm."""
    return PublishedBands([ForbiddenBand(train.speed(0.40), train.speed(0.45), 600.0)], train.speed(0.6))


def test_runs_through_the_monitors_session_are_scored_as_they_should(
    train: GearTrain, source: PublishedBands, nominal: RegimeMap
) -> None:
    told_progress: list[tuple[int, int]] = []
    runs = suite(source, (550.0, 650.0), seed=1, count=10)
    found = assess(runs, train, source, nominal, progress=lambda *done: told_progress.append(done))
    assert told_progress == [(k, 10) for k in range(1, 11)]
    whole = found.whole
    assert (whole.runs, whole.missed, whole.unseen, whole.false_errors) == (10, 0, 0, 0)
    assert whole.stays >= 2
    # Debounce and the sensor's age, and 0.15 s of a line where the sensor is coarse.
    assert max(whole.delays) < 0.3
    assert whole.chattering == 0
    assert found.rocs["danger"].area > 0.99
    assert set(found.families) == {run.family for run in runs}


def test_the_order_of_runs_changes_no_count(train: GearTrain, source: PublishedBands, nominal: RegimeMap) -> None:
    runs = suite(source, (550.0, 650.0), seed=2, count=3)
    told: list[tuple[str, int, int]] = []
    known = known_motions(runs, train, tell=lambda *given: told.append(given))
    assert told[:3] == [("drives of the runs", k, 3) for k in (1, 2, 3)]
    assert told[3:] == [("motions where they dwell", k, len(told) - 3) for k in range(1, len(told) - 2)]
    assert len(told) > 3
    found = [outcome(run, train, source, AlarmSettings(), known, nominal) for run in runs]
    one, other = gathered(found), gathered(found[::-1])
    assert one.whole.per_hour(1) == other.whole.per_hour(1)
    assert sorted(one.whole.delays) == sorted(other.whole.delays)
    assert one.rocs.keys() == other.rocs.keys()
    assert gathered([]).whole == Tally()


def test_a_blind_alarm_is_found_out(train: GearTrain, source: PublishedBands, nominal: RegimeMap) -> None:
    run = next(each for each in suite(source, (550.0, 650.0), seed=1, count=10) if each.family == "inside")
    known = known_motions([run], train)
    slow = AlarmSettings(debounce=5.0)
    assert outcome(run, train, source, slow, known, nominal).counts.missed == 1
    elsewhere = PublishedBands([], source.covered_speed)
    true = truth(play(run, train, elsewhere), source, known, nominal)
    assert true.inside.any()
    assert tally(play(run, train, elsewhere), true, AlarmSettings()).unseen == 1


def test_a_record_holds_what_was_true_and_what_was_said(train: GearTrain, source: PublishedBands) -> None:
    run = suite(source, (550.0, 650.0), seed=1, count=2)[1]
    found = play(run, train, source)
    assert np.ptp(np.diff(found.time)) < 1e-9
    assert len(found.time) == round(run.profile.duration / run.sample_time)
    assert found.speed[0] == pytest.approx(run.profile.speed_points[0][1] * RPM)
    assert found.in_band.any()
    assert np.isfinite(found.scores[:, 0]).all()


def test_a_drawn_machine_is_its_seeds_and_its_motion_its_own(train: GearTrain, source: PublishedBands) -> None:
    machine = drawn_machine(train, 5)
    assert machine == drawn_machine(train, 5) != drawn_machine(train, 6)
    point = (train.speed(0.4), 600.0)
    found = machine_motions(machine, [point, (0.0, 600.0)], transient=300, periods=200)
    assert found == {point: simulate(System(machine), speed=point[0], load=600.0).regime.name == "chaotic"}
    run = suite(source, (550.0, 650.0), seed=1, count=3)[2]
    played = play(run, train, source)
    scores, chaotic = machine_samples(played, dict.fromkeys(steady_points(run), True))
    assert chaotic.all()
    assert len(scores) == len(chaotic) > 50
    assert len(machine_samples(played, {})[0]) == 0
