"""Whole runs: statics with and without friction, the start-up impact, what is refused, and golden values."""

from collections.abc import Callable
from dataclasses import replace
from math import inf, nan, pi, sqrt

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.studies.contact_verification import (
    CONDITIONS,
    READINGS,
    Assumptions,
    ConditionRun,
    Statistics,
    run_condition,
    run_conditions,
    start_up,
    static_chain,
)
from seat_gear_dynamics.studies.contact_verification.claims import efficiency
from seat_gear_dynamics.studies.contact_verification.impact import friction_coefficient
from seat_gear_dynamics.studies.contact_verification.line_of_action import Line
from seat_gear_dynamics.studies.contact_verification.readings import contacts
from seat_gear_dynamics.studies.contact_verification.verify import contact_frequency, rigid_train

Runner = Callable[..., ConditionRun]
GOLDEN_PEAK, GOLDEN_MEAN, GOLDEN_DEVIATION = 18884.5, 5873.86, 124.957


@pytest.mark.parametrize("reading", READINGS)
def test_without_friction_perfect_gears_transmit_the_static_force(
    train: GearTrain, short_run: Runner, reading: str
) -> None:
    run = short_run(6, Assumptions(reading=reading, friction=False))
    first, second = static_chain(train, run)
    assert first.expected == pytest.approx(5652, abs=0.5)
    # The mean force times a time is the load's impulse; what the bodies gain in speed meanwhile is below 1e-4 of it.
    assert first.relative == pytest.approx(0.0, abs=2e-4)
    assert second.relative == pytest.approx(0.0, abs=2e-4)
    assert efficiency(train, run) == pytest.approx(1.0, abs=2e-3)
    # m·Δδ/t² with 0.1 kg and a mesh that gives by 0.5 mm at most within a tooth's 27 ms is below 1 N; in the stiffest
    # readings a tip's entry within 1 ms gives by 6 µm, at twice the mass 2 N.
    assert run.settled.deviation < 2e-3 * run.static


def test_with_friction_one_pair_in_each_mesh_carries_what_statics_say(train: GearTrain) -> None:
    assumptions = Assumptions(reading="linear", stiction_speed=1e-3, friction_speed=3e-3)
    condition = replace(CONDITIONS[4], load=30.0)
    run = run_condition(train, condition, assumptions, duration=0.9, settled_from=0.3, sample_rate=4000.0)
    bodies = rigid_train(train, 0.0, assumptions)
    contact, _ = contacts(train, assumptions)
    first, second = bodies.first, bodies.second
    speed = run.condition.speed
    middle_speed = speed * first.driver_radius / first.driven_radius
    output_speed = middle_speed * second.driver_radius / second.driven_radius
    compared = 0
    for time, force in zip(run.history.time, run.history.force, strict=True):
        turned = speed * (time - assumptions.speed_ramp / 2)
        at_1, at_2 = alone(first, turned), alone(second, turned * middle_speed / speed)
        if time < run.settled_from or at_1 is None or at_2 is None:
            continue
        slips = (
            speed * at_1 - middle_speed * (first.length - at_1),
            (middle_speed * at_2 - output_speed * (second.length - at_2)),
        )
        if min(map(abs, slips)) < 6e-3:
            continue  # where friction falls with speed, and shortly after, teeth quiver about this balance
        mu_1, mu_2 = (friction_coefficient(contact, slip) for slip in slips)
        second_force = 30.0 / (second.driven_radius + (second.length - at_2) * mu_2)
        torque = second_force * (second.driver_radius + at_2 * mu_2)
        # Positions off by the bodies' lag, a few µm of some 10 mm.
        assert force == pytest.approx(torque / (first.driven_radius + (first.length - at_1) * mu_1), rel=5e-4)
        compared += 1
    assert compared > 20


def alone(line: Line, turned: float) -> float | None:
    """Return where the one pair is that is in contact, m, or None where another is on the path or near its ends.

    0.35 mm beyond the ends gaps are above 4 µm; the linear contact gives by 2 µm at 30 N·m.
    """
    moved = line.pitch_point + line.pitch / 4 + line.pitch * line.teeth * turned / (2 * pi) - line.start
    place = moved % line.pitch
    margin = 0.35e-3
    return line.start + place if line.end - line.start - line.pitch + margin < place < line.pitch - margin else None


def test_friction_costs_power_and_loads_the_first_mesh_more(train: GearTrain, short_run: Runner) -> None:
    run = short_run(6)
    assert 0.9 < efficiency(train, run) < 1
    first, second = static_chain(train, run)
    assert first.relative is not None
    assert second.relative is not None
    assert first.relative > second.relative > 0


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("corner", [True, False])
def test_force_is_never_negative_and_settled_teeth_stay_in_contact(
    short_run: Runner, reading: str, corner: bool
) -> None:
    run = short_run(7, Assumptions(reading=reading, corner=corner))
    history = run.history
    for force in (history.force, history.second_force, history.back_force):
        assert force.min() >= 0
    assert run.settled.contact_loss == 0
    assert run.start.contact_loss > 0


def test_abrupt_entry_doubles_the_force_and_corner_contact_does_not(short_run: Runner) -> None:
    abrupt, smooth = (short_run(4, Assumptions(friction=False, corner=corner)) for corner in (False, True))
    # A second pair that enters at the first one's penetration doubles the force before anything can move.
    assert abrupt.settled.maximum == pytest.approx(2 * abrupt.static, rel=0.02)
    assert abrupt.settled.minimum == pytest.approx(abrupt.static / 2, rel=0.02)
    assert smooth.settled.maximum < 1.01 * smooth.static


def test_start_up_impact_grows_with_the_clearance_to_close(train: GearTrain) -> None:
    peaks = [start_up(train, CONDITIONS[n]).force.max() for n in (4, 5, 6)]
    apart = [start_up(train, CONDITIONS[n], Assumptions(apart=True)).force.max() for n in (5, 6)]
    assert peaks[0] < peaks[1] < peaks[2]
    assert peaks[1] < apart[0]
    assert peaks[2] < apart[1]


def test_a_load_that_rises_within_a_millisecond_makes_no_impact(short_run: Runner) -> None:
    run = short_run(6, Assumptions(load_ramp=1e-3))
    assert run.start.maximum < 1.1 * run.static


def test_a_penetration_depth_in_millimetres_is_out_of_the_question(train: GearTrain) -> None:
    # Table 4's largest force is 2.1e4 N; full damping from 0.1 µm on stops 1 m/s within nanoseconds.
    run = run_condition(
        train, CONDITIONS[6], Assumptions(depth=1e-7), duration=2e-4, settled_from=1e-4, sample_rate=1e6
    )
    assert run.start.maximum > 2e5


def test_eccentricity_without_backlash_jams_the_linear_contact_and_not_the_soft_one(short_run: Runner) -> None:
    linear, hertz = (short_run(3, Assumptions(reading=reading)) for reading in ("linear", "hertz"))
    settled = linear.history.time >= linear.settled_from
    # 2·40 µm·sin 20° is 27 µm: more than 12.5 µm of penetration under the load, less than twice 34 µm (two pairs).
    assert linear.history.back_force[settled].max() > 0.5 * linear.static
    assert hertz.history.back_force[settled].max() == 0


def test_golden_values_of_condition_6(short_run: Runner) -> None:
    run = short_run(6)
    # To the integrator's tolerance: its peaks are said to be right to 0.1 %, settled forces follow from statics.
    assert run.start.maximum == pytest.approx(GOLDEN_PEAK, rel=1e-3)
    assert run.sampled.mean == pytest.approx(GOLDEN_MEAN, rel=1e-4)
    assert run.sampled.deviation == pytest.approx(GOLDEN_DEVIATION, rel=1e-2)


def test_samples_and_steps_agree_on_a_settled_force(short_run: Runner) -> None:
    run = short_run(6)
    assert run.sampled.mean == pytest.approx(run.settled.mean, rel=1e-3)
    assert run.settled.minimum <= run.sampled.minimum
    assert run.sampled.maximum <= run.settled.maximum
    assert run.peak == run.start.maximum
    assert run.sampled_whole.minimum == 0.0
    assert len(run.history.time) == 1101


def test_standstill_holds_the_load(train: GearTrain, short_run: Runner) -> None:
    run = short_run(6, speed=0.0)
    assert run.mesh_period == inf
    assert run.settled.mean == pytest.approx(run.static, rel=1e-6)  # 0.2 s are many times what damping needs


def test_tolerance_hardly_moves_the_result(train: GearTrain) -> None:
    coarse, fine = (
        run_condition(train, CONDITIONS[6], duration=0.4, settled_from=0.2, tolerance=t) for t in (1e-5, 1e-6)
    )
    # What TOLERANCE says.
    assert coarse.peak == pytest.approx(fine.peak, rel=1e-3)
    assert coarse.sampled.mean == pytest.approx(fine.sampled.mean, rel=1e-4)


def test_conditions_1_and_4_are_the_same_run_and_progress_is_told(train: GearTrain) -> None:
    told: list[int] = []
    runs = run_conditions(train, (1, 4), progress=told.append)
    assert told == [1, 4]
    assert np.array_equal(runs[1].history.force, runs[4].history.force)
    assert len(runs[1].history.time) == 5001


def test_statistics_are_those_of_a_sine() -> None:
    force = 5.0 + 3.0 * np.sin(2 * np.pi * np.arange(1000) / 1000)
    found = Statistics.of(force)
    assert (found.minimum, found.maximum) == pytest.approx((2.0, 8.0), rel=1e-12)
    assert (found.mean, found.rms) == pytest.approx((5.0, sqrt(25 + 4.5)), rel=1e-12)
    assert found.deviation == pytest.approx(3 / sqrt(2), rel=1e-12)
    assert Statistics.of(np.array([0.0, 1.0, 0.0, 3.0])).contact_loss == 0.5


def test_statistics_of_nothing_are_refused() -> None:
    with pytest.raises(ValueError, match="no force samples"):
        Statistics.of(np.empty(0))


def test_natural_frequency_is_that_of_a_mass_on_the_tangent(train: GearTrain) -> None:
    contact, _ = contacts(train, Assumptions(reading="linear"))
    assert contact_frequency(contact, 0.09) == pytest.approx(sqrt(4.529e8 / 0.09), rel=1e-12)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"duration": 0.5, "settled_from": 0.5}, "settled_from < duration"),
        ({"duration": nan}, "settled_from < duration"),
        ({"settled_from": 0.0}, "settled_from < duration"),
        ({"sample_rate": 0.0}, "no samples"),
        ({"duration": 0.5, "settled_from": 0.4, "sample_rate": 2.0}, "No sample falls between"),
        ({"tolerance": 0.0}, "tolerance is"),
        ({"tolerance": nan}, "tolerance is"),
    ],
)
def test_runs_that_are_none_are_refused(train: GearTrain, options: dict[str, float], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        run_condition(train, CONDITIONS[4], None, **options)


@pytest.mark.parametrize("changes", [{"load": nan}, {"speed": -1.0}, {"eccentricity": inf}])
def test_impossible_conditions_are_refused(short_run: Runner, changes: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="finite numbers of at least 0"):
        short_run(6, **changes)


def test_conditions_that_table_3_does_not_have_are_a_key_error(train: GearTrain) -> None:
    with pytest.raises(KeyError):
        run_conditions(train, (12,))
