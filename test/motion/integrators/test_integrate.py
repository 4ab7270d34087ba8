"""The one call: results, records, and what it refuses."""

from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.motion.integrators import METHODS, EventLocating, FixedStep, StepHalving, integrate_time
from seat_gear_dynamics.motion.march import DivergedError

Array = NDArray[np.float64]


def test_all_integrators_and_dop853_agree_across_impacts(variant: GearTrain) -> None:
    system = System(variant).at(frequency=0.9, load=100.0)
    span, start = (0.0, 14.0), system.static_state()
    outside = solve_ivp(system.derivative, span, start, method="DOP853", rtol=1e-10, atol=1e-12, max_step=0.05).y[:, -1]
    # DOP853 is blind to changes of contact: its own step control has to find them. A jump of the force leaves more.
    jumps = variant.variant.damping_in_contact_only
    assert integrate_time(system, span, start).state == pytest.approx(outside, abs=1e-6 if jumps else 1e-7)
    # Halving stops at a jump only where h times the jump is below the tolerance.
    halving = integrate_time(system, span, start, method=StepHalving(tolerance=1e-10, smallest_step=1e-13))
    assert halving.state == pytest.approx(outside, abs=1e-6 if jumps else 1e-7)
    # At first order, h times the jumps that c·δ′ makes at some ten changes of contact; at second order, its square.
    fixed = integrate_time(system, span, start, method=FixedStep(0.002))
    assert fixed.state == pytest.approx(outside, abs=5e-3 if jumps else 1e-5)


def test_a_named_method_is_that_method_with_its_default_options(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=60.0)
    for name, method in METHODS.items():
        by_name = integrate_time(system, (0.0, 5.0), system.static_state(), method=name)
        assert np.array_equal(
            by_name.states, integrate_time(system, (0.0, 5.0), system.static_state(), method=method()).states
        )


@pytest.mark.parametrize("method", [FixedStep(0.002), StepHalving(step=0.002), EventLocating(step=0.002)])
def test_records_are_whole_however_many_there_are_and_the_ends_are_the_same_without(
    train: GearTrain, method: FixedStep
) -> None:
    # 10000 steps are more than the room that one pass of the compiled loop has for them.
    system = System(train).at(frequency=0.9, load=60.0)
    whole = integrate_time(system, (1.0, 21.0), system.static_state(), method=method)
    ends = integrate_time(system, (1.0, 21.0), system.static_state(), method=method, every_step=False)
    assert len(whole.times) == whole.counts.steps + 1 > 10000
    assert np.all(np.diff(whole.times) > 0)
    assert (whole.times[0], whole.times[-1]) == (1.0, 21.0)
    assert ends.times.tolist() == [1.0, 21.0]
    assert np.array_equal(ends.states, whole.states[[0, -1]])
    assert ends.counts == whole.counts
    assert np.array_equal(ends.changes.times, whole.changes.times)


@pytest.mark.parametrize("cut", [3.3, 10.0])
def test_a_span_may_be_cut_anywhere(train: GearTrain, cut: float) -> None:
    system, method = System(train).at(frequency=0.9, load=60.0), EventLocating(tolerance=1e-12)
    whole = integrate_time(system, (0.0, 20.0), system.static_state(), method=method)
    first = integrate_time(system, (0.0, cut), system.static_state(), method=method)
    second = integrate_time(system, (cut, 20.0), first.state, method=method)
    assert second.state == pytest.approx(whole.state, abs=1e-9)  # 1e-12 a step, over some thousand steps
    assert len(first.changes) + len(second.changes) == len(whole.changes)


def test_contact_share_is_that_of_the_changes(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=60.0)
    run = integrate_time(system, (0.0, 40.0), system.static_state(), method=EventLocating(step=0.01))
    even = integrate_time(system, (0.0, 40.0), system.static_state(), method=FixedStep(0.01))
    touching = np.array([np.abs(system.deflections(t, y)[0]) > 1 for t, y in zip(even.times, even.states, strict=True)])
    # Counted in steps of 0.01 of 40, each change is off by up to one step.
    assert run.contact_share() == pytest.approx(touching.mean(axis=0), abs=0.01 / 40 * len(run.changes))
    assert np.all((run.contact_share() > 0.05) & (run.contact_share() < 0.95))


def test_a_motion_across_impacts_keeps_its_golden_value(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=60.0)
    run = integrate_time(system, (0.0, 10 * pi), system.static_state(), method=EventLocating(tolerance=1e-12))
    assert len(run.changes) == 17
    # Two tolerances and 6284 equal steps agree to 1e-9; a digit to spare for other machines.
    golden = [0.0797105927, 0.7921857201, 0.7939820787, -0.0465128202]
    assert run.state[[0, 2, 5, 14]] == pytest.approx(golden, abs=1e-8)


def test_frequency_zero_stands_still_and_a_negative_one_turns_back(train: GearTrain) -> None:
    for frequency in (0.0, -0.7):
        system = System(train).at(frequency=frequency, load=60.0)
        outside = solve_ivp(
            system.derivative, (0, 8), system.static_state(), method="DOP853", rtol=1e-10, atol=1e-12, max_step=0.05
        )
        assert integrate_time(system, (0, 8), system.static_state()).state == pytest.approx(outside.y[:, -1], abs=1e-7)


def test_a_diverging_motion_is_an_error_in_a_sentence(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=60.0)
    with pytest.raises(DivergedError, match=r"The motion diverged at tau .* frequency 0\.9 and load 60 N·m"):
        integrate_time(system, (0.0, 1e4), system.static_state(), method=FixedStep(10.0))


@pytest.mark.parametrize("method", ["runge-kutta", "step-halving", "event-locating"])
@pytest.mark.parametrize("size", [1e200, 1e300])
def test_a_state_beyond_every_bound_is_an_error_and_no_endless_loop(train: GearTrain, method: str, size: float) -> None:
    with pytest.raises(ArithmeticError, match="at tau"):
        integrate_time(System(train), (0.0, 10.0), np.full(24, size) * np.resize([1, -2, 3], 24), method=method)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"span": (1.0, 1.0)}, r"The span is from 1\.0 to 1\.0, expected two finite times, the second one later"),
        ({"span": (0.0, float("inf"))}, "The span is from 0.0 to inf"),
        ({"state": np.zeros(12)}, r"The state has shape \(12,\), expected \(24,\)"),
        ({"state": np.full(24, np.nan)}, "The state holds 24 values that are no finite numbers"),
        ({"tangent": np.zeros((3, 24))}, r"The tangent has shape \(3, 24\), expected \(24, 24\)"),
        ({"tangent": np.full((24, 2), np.inf)}, "The tangent holds 48 values"),
        ({"method": "euler"}, "The method is 'euler', expected one of runge-kutta, step-halving, event-locating"),
    ],
)
def test_impossible_arguments_are_refused_in_a_sentence(
    train: GearTrain, arguments: dict[str, object], sentence: str
) -> None:
    given = {"span": (0.0, 1.0), "state": np.zeros(24)} | arguments
    span, state = given.pop("span"), given.pop("state")
    with pytest.raises(ValueError, match=sentence):
        integrate_time(System(train), span, state, **given)  # type: ignore[arg-type]
