"""Changes of contact: where they are found, and that none is missed, invented or repeated for ever."""

from dataclasses import replace
from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.motion.integrators import EventLocating, StepRefusedError, integrate_time

Array = NDArray[np.float64]
METHODS = {
    "tolerance": EventLocating(tolerance=1e-12),
    "fine fourth order": EventLocating(step=0.02, order=4),
    "coarse fifth order": EventLocating(step=0.3),
}


def flying(first: float, second: float) -> Array:
    """Return the state in the middle of both backlashes with δ′ of each mesh as given."""
    state = np.zeros(24)
    state[[14, 20]] = first, second  # u1′ and u3′ close their meshes one to one
    return state


def closed_form(speed: float, swing: float, end: float) -> list[float]:
    """Return when δ of a `floating` mesh, at speed from the middle, meets and leaves its flanks, before `end`."""
    flight, contact = 1 / speed, pi / swing
    times = [flight]
    while times[-1] < end:
        times += [times[-1] + contact, times[-1] + contact + 2 * flight]
    return [t for t in times if t < end]


@pytest.mark.parametrize("method", METHODS.values(), ids=list(METHODS))
@pytest.mark.parametrize(("first", "second"), [(0.7, 0.31), (5.0, 2.0)])
def test_changes_are_where_flight_and_swing_put_them(
    floating: System, swing: Array, method: EventLocating, first: float, second: float
) -> None:
    found = integrate_time(floating, (0.0, 30.0), flying(first, second), method=method).changes
    # Flight is exact in any step. With z = Ω·h the fourth order turns z⁵/120 short in a step, π·z⁴/120 in the half turn
    # of a contact, and the fifth order less than π·z⁵/120; twice that is allowed.
    z = float(swing.max()) * (method.step or 0.1)
    per_contact = 1e-10 if method.step is None else pi * z**method.order / 60
    for j, speed in enumerate((first, second)):
        own = found.meshes == j
        expected = closed_form(speed, float(swing[j]), 30.0)
        assert len(expected) > 4
        assert found.times[own] == pytest.approx(expected, abs=per_contact * len(expected))
        sides = [0] + [side for n in range(len(expected)) for side in ((1, 0, -1, 0)[n % 4],)]
        assert found.before[own].tolist() == sides[:-1]
        assert found.after[own].tolist() == sides[1:]
        assert np.abs(found.rates[own]) == pytest.approx([speed] * len(expected), rel=per_contact * 100 + 1e-9)


def test_several_changes_in_one_step_are_all_found(floating: System) -> None:
    # At a speed of 40 the backlash of 2 is crossed in 0.05: a step of 0.5 would pass several flanks.
    coarse = integrate_time(floating, (0.0, 6.0), flying(40.0, 1.0), method=EventLocating(step=0.5))
    fine = integrate_time(floating, (0.0, 6.0), flying(40.0, 1.0), method=EventLocating(tolerance=1e-12))
    assert coarse.changes.after.tolist() == fine.changes.after.tolist()
    assert coarse.counts.steps < 12 + 2 * coarse.counts.events
    assert coarse.counts.events > 4


def test_both_meshes_may_change_at_the_same_time(floating: System) -> None:
    found = integrate_time(floating, (0.0, 2.5), flying(0.5, 0.5)).changes
    assert sorted(found.meshes[:2].tolist()) == [0, 1]
    assert found.times[:2] == pytest.approx([2.0, 2.0], abs=1e-12)
    assert found.after[:2].tolist() == [1, 1]


@pytest.mark.parametrize("step", [None, 0.7, 0.25])
@pytest.mark.parametrize(("over", "changes"), [(1e-7, 2), (1e-4, 2), (-1e-7, 0), (0.0, 0)])
def test_grazing_is_told_from_passing(floating: System, step: float | None, over: float, changes: int) -> None:
    # Under a small negative load δ flies on a parabola, whose top is put `over` beyond the flank.
    system = floating.at(load=-30.0)
    drive = system.coefficients.drive * system.operating_point.load
    braking = -float((system.coefficients.direction * drive)[:6].sum())
    speed = sqrt(2 * braking * (1 + over))
    top = speed / braking
    run = integrate_time(system, (0.0, 1.5 * top), flying(speed, 0.0), method=EventLocating(step=step))
    own = run.changes.meshes == 0
    assert own.sum() == changes
    if changes:
        # δ passes 1 at the roots of the parabola; in contact the flank alters it by κ·over, a part `over` of it.
        apart = sqrt(2 * over / braking)
        assert run.changes.times[own] == pytest.approx([top - apart, top + apart], rel=5 * sqrt(over))
        assert run.changes.after[own].tolist() == [1, 0]
    delta, _ = system.deflections(run.times[-1], run.state)
    flown = speed * run.times[-1] - braking * run.times[-1] ** 2 / 2
    assert delta[0] == pytest.approx(flown, abs=1e-10 + 10 * abs(over))


def test_rest_on_a_boundary_is_no_chatter(floating: System) -> None:
    state = np.zeros(24)
    state[[2, 8]] = 1.0, -1.0
    run = integrate_time(floating, (0.0, 50.0), state)
    assert run.counts.events == 0
    assert run.state.tolist() == state.tolist()


def test_contact_that_changes_too_often_is_refused_in_a_sentence(floating: System) -> None:
    method = EventLocating(closest=100.0, most_close=3)
    with pytest.raises(StepRefusedError, match=r"Contact chatters at tau .* raise most_close"):
        integrate_time(floating, (0.0, 30.0), flying(5.0, 2.0), method=method)


def test_without_backlash_a_flank_passes_into_the_other_and_the_motion_is_a_swing(
    floating: System, swing: Array
) -> None:
    train = floating.train.with_mesh(0, backlash=0.0)
    run = integrate_time(replace(floating, train=train), (0.0, 10.0), flying(0.5, 0.1))
    own = run.changes.meshes == 0
    assert run.changes.times[own] == pytest.approx(pi / swing[0] * np.arange(1, own.sum() + 1), abs=1e-8)
    assert run.changes.before[own].tolist() == [(-1) ** n for n in range(own.sum())]
    assert run.changes.after[own].tolist() == [-((-1) ** n) for n in range(own.sum())]
    # 1e-9 of error a step is allowed, over some 20 steps.
    assert run.contact_share()[0] == 1


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.4, 1.3, -0.8]), st.sampled_from([20.0, 100.0, -60.0]))
def test_branches_are_where_delta_is_and_changes_lie_on_the_flanks(
    train: GearTrain, seed: int, frequency: float, load: float
) -> None:
    system = System(train).at(frequency=frequency, load=load)
    state = np.random.default_rng(seed).normal(0, 0.7, 24)
    run = integrate_time(system, (0.0, 25.0), state)
    for j in range(2):
        own = run.changes.meshes == j
        chain = [run.contact[j], *run.changes.after[own]]
        assert chain[:-1] == run.changes.before[own].tolist()
        marks = [0.0, *run.changes.times[own], 25.0]
        for side, (begin, end) in zip(chain, pairwise(marks), strict=True):
            for tau, at in zip(run.times, run.states, strict=True):
                if begin + 1e-9 < tau < end - 1e-9:
                    delta = system.deflections(tau, at)[0][j]
                    assert int(delta > 1) - int(delta < -1) == side
        for tau in run.changes.times[own]:
            at = run.states[np.searchsorted(run.times, tau)]
            # The resolution of δ is 2e-14 of the size of its terms, which is some tens at most.
            assert abs(abs(system.deflections(tau, at)[0][j]) - 1) < 1e-11


def test_even_steps_stay_on_their_grid_whatever_was_cut(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=60.0)
    run = integrate_time(system, (3.0, 43.0), system.static_state(), method=EventLocating(step=0.25))
    assert run.counts.events > 5
    grid = 3.0 + 0.25 * np.arange(161)
    assert np.abs(run.times[:, None] - grid).min(axis=0).max() < 1e-12
    assert len(run.times) == 161 + len(np.unique(run.changes.times))


def test_a_tolerance_that_no_step_meets_is_refused_in_a_sentence(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=60.0)
    with pytest.raises(StepRefusedError, match=r"No step down to the smallest allowed met the tolerance at tau"):
        integrate_time(
            system, (0.0, 10.0), system.static_state(), method=EventLocating(tolerance=1e-13, smallest_step=0.05)
        )


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"tolerance": 0.0}, "The tolerance is 0.0, expected a finite number above 0"),
        ({"tolerance": 1e-17}, "The tolerance is 1e-17, below what rounding allows, 1e-14"),
        ({"step": float("nan")}, "The step is nan"),
        ({"longest_step": -1.0}, "The longest_step is -1.0"),
        ({"order": 4}, "The order is 4 with step None, expected 5, or 4 with a step"),
        ({"order": 3, "step": 0.1}, "The order is 3"),
    ],
)
def test_impossible_options_are_refused(options: dict[str, float], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        EventLocating(**options)  # type: ignore[arg-type]


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.4, 1.3, -0.8]), st.sampled_from([20.0, 100.0, -60.0]))
def test_long_steps_miss_no_change_that_short_ones_find(
    train: GearTrain, seed: int, frequency: float, load: float
) -> None:
    # Long steps of a fine method and short ones of a coarser one: the search alone could make their changes differ.
    system = System(train).at(frequency=frequency, load=load)
    state = np.random.default_rng(seed).normal(0, 0.7, 24)
    longer = integrate_time(system, (0.0, 25.0), state, method=EventLocating(tolerance=1e-8)).changes
    shorter = integrate_time(system, (0.0, 25.0), state, method=EventLocating(step=0.01)).changes
    # A flank that is passed by less than what the tolerance leaves is grazed by the one and missed by the other.
    if np.abs(shorter.rates).min(initial=1.0) > 1e-3 and np.abs(longer.rates).min(initial=1.0) > 1e-3:
        assert longer.meshes.tolist() == shorter.meshes.tolist()
        assert longer.after.tolist() == shorter.after.tolist()
        assert longer.times == pytest.approx(shorter.times, abs=1e-3)
