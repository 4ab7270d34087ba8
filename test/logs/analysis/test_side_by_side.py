"""Stretches side by side against one session over the whole drive."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis.batches import Batch
from seat_gear_dynamics.logs.analysis.estimate import Estimate
from seat_gear_dynamics.logs.analysis.seam import SAME_MOTION, Join, Phase, Seam
from seat_gear_dynamics.logs.analysis.side_by_side import SideBySide, Stretches
from seat_gear_dynamics.motion.march import LONGEST_STEP
from seat_gear_dynamics.regimes.regime_map import RegimeMap
from seat_gear_dynamics.sensing import BandSource, MapBands
from seat_gear_dynamics.sensing.virtual_sensor import SENSOR_STATE_NAMES

Array = NDArray[np.float64]
RATE = 50  # samples a second
PLACE = SENSOR_STATE_NAMES.index("phase/place")


def drive(speed: Callable[[Array], Array], seconds: float, *, seed: int = 0) -> list[Batch]:
    """Return batches of a second: a speed over time in r/min with a sensor's noise, 600 N·m."""
    noise = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 1 / RATE)
    speeds = (speed(time) + noise.normal(0, 0.5, len(time))) * RPM
    rows = np.column_stack([time, speeds, noise.normal(600, 5, len(time)), np.ones(len(time))])
    return [Batch(drive=part) for part in np.split(rows, range(RATE, len(rows), RATE))]


def in_a_row(train: GearTrain, batches: list[Batch]) -> list[Batch]:
    estimate = Estimate(train)
    for batch in batches:
        estimate.extend(batch)
    return batches


def beside(
    train: GearTrain, batches: list[Batch], *, workers: int = 1, bands: BandSource | None = None
) -> tuple[list[Batch], Stretches]:
    cut = SideBySide(train, bands=bands, workers=workers, stretch=3.9, run_in=2.0)
    return list(cut.batches(iter(batches))), cut.stretches


def together(batches: list[Batch], name: str) -> Array:
    return np.concatenate([getattr(batch, name) for batch in batches])


def slow(time: Array) -> Array:
    return np.asarray(450 + 150 * np.sin(time))


def test_a_short_log_is_one_stretch_and_one_session_bit_for_bit(train: GearTrain) -> None:
    one, (found, stretches) = in_a_row(train, drive(slow, 5.0)), beside(train, drive(slow, 5.0))
    assert stretches == Stretches(count=1)
    for name in ("force", "state", "section"):
        np.testing.assert_array_equal(together(found, name), together(one, name))
    assert [batch.warnings for batch in found] == [batch.warnings for batch in one]
    assert [batch.restarts for batch in found] == [batch.restarts for batch in one]


def test_calm_stretches_join_and_are_one_session_but_for_a_part_of_a_step(train: GearTrain) -> None:
    one, (found, stretches) = in_a_row(train, drive(slow, 20.0)), beside(train, drive(slow, 20.0))
    assert stretches.count >= 3
    assert stretches == Stretches(count=stretches.count)
    np.testing.assert_array_equal(together(found, "drive"), together(one, "drive"))
    points, others = together(found, "section"), together(one, "section")
    assert len(points) == len(others)
    # Steps lie elsewhere by a part of one, so the inputs held over a step do too: at 600 r/min in a second that is
    # 1e-4 of the speed. Points then differ by what the tolerance of a seam allows at most.
    assert np.abs(points[:, 0] - others[:, 0]).max() < 2 * LONGEST_STEP / train.model.time_scale
    assert np.abs(points[:, 1:3] - others[:, 1:3]).max() < SAME_MOTION
    assert {restart for batch in found for restart in batch.restarts} == {(0.0, "started")}


def test_no_time_is_lost_or_counted_twice_at_a_seam(train: GearTrain) -> None:
    """The mean force carries the torque: weighed by its window's length it is that of one session."""
    sums = []
    for batches in (in_a_row(train, drive(slow, 20.0)), beside(train, drive(slow, 20.0))[0]):
        force = together(batches, "force")
        sums.append(float(np.sum(np.diff(force[:, 0], prepend=0.0) * force[:, 1])))
    # 6000 N·s; a seam that loses or repeats a sample of 20 ms would show as 1e-3.
    assert sums[0] == pytest.approx(sums[1], rel=1e-4)


def test_where_a_stretch_does_not_join_it_is_marched_again_in_a_row(
    train: GearTrain, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Phase, "join", lambda self, earlier, later: Join.NONE)
    one, (found, stretches) = in_a_row(train, drive(slow, 14.0)), beside(train, drive(slow, 14.0))
    assert stretches.again == stretches.count - 1 >= 2
    # The same session throughout: bit for bit. Force windows are cut at a seam, which the section does not see.
    np.testing.assert_array_equal(together(found, "section"), together(one, "section"))


def test_another_motion_at_a_seam_is_found(train: GearTrain, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stretches that begin with another mesh phase arrive in a motion that the one before was not in."""
    right = SideBySide(train)._phase.follow(drive(slow, 1.0)[0].drive)
    assert right[0] == 0.0
    monkeypatch.setattr(Phase, "set", lambda self, state, phase: state)
    _, stretches = beside(train, drive(slow, 14.0))
    assert stretches.again == stretches.count - 1


@pytest.mark.parametrize(
    "speeds", [slow, lambda time: 300 * np.cos(time / 2), lambda time: np.clip(20 * time - 80, 0, 500)]
)
def test_the_phase_at_a_seam_is_that_of_a_march_from_the_first_sample(
    train: GearTrain, speeds: Callable[[Array], Array]
) -> None:
    batches, cut = drive(speeds, 12.0), SideBySide(train)
    phase = [cut._phase.follow(batch.drive)[-1] for batch in batches][-1]
    estimate = Estimate(train)
    for batch in batches:
        estimate.extend(batch)
    seam = estimate.seam
    assert seam is not None
    judged = Phase(train)
    apart = judged.set(seam.state, float(phase))[PLACE] - seam.state[PLACE]
    apart = (apart + judged._cycle / 2) % judged._cycle - judged._cycle / 2
    # The march is ahead by less than one step of the coarsest grid that it may be on, of 272 a period or finer.
    assert abs(apart) / judged._period <= 1.5 / 272


def seam(train: GearTrain, **changed: object) -> Seam:
    estimate = Estimate(train)
    for batch in drive(slow, 3.0):
        estimate.extend(batch)
    found = estimate.seam
    assert found is not None
    return found._replace(**changed)  # type: ignore[arg-type]


def test_seams_are_judged_by_state_phase_and_verdict(train: GearTrain) -> None:
    judge, one = Phase(train), seam(train)
    moved = one.state.copy()
    assert judge.join(one, one) is Join.SAME
    for index in (0, 11, 12, 23):
        for amount, join in ((0.5 * SAME_MOTION, Join.SAME), (2 * SAME_MOTION, Join.NONE)):
            moved = one.state.copy()
            moved[index] += amount
            # A rate shifts the displacement by what a march is ahead, which is the same in both.
            assert judge.join(one, one._replace(state=moved)) is join
    for change in ({"level": 2}, {"in_band": True}, {"regime": "chaotic"}):
        assert judge.join(one, one._replace(**change)) is Join.NONE
    assert judge.join(one, one._replace(state=judge.set(one.state, 0.5))) is Join.NONE


def test_chaos_joins_chaos_and_a_long_period_joins_itself_some_periods_off(train: GearTrain) -> None:
    judge, one = Phase(train), seam(train)
    other = one.state.copy()
    other[0] += 1.0
    chaos = one._replace(regime="chaotic")
    assert judge.join(chaos, chaos._replace(state=other)) is Join.CHAOS
    orbit = np.tile([[0.1, 0.0, 0.0], [0.5, 0.2, 0.0], [0.9, -0.3, 0.0]], (20, 1))
    three = one._replace(regime="periodic", section=orbit)
    assert judge.join(three, three._replace(state=other, section=np.roll(orbit, 1, axis=0))) is Join.SHIFTED
    assert judge.join(three, three._replace(state=other, section=orbit + 0.1)) is Join.NONE
    assert judge.join(three, three._replace(state=other, section=np.roll(orbit, 1, axis=0)[:10])) is Join.NONE
    other[8] += 1.0  # P34 is in another motion
    assert judge.join(three, three._replace(state=other, section=np.roll(orbit, 1, axis=0))) is Join.NONE


def test_two_processes_change_no_bit_and_judge_by_the_same_bands(
    train: GearTrain, made_map: Callable[..., RegimeMap]
) -> None:
    bands = MapBands(made_map(train, [500.0, 700.0], [[(300, 500)]] * 2), train)
    results = [beside(train, drive(slow, 14.0), workers=workers, bands=bands) for workers in (1, 2)]
    assert results[0][1] == results[1][1]
    warned = [[each for batch in found for each in batch.warnings] for found, _ in results]
    assert warned[0] == warned[1]
    # Between 300 and 600 r/min no band is published; the map's reaches half a node farther than its crossings.
    assert any("inside the forbidden band 250-550" in each.text for each in warned[0])
    for name in ("force", "state", "section"):
        np.testing.assert_array_equal(together(results[0][0], name), together(results[1][0], name))


def test_an_empty_drive_and_gaps_pass(train: GearTrain) -> None:
    assert beside(train, [])[0] == []
    found, stretches = beside(train, [Batch(), *drive(slow, 5.0), Batch()])
    assert (len(found), stretches.count) == (7, 1)
    late = drive(slow, 20.0)
    for batch in late[6:]:
        batch.drive[:, 0] += 5.0
    one, (cut, stretches) = in_a_row(train, [Batch(drive=b.drive.copy()) for b in late]), beside(train, late)
    assert stretches.count > 2
    assert stretches.again == 0, "the phase begins anew where the model restarts"
    assert [r for batch in cut for r in batch.restarts] == [r for batch in one for r in batch.restarts]
