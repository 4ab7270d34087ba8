"""Response curves of the train: agreement with integration, jumps, period doubling, and what is refused."""

import csv
import io
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System, load_system
from seat_gear_dynamics.studies.harmonic_balance import (
    BIFURCATIONS,
    COLUMNS,
    CONTACT_STATES,
    ResponseCurve,
    compare,
    response_curve,
    rows,
)
from seat_gear_dynamics.studies.harmonic_balance.branch import lies_on
from seat_gear_dynamics.studies.harmonic_balance.integration import Recorded, difference, settle
from seat_gear_dynamics.studies.harmonic_balance.orbit import state_of_train
from seat_gear_dynamics.studies.harmonic_balance.response_curve import _overlaps
from seat_gear_dynamics.studies.harmonic_balance.tracing import Range

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]


def test_harmonic_balance_equals_integration_at_20_frequencies(curve: ResponseCurve) -> None:
    agreements = compare(curve, [float(f) for f in np.linspace(0.21, 0.83, 20)], directions=["up"], transient=300)
    assert len(agreements) == 20
    assert all(a.comparable for a in agreements)
    assert sum(a.motion is not None and a.motion.contact_state == "one-sided" for a in agreements) >= 10
    # The promise of 1e-4; truncation at 32 harmonics costs about 3e-5, steps of a 1088th of a period less.
    assert max(a.difference for a in agreements if a.difference is not None) < 1e-4


def test_up_and_down_differ_between_the_folds_alone(curve: ResponseCurve) -> None:
    (_, _), (low, high) = curve.coexistence()
    around = [low - 0.01, (low + high) / 2, high + 0.01]
    agreements = {(a.value, a.direction): a for a in compare(curve, around, transient=300, target_steps=272)}
    sizes = [[agreements[v, way].motion.rms for v in around] for way in ("up", "down")]  # type: ignore[union-attr]
    assert sizes[0][0] == pytest.approx(sizes[1][0])
    assert sizes[0][2] == pytest.approx(sizes[1][2])
    assert sizes[0][1] < 0.7 * sizes[1][1]
    assert len(curve.stable_at(around[1])) == 2
    assert len(curve.motions_at(around[1])) == 3


def test_more_harmonics_come_nearer_to_integration(light: System) -> None:
    at = light.at(frequency=0.6)
    found = [response_curve(light, 0.599, 0.601, harmonics=h).stable_at(0.6) for h in (8, 16, 32)]
    start = state_of_train(found[-1][0].orbit, at.static_state())
    recorded = settle(at, periods=1, transient=300, state=start)
    errors = [difference(recorded, motion.orbit) for (motion,) in found]
    # Harmonics of a motion whose third derivative jumps fall with the fourth power; their sum with the third.
    assert errors[0] / errors[1] > 4
    assert errors[1] / errors[2] > 4


def test_folds_of_the_fixed_train(curve: ResponseCurve) -> None:
    # Golden, 32 harmonics at 100 N·m; 64 harmonics give the same to 2e-5.
    assert [f.parameter for f in curve.folds] == pytest.approx([0.43861, 0.43124, 0.75275, 0.68870], abs=3e-5)
    assert all(abs(f.multiplier - 1) < 0.01 for f in curve.folds)


def test_stability_changes_only_at_the_bifurcations(curve: ResponseCurve) -> None:
    (branch,) = curve.branches
    events = {id(b.motion) for b in branch.bifurcations}
    counts = [(m.unstable, id(m) in events) for m in branch.motions]
    for (before, marked_before), (after, marked_after) in pairwise(counts):
        assert before == after or marked_before or marked_after
    assert {b.kind for b in branch.bifurcations} <= set(BIFURCATIONS)
    assert [b.kind for b in branch.bifurcations].count("period doubling") == 1


@pytest.fixture(scope="module")
def doubled(light: System) -> ResponseCurve:
    return response_curve(light, 0.81, 0.92, harmonics=24, subharmonics=2, starts=0)


def test_a_doubled_branch_is_followed_and_integration_is_on_it(doubled: ResponseCurve) -> None:
    single, double = doubled.branches
    (event,) = single.bifurcations
    assert (event.kind, double.subharmonics) == ("period doubling", 2)
    assert double.motions[0].parameter == pytest.approx(event.parameter, abs=2e-3)
    found = compare(doubled, [0.82, 0.9], transient=400, target_steps=544)
    assert [(a.period, a.comparable) for a in found] == [(1, True), (2, True), (2, True), (1, True)]
    assert max(a.difference for a in found if a.difference is not None) < 3e-4  # 24 harmonics, half the steps
    assert 0 < max(m.subharmonic for m in double.motions) < 1
    assert not any(m.subharmonic for m in single.motions)


def test_integration_leads_to_branches_that_are_sought(light: System) -> None:
    # Within the doubled range alone no doubling is met; one integration finds the branch, followed both ways.
    curve = response_curve(light, 0.88, 0.92, harmonics=12, subharmonics=2, starts=1)
    single, double = curve.branches
    assert not single.bifurcations
    assert (double.subharmonics, double.ended) == (2, "range")
    assert sorted((double.parameters[0], double.parameters[-1])) == [0.88, 0.92]
    assert np.all(np.diff(double.parameters) > 0)


def test_a_motion_lies_on_its_branch_whichever_period_it_begins_in(doubled: ResponseCurve) -> None:
    double = doubled.branches[1]
    point = double.motions[len(double.motions) // 2].point
    basis = double.balance.basis
    shifted = basis.coefficients(np.roll(basis.values(point.unknowns), basis.samples // 2))
    moved = type(point)(shifted, point.parameter, point.tangent)
    other = type(point)(2 * point.unknowns, point.parameter, point.tangent)
    assert lies_on(double, moved)
    assert not lies_on(double, other)


@pytest.mark.parametrize(
    ("parameter", "low", "high"), [("load", 60.0, 900.0), ("damping_ratio", 0.03, 0.3), ("backlash", 0.0, 3e-5)]
)
def test_other_parameters_meet_the_frequency_curve(
    light: System, curve: ResponseCurve, parameter: str, low: float, high: float
) -> None:
    over = response_curve(light.at(frequency=0.6), low, high, parameter=parameter)
    usual = {"load": 100.0, "damping_ratio": 0.07, "backlash": 2e-5}[parameter]
    here, there = over.stable_at(usual), curve.stable_at(0.6)
    assert [m.rms for m in here] == pytest.approx([m.rms for m in there], rel=1e-8)  # one equation solved twice


def test_a_branch_that_turns_back_leaves_the_other_end_to_another(light: System) -> None:
    # At little damping a large motion is met first, whose branch turns back where damping takes more than it gets.
    over = response_curve(light.at(frequency=0.72), 0.005, 0.3, parameter="damping_ratio", harmonics=16)
    low, high = over.branches
    assert (low.parameters[0], low.parameters[-1]) == (0.005, 0.005)
    assert high.parameters[0] == 0.3
    assert 0.005 < low.parameters.max() < 0.3
    assert len(over.motions_at(0.2)) == 1


def test_heavier_damping_makes_smaller_motions(light: System) -> None:
    over = response_curve(light.at(frequency=0.9, load=600.0), 0.03, 0.3, parameter="damping_ratio")
    assert np.all(np.diff([m.rms for m in over.branches[0].motions]) < 0)


def test_rows_are_what_the_columns_say(curve: ResponseCurve) -> None:
    table = rows(curve)
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS)
    writer.writeheader()
    writer.writerows(table)
    assert text.getvalue().splitlines()[0] == ",".join(COLUMNS)
    assert len(table) == len(curve.branches[0].motions)
    assert {row["contact"] for row in table} <= set(CONTACT_STATES)
    static = curve.system.train.static_forces(100.0)[0] * curve.system.train.model.load_scale
    for row in table:
        # Soft torsional supports take one part in a thousand of the load.
        assert row["force_mean"] == pytest.approx(static, rel=2e-3)
        assert row["force_min"] <= row["force_mean"] <= row["force_rms"] <= row["force_max"]  # type: ignore[operator]
        assert (row["contact_loss"] == 0) == (row["contact"] == "no loss")


def test_intervals_overlap_where_two_lie_over_each_other() -> None:
    edges = [(0.0, 1), (2.0, -1), (1.0, 1), (3.0, -1), (2.5, 1), (2.7, -1), (3.0, 1), (4.0, -1)]
    assert _overlaps(edges) == [(1.0, 2.0), (2.5, 2.7)]


def test_the_default_curve_of_the_packaged_train_is_followed_to_its_end() -> None:
    (branch,) = response_curve(load_system().at(load=600.0), 0.1, 2.01).branches
    assert branch.ended == "range"
    assert branch.parameters[-1] == 2.01


def test_ranges_and_counts_that_are_none_are_refused(light: System) -> None:
    with pytest.raises(ValueError, match="the lower one first"):
        Range(1.0, 0.5, None)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="the lower one first"):
        response_curve(light, 0.9, 0.5)
    with pytest.raises(ValueError, match="frequency is"):
        response_curve(light, 0.0, 0.5)
    with pytest.raises(ValueError, match="frequency is nan"):
        response_curve(light, float("nan"), 0.5)
    with pytest.raises(ValueError, match="expected 1 or more of both"):
        response_curve(light, 0.2, 0.5, harmonics=0)
    with pytest.raises(ValueError, match="expected one of frequency"):
        response_curve(light, 0.2, 0.5, parameter="speed")


def test_a_strange_direction_is_refused(curve: ResponseCurve) -> None:
    with pytest.raises(ValueError, match="expected one of up, down"):
        compare(curve, [0.5], directions=["sideways"])


def test_a_recording_too_short_for_the_orbit_is_refused(light: System, curve: ResponseCurve) -> None:
    (motion,) = curve.stable_at(0.6)
    with pytest.raises(ValueError, match="expected at least 1"):
        difference(Recorded(np.empty((0, 272)), np.zeros(24)), motion.orbit)
    assert np.isnan(Recorded(np.zeros((2, 272)), np.zeros(24)).repeats(2))
