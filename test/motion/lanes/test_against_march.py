"""Lanes against `motion.integrate` and against SciPy: the same steps of the same equations, rounding apart."""

from collections.abc import Callable
from dataclasses import astuple, replace
from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from seat_gear_dynamics.gears import GearTrain, Variant
from seat_gear_dynamics.motion import Inputs, March, Response, System, integrate
from seat_gear_dynamics.motion.lanes import LanePoints, LaneResponse, respond_lanes, respond_trains
from seat_gear_dynamics.motion.lanes.reduction import expand_state, reduce_state, reduced

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]

SHAFT = 2.6e4
FREQUENCY, LOAD = np.array([0.5, 0.3, 0.9, -0.7, 0.06]), np.array([600.0, 200.0, 40.0, 100.0, -300.0])


def assert_same_motion(lanes: LaneResponse, lane: int, expected: Response, tolerance: float = 1e-9) -> None:
    """Hold one lane against the march's response at its point.

    The tolerance is 1e-9 of numbers of order 1. The steps are the same but for rounding, of 1e-16 a step, which
    grows in a run by the sensitivity of a static deflection of some hundred b_c on soft torsional supports.
    """
    assert not lanes.diverged[lane]
    assert lanes.section[lane] == pytest.approx(expected.section, rel=tolerance, abs=tolerance)
    meshes = lanes.windows.shape[1]
    for mesh in range(meshes):
        window = np.array(astuple(expected.windows[mesh]))
        assert lanes.windows[lane, mesh] == pytest.approx(window, rel=tolerance, abs=tolerance)
    own = slice(0, 6 * meshes)
    for half in (slice(0, 12), slice(12, 24)):
        assert lanes.state[lane, half][own] == pytest.approx(expected.state[half][own], rel=tolerance, abs=tolerance)


@pytest.mark.parametrize("shaft", [0.0, SHAFT])
def test_lanes_are_the_march_at_every_point(train: GearTrain, shaft: float) -> None:
    kind = train.with_shaft(shaft)
    lanes = respond_lanes(kind, FREQUENCY, LOAD, transient=15, periods=8)
    assert lanes.section.shape == (5, 8, 2)
    assert lanes.windows.shape == (5, 2 if shaft else 1, 6)
    for lane, (frequency, load) in enumerate(zip(FREQUENCY, LOAD, strict=True)):
        system = System(kind).at(frequency=float(frequency), load=float(load))
        assert_same_motion(lanes, lane, integrate(system, transient=15, periods=8))
    assert (lanes.windows[:, 0, 5] > 0).any(), "no lane shows contact loss"
    assert (lanes.windows[:, 0, 5] == 0).any(), "no lane stays in contact"


def test_the_whole_of_a_decoupled_train_can_be_asked_for(train: GearTrain) -> None:
    lanes = respond_lanes(train, FREQUENCY, LOAD, transient=0, periods=7, meshes=2)
    pair = respond_lanes(train, FREQUENCY, LOAD, transient=0, periods=7)
    for lane, (frequency, load) in enumerate(zip(FREQUENCY, LOAD, strict=True)):
        system = System(train).at(frequency=float(frequency), load=float(load))
        assert_same_motion(lanes, lane, integrate(system, transient=0, periods=7))
    assert lanes.growth == pytest.approx(pair.growth, rel=1e-9, abs=1e-9)


def test_a_printed_coupled_eccentric_train_damped_in_contact_only_is_the_march(make_train: MakeTrain) -> None:
    described = make_train({"gears.*.eccentricity": 5, "gears.s3.eccentricity_phase": 2.0}).with_shaft(SHAFT)
    train = replace(described, variant=Variant(backlash_in_torsion=False, damping_in_contact_only=True))
    lanes = respond_lanes(train, FREQUENCY, LOAD, transient=0, periods=13)
    for lane, (frequency, load) in enumerate(zip(FREQUENCY, LOAD, strict=True)):
        system = System(train).at(frequency=float(frequency), load=float(load))
        assert_same_motion(lanes, lane, integrate(system, transient=0, periods=13), tolerance=1e-8)


def test_damping_and_backlash_of_a_lane_are_those_of_both_meshes(train: GearTrain) -> None:
    kind, ratio, backlash = train.with_shaft(SHAFT), np.array([0.03, 0.13]), np.array([50e-6, 0.0])
    lanes = respond_lanes(kind, 0.6, 300.0, damping_ratio=ratio, backlash=backlash, transient=6, periods=4)
    for lane in range(2):
        own = kind
        for mesh in range(2):
            own = own.with_mesh(mesh, damping_ratio=float(ratio[lane]), backlash=float(backlash[lane]))
        system = System(own).at(frequency=0.6, load=300.0)
        assert_same_motion(lanes, lane, integrate(system, transient=6, periods=4))


@pytest.mark.parametrize("steps", [200, 1000])
def test_the_number_of_steps_is_that_of_the_march(train: GearTrain, steps: int) -> None:
    lanes = respond_lanes(train, [1.1, 0.02], 500.0, transient=1, periods=2, target_steps=steps)
    for lane, frequency in enumerate((1.1, 0.02)):
        system = System(train).at(frequency=frequency, load=500.0)
        assert_same_motion(lanes, lane, integrate(system, transient=1, periods=2, target_steps=steps))


def test_a_given_state_is_started_from_and_the_final_state_goes_on(train: GearTrain) -> None:
    start = expand_state(np.random.default_rng(2).normal(size=(1, 16)), reduced(train).line)
    whole = respond_lanes(train, 0.5, 600.0, state=start, transient=0, periods=8)
    expected = integrate(System(train).at(frequency=0.5, load=600.0), transient=0, periods=8, state=start[0])
    assert_same_motion(whole, 0, expected)
    first = respond_lanes(train, 0.5, 600.0, state=start, transient=0, periods=5)
    second = respond_lanes(train, 0.5, 600.0, state=first.state, transient=0, periods=3)
    assert second.section[0] == pytest.approx(whole.section[0, 5:], rel=1e-9, abs=1e-9)
    assert first.state[:, [6, 7, 8, 9, 10, 11]] == pytest.approx(start[:, 6:12], abs=1e-14)  # P34 was left out


@pytest.mark.parametrize("shaft", [0.0, SHAFT])
def test_the_tangent_grows_as_that_of_the_march(train: GearTrain, shaft: float) -> None:
    # Both start the same tangent; the march's is rid of its part across the line of action, which lanes leave out.
    kind, load = train.with_shaft(shaft), 20.0
    march, inputs, sections = March(kind, load=load), Inputs(1.0, load), list[Array]()
    line = reduced(kind).line
    march._z = expand_state(reduce_state(march._z[None], line), line)[0]
    march.advance((0.0, inputs), ((12 - 1e-4) * 2 * pi, inputs), sections.append)
    lanes = respond_lanes(kind, 1.0, load, transient=0, periods=12)
    growth = np.concatenate(sections)[:, 3]
    assert lanes.growth[0] == pytest.approx(growth, rel=1e-9, abs=1e-9)
    assert np.abs(growth).max() > 0.1


def test_a_rattling_tangent_finds_the_exponent_of_the_march(train: GearTrain) -> None:
    # Chaotic motions part after some tens of periods, so only their mean growth can agree: two independent samples
    # of 300 periods, of a spread within a motion that the standard errors say.
    expected = integrate(System(train).at(frequency=1.0, load=20.0), transient=60, periods=300).growth[:, 0]
    lanes = respond_lanes(train, 1.0, np.full(16, 20.0) + np.arange(16) * 1e-9, transient=60, periods=300)
    error = np.sqrt(expected.var() / 300 * 10 + lanes.growth.mean(axis=1).var())  # tens of periods remember each other
    assert expected.mean() > 0.2
    assert abs(lanes.growth.mean() - expected.mean()) < 4 * error


def test_lanes_are_scipys_solution_within_the_step_error(train: GearTrain) -> None:
    system = System(train).at(frequency=0.5, load=600.0)
    periods, fine = 3, 2048
    lanes = respond_lanes(train, 0.5, 600.0, transient=0, periods=periods, target_steps=fine)
    end = periods * 2 * pi / 0.5
    exact = solve_ivp(system.derivative, (0.0, end), system.static_state(), method="DOP853", rtol=1e-11, atol=1e-12)
    coarse = respond_lanes(train, 0.5, 600.0, transient=0, periods=periods, target_steps=fine // 2)
    step_error = np.abs(coarse.state - lanes.state)[0, :6].max()  # more than the finer run's own by far
    assert 0 < np.abs(lanes.state[0, :6] - exact.y[:6, -1]).max() < step_error


def test_several_trains_answer_each_for_itself(make_train: MakeTrain) -> None:
    soft = make_train({"gears.s1.support_stiffness": 1e7, "model.load_scale": 0.02})  # the same excitation
    loud = make_train({"meshes.*.error_amplitude": [2.0, 0.1]})  # another one
    coupled = make_train().with_shaft(SHAFT)
    trains = [make_train(), soft, loud, coupled, make_train()]
    asked = [(t, LanePoints([0.5, 0.8 + 0.1 * n], 300.0 + n)) for n, t in enumerate(trains)]
    together = respond_trains(asked, transient=5, periods=3)
    for (train, points), found in zip(asked, together, strict=True):
        alone = respond_lanes(train, points.frequency, points.load, transient=5, periods=3)
        assert alone.section.tobytes() == found.section.tobytes()
        assert alone.windows.tobytes() == found.windows.tobytes()
        assert alone.state.tobytes() == found.state.tobytes()
    for train, found in zip(trains[:3], together, strict=False):
        n = trains.index(train)
        system = System(train).at(frequency=0.8 + 0.1 * n, load=300.0 + n)
        assert_same_motion(found, 1, integrate(system, transient=5, periods=3))


def test_golden_section_of_a_period_1_motion(train: GearTrain) -> None:
    golden = [1.41551261981968, -0.0124722113380257]  # of motion.integrate, 300 periods run in
    found = respond_lanes(train, 0.5, 600.0, transient=300, periods=1)
    assert found.section[0, 0] == pytest.approx(golden, rel=1e-9)
