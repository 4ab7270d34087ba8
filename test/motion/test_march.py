"""The march through changing inputs: cuts in time, mesh phase, standstill, creep and reversal."""

from collections.abc import Callable
from itertools import pairwise
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March, System, Window
from seat_gear_dynamics.regimes import recurrence

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]
CUTS = st.lists(st.floats(0.0, 60.0), min_size=1, max_size=12).map(sorted)
LOADED = st.sampled_from([600.0, 20.0, 0.0, -50.0])


@pytest.fixture(scope="module")
def march(train: GearTrain) -> March:
    """One march for all examples, as tables take longer to make than the motion; every use restarts it."""
    return March(train)


def through(march: March, start: Inputs, end: Inputs, cuts: list[float]) -> tuple[Array, list[Window]]:
    """March from rest through inputs linear over 0..60, cut at `cuts`; return the sections and P12's windows."""
    march.restart(start.load)
    sections: list[Array] = [np.empty((0, 5))]
    windows = []

    def at(tau: float) -> Inputs:
        share = tau / 60.0
        return Inputs(
            start.frequency + share * (end.frequency - start.frequency), start.load + share * (end.load - start.load)
        )

    times = [0.0, *cuts, 60.0]
    for a, b in pairwise(times):
        windows.append(march.advance((a, at(a)), (b, at(b)), sections.append)[0])
    return np.concatenate(sections), windows


@settings(max_examples=30)
@given(CUTS, st.sampled_from([1.3, 0.5, 0.02, 0.0, 0.001, -0.8]), LOADED)
def test_motion_at_constant_inputs_is_the_same_bit_for_bit_however_time_is_cut(
    march: March, cuts: list[float], frequency: float, load: float
) -> None:
    inputs = Inputs(frequency, load)
    whole_sections, (whole,) = through(march, inputs, inputs, [])
    state, tau = march.state.tolist(), march.tau
    cut_sections, windows = through(march, inputs, inputs, cuts)
    assert march.state.tolist() == state
    assert march.tau == tau
    assert cut_sections.tolist() == whole_sections.tolist()
    merged = Window()
    for window in windows:
        merged = merged.merged(window)
    assert (merged.minimum, merged.maximum) == (whole.minimum, whole.maximum)
    assert (merged.duration, merged.sum) == pytest.approx((whole.duration, whole.sum), rel=1e-12, abs=1e-12)


@settings(max_examples=30)
@given(CUTS, st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(300, 900))
def test_motion_at_linear_inputs_is_the_same_to_rounding_however_time_is_cut(
    march: March, cuts: list[float], first: float, last: float, load: float
) -> None:
    start, end = Inputs(first, 600.0), Inputs(last, load)
    through(march, start, end, [])
    state = march.state
    through(march, start, end, cuts)
    assert march.state == pytest.approx(state, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("load", [600.0, -50.0])
@pytest.mark.parametrize(("first", "last"), [(0.2, 1.8), (1.8, 0.01), (0.3, -0.5), (0.05, 0.0)])
def test_mesh_phase_is_the_integral_of_the_frequency_through_every_grid(
    march: March, first: float, last: float, load: float
) -> None:
    end = 600.0
    slope = (last - first) / end
    sections: list[Array] = []
    march.restart(load)
    march.advance((0.0, Inputs(first, load)), (end, Inputs(last, load)), sections.append)
    tau = np.concatenate(sections)[:, 0]
    phase = (first * tau + slope * tau**2 / 2) / (2 * pi)
    # Frequency is held over a step of at most 0.1, which loses at most slope·0.1·τ/2 of angle; creep moves the phase
    # by whole finest steps.
    bound = abs(slope) * 0.1 * tau / (4 * pi) + 2 / (64 * march.steps_per_period) + 1e-9
    assert np.all(np.abs(phase - np.round(phase)) <= bound)
    turning = (first * end + slope * end**2 / 2) / (2 * pi) if last >= 0 else first**2 / (-2 * slope) / (2 * pi)
    final = (first * end + slope * end**2 / 2) / (2 * pi)
    crossings = int(turning) + (int(turning) - int(np.floor(final)) if last < 0 else 0)
    assert abs(len(tau) - crossings) <= 1


def test_p34_repeats_after_40_periods_of_p12_and_not_before(make_train: MakeTrain) -> None:
    # Stiff, well damped shafts: the motion settles within 200 periods.
    train = make_train({"*damping_ratio": 0.3, "*.torsional_stiffness": 2e7})
    march, inputs, period = March(train, load=600.0), Inputs(1.5, 600.0), 2 * pi / 1.5
    found = []
    for n in range(1, 321):
        march.advance((march.tau, inputs), ((n - 1e-4) * period, inputs))
        found.append(march.meshes(1.5)[:, :2].reshape(4))
    record = np.array(found[200:])
    spread = float(np.ptp(record[:, 2]))
    assert recurrence(record[:, :2], 1) < 1e-9
    assert recurrence(record[:, 2:], 40) < 1e-9
    assert min(recurrence(record[:, 2:], n) for n in range(1, 40)) > 0.05 * spread > 1e-6


def settled(train: GearTrain, load: float) -> March:
    """Turn, slow down to standstill and wait."""
    march = March(train, load=load)
    march.advance((0.0, Inputs(0.7, load)), (200.0, Inputs(0.7, load)))
    march.advance((200.0, Inputs(0.7, load)), (400.0, Inputs(0.0, load)))
    march.advance((400.0, Inputs(0.0, load)), (4000.0, Inputs(0.0, load)))
    return march


@pytest.mark.parametrize("load", [600.0, -600.0, 20.0])
def test_standstill_comes_to_rest_in_the_static_balance(make_train: MakeTrain, load: float) -> None:
    train = make_train({"*.torsional_stiffness": 1e6, "*.support_damping_ratio": 0.3})
    march = settled(train, load)
    assert np.abs(march.state[12:]).max() < 1e-6
    length = train.model.displacement_scale
    forces = march.meshes(0.0)[:, 2] * march.force_unit
    for j, (mesh, static) in enumerate(zip(train.meshes, train.static_forces(load), strict=True)):
        for gear, u in zip((mesh.driver, mesh.driven), march.state[[6 * j + 2, 6 * j + 5]], strict=True):
            carried = gear.torsional_stiffness * u * length
            assert forces[j] + carried == pytest.approx(static * train.model.load_scale, rel=1e-6)


def test_standstill_rests_on_the_other_flank_under_a_negative_load(train: GearTrain) -> None:
    assert np.all(settled(train, 600.0).meshes(0.0)[:, 0] > 1)
    assert np.all(settled(train, -600.0).meshes(0.0)[:, 0] < -1)


def test_phase_holds_at_standstill_and_goes_on_from_there(march: March) -> None:
    def sections(pause: float) -> Array:
        found: list[Array] = []
        march.restart(600.0)
        running, standing = Inputs(0.5, 600.0), Inputs(0.0, 600.0)
        march.advance((0.0, running), (30.0, running), found.append)
        begin = march.tau
        march.advance((begin, standing), (begin + pause, standing), found.append)
        begin = march.tau
        march.advance((begin, running), (begin + 30.0, running), found.append)
        return np.concatenate(found)[:, 0]

    # 30 is 2.39 periods of 4π: two sections, then the pause, then two more at the rest of the third and fourth period.
    # A step ends on the table's grid, so the moment of stopping is rounded up to it.
    without, paused = sections(0.0), sections(50.0)
    assert without == pytest.approx(4 * pi * np.arange(1, 5), abs=1e-9)
    assert paused - without == pytest.approx([0, 0, 50, 50], abs=0.11)


def test_creep_moves_the_phase_at_the_drives_frequency(march: March) -> None:
    found: list[Array] = []
    march.restart(600.0)
    creep = Inputs(0.003, 600.0)
    march.advance((0.0, creep), (3 * 2 * pi / 0.003 + 10, creep), found.append)
    tau = np.concatenate(found)[:, 0]
    assert tau == pytest.approx(2 * pi / 0.003 * np.arange(1, 4), abs=0.5)


def test_steps_are_never_longer_than_asked(train: GearTrain) -> None:
    for frequency in (2.0, 0.3, 0.004, 0.0):
        march, inputs = March(train, load=600.0, longest_step=0.07), Inputs(frequency, 600.0)
        march.advance((0.0, inputs), (1e-9, inputs))
        assert 0 < march.tau <= 0.07


def test_an_interval_without_length_is_no_motion(march: March) -> None:
    march.restart(600.0)
    first, second = march.advance((0.0, Inputs(0.5, 600.0)), (0.0, Inputs(0.9, 10.0)))
    assert march.tau == 0
    assert first == second == Window()


def test_sections_are_all_collected_however_many_there_are(march: March) -> None:
    # 5000 sections are more than the room that one pass of the compiled loop has for them.
    found: list[Array] = []
    march.restart(600.0)
    inputs, period = Inputs(40.0, 600.0), 2 * pi / 40
    march.advance((0.0, inputs), (5000.001 * period, inputs), found.append)
    tau = np.concatenate(found)[:, 0]
    assert len(found) == 2
    assert tau == pytest.approx(period * np.arange(1, len(tau) + 1), rel=1e-9)
    assert len(tau) == 5000


@pytest.mark.parametrize("room", [1, 7])
def test_the_room_for_sections_changes_no_bit(march: March, room: int) -> None:
    begin, end = (0.0, Inputs(0.3, 600.0)), (200.0, Inputs(0.9, 400.0))
    found = []
    for options in ({}, {"room": room}):
        sections: list[Array] = []
        march.restart(600.0)
        windows = march.advance(begin, end, sections.append, **options)
        found.append((windows, march.whole.tobytes(), np.concatenate(sections).tobytes(), len(sections)))
    assert found[0][:3] == found[1][:3]
    assert found[1][3] > found[0][3]


def test_load_is_followed_linearly(make_train: MakeTrain) -> None:
    # On a stiff, damped train a slow ramp of the load is a sequence of static states.
    train = make_train({"*damping_ratio": 0.5, "*.torsional_stiffness": 1e6, "*.error_amplitude": [0, 0]})
    march = March(train, load=100.0)
    march.advance((0.0, Inputs(0.0, 100.0)), (4000.0, Inputs(0.0, 500.0)))
    expected = System(train).at(frequency=0, load=500.0).static_state()
    assert march.state[[2, 5, 8, 11]] == pytest.approx(expected[[2, 5, 8, 11]], rel=0.02)
