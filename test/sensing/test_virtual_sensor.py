"""The virtual sensor beside a running drive: the same motion as the integration, and every turn a drive can take."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import March, System, integrate
from seat_gear_dynamics.sensing import ForceWindow, Reading, VirtualSensor

Array = NDArray[np.floating]
LOAD = 100.0


@pytest.fixture(scope="module")
def shared(train: GearTrain) -> VirtualSensor:
    """One sensor for all, as its tables take longer to make than a short drive; `sensor` resets it."""
    return VirtualSensor(train)


@pytest.fixture
def sensor(shared: VirtualSensor) -> VirtualSensor:
    shared.reset()
    shared.counts.clear()
    return shared


def drive(sensor: VirtualSensor, times: Array, speed: float, load: float = LOAD) -> list[Reading]:
    return [sensor.update(float(t), speed, load) for t in times]


def merged(readings: list[Reading], mesh: int = 0) -> ForceWindow:
    total = ForceWindow()
    for reading in readings:
        total = total.merged(reading.windows[mesh])
    return total


@pytest.mark.parametrize("frequency", [0.9, 0.31, -0.6])
def test_at_constant_speed_it_makes_the_very_steps_of_the_integration(
    sensor: VirtualSensor, train: GearTrain, frequency: float
) -> None:
    # Both march with steps locked to the mesh period from rest at phase 0, and steps do not depend on the samples.
    period = 2 * pi / abs(frequency) / train.model.time_scale
    readings = drive(sensor, np.arange(0, 30.3, 0.37) * period, train.speed(frequency))
    found = np.concatenate([r.section for r in readings])
    system = System(train).at(speed=train.speed(frequency), load=LOAD)
    expected = integrate(system, transient=0, periods=len(found))
    assert len(found) >= 29
    assert found[:, :2].tolist() == expected.section.tolist()


def test_an_accepted_sample_leaves_the_model_where_it_is_until_it_is_advanced(
    sensor: VirtualSensor, train: GearTrain
) -> None:
    readings = drive(sensor, np.arange(10) / 100, train.speed(0.5))
    state = sensor.state
    assert state is not None
    sample = sensor.accept(0.1, train.speed(0.5), LOAD)
    assert (sample.event, sample.regime) == ("running", readings[-1].regime)
    assert sensor.state is not None
    assert np.array_equal(sensor.state, state)
    assert sensor.counts["accepted"] == 9
    reading = sensor.advance(sample)
    sensor.state = state
    assert reading.windows == sensor.update(0.1, train.speed(0.5), LOAD).windows


@pytest.mark.parametrize(("t", "event"), [(5.0, "gap"), (-9.0, "clock stepped back")])
def test_a_restart_is_known_when_the_sample_is_accepted(sensor: VirtualSensor, t: float, event: str) -> None:
    drive(sensor, np.arange(60) / 100, 100.0)
    sample = sensor.accept(t, 100.0, LOAD)
    assert (sample.event, sample.regime.reason) == (event, f"the model restarted ({event})")
    assert sensor.counts[event] == 0
    assert sensor.advance(sample).event == event
    assert sensor.counts[event] == 1


def test_first_sample_puts_the_train_at_rest_under_its_load(sensor: VirtualSensor, train: GearTrain) -> None:
    reading = sensor.update(12.5, train.speed(0.5), LOAD)
    assert reading.event == "started"
    assert (reading.t, reading.load, len(reading.section)) == (12.5, LOAD, 0)
    assert reading.windows == (ForceWindow(), ForceWindow())
    assert reading.regime.reason == "the model restarted (started)"
    assert sensor.counts == {"started": 1}


@settings(max_examples=20)
@given(st.lists(st.floats(0.001, 0.06), min_size=1, max_size=8), st.sampled_from([0.9, 0.02, 0.0, -0.7]))
def test_windows_between_samples_merge_into_the_window_of_one_long_sample(
    shared: VirtualSensor, train: GearTrain, steps: list[float], frequency: float
) -> None:
    times, speed = np.concatenate([[0.0], np.cumsum(steps)]), train.speed(frequency)
    shared.reset()
    cut = drive(shared, times, speed)
    shared.reset()
    long = drive(shared, times[[0, -1]], speed)
    assert long[-1].event == "running"
    for mesh in (0, 1):
        one, other = merged(cut, mesh), merged(long, mesh)
        assert (one.min, one.max) == (other.min, other.max)
        assert (one.mean, one.rms, one.contact_loss) == pytest.approx(
            (other.mean, other.rms, other.contact_loss), rel=1e-9
        )


def test_section_times_lie_between_the_samples_and_a_mesh_period_apart(sensor: VirtualSensor, train: GearTrain) -> None:
    speed, step = train.speed(0.9), 0.1 / train.model.time_scale
    times = 1000.0 + np.arange(60) * 0.013
    readings = drive(sensor, times, speed)
    for before, reading in zip(times, readings[1:], strict=False):
        # The model finishes the step it is in, so it is ahead of the samples by less than a step.
        assert np.all((reading.section[:, 2] > before - 1e-9) & (reading.section[:, 2] < reading.t + step))
    found = np.concatenate([r.section[:, 2] for r in readings])
    assert len(found) > 150
    assert np.diff(found) == pytest.approx(2 * pi / (17 * speed), rel=1e-6)


def test_forces_are_in_newtons_and_deflections_in_metres(sensor: VirtualSensor, train: GearTrain) -> None:
    # 600 N·m at half the frequency keeps the teeth together; half the backlash is 10 µm.
    readings = drive(sensor, np.arange(0, 2, 0.01), train.speed(0.5), 600.0)
    for mesh, static in enumerate(train.static_forces(600.0)):
        window = merged(readings[100:], mesh)
        assert window.mean == pytest.approx(static * train.model.load_scale, rel=0.02)
        assert window.duration == pytest.approx(1.0, abs=1e-3)
        contact = readings[-1].contacts[mesh]
        assert 1e-5 < contact.deflection < 2e-5
        assert window.min <= contact.force <= window.max


def test_rate_is_the_time_derivative_of_the_deflection(sensor: VirtualSensor, train: GearTrain) -> None:
    # Samples half a step short of every fourth step: the model then stands on that step's end each time.
    step = 2 * pi / 0.5 / March(train).steps_per_period / train.model.time_scale
    times = np.concatenate([[0.0], (4 * np.arange(1, 500) - 0.5) * step])
    readings = drive(sensor, times, train.speed(0.5), 600.0)
    deflection = np.array([r.contacts[0].deflection for r in readings])
    rate = np.array([r.contacts[0].rate for r in readings])
    travelled = np.sum((rate[1:] + rate[:-1]) / 2) * 4 * step
    assert travelled == pytest.approx(deflection[-1] - deflection[0], abs=0.01 * float(np.ptp(deflection)))


@pytest.mark.parametrize("load", [600.0, -600.0])
def test_standstill_comes_to_rest_at_the_static_force(sensor: VirtualSensor, train: GearTrain, load: float) -> None:
    drive(sensor, np.arange(0, 0.5, 0.01), train.speed(0.5), load)
    readings = drive(sensor, np.arange(0.5, 4, 0.01), 0.0, load)
    for mesh, static in enumerate(train.static_forces(load)):
        window = readings[-1].windows[mesh]
        assert window.mean == pytest.approx(static * train.model.load_scale, rel=0.01)
        assert window.max - window.min < 0.01 * abs(window.mean)
        assert abs(readings[-1].contacts[mesh].rate) < 1e-4
    assert len(readings[-1].section) == 0


def test_zero_load_lets_the_teeth_float(make_train: Callable[..., GearTrain]) -> None:
    sensor = VirtualSensor(make_train({"*.error_amplitude": [0, 0]}))
    readings = drive(sensor, np.arange(0, 0.2, 0.01), 50.0, 0.0)
    assert merged(readings).contact_loss == 1
    assert merged(readings).mean == 0


def test_negative_load_rests_on_the_other_flank(sensor: VirtualSensor, train: GearTrain) -> None:
    readings = drive(sensor, np.arange(0, 0.3, 0.01), train.speed(0.5), -600.0)
    assert readings[-1].contacts[0].deflection < -1e-5
    assert merged(readings).mean < 0


def test_reversal_runs_the_phase_backward_and_keeps_the_loads_sign(sensor: VirtualSensor, train: GearTrain) -> None:
    times = np.arange(0, 1.2, 0.01)
    readings = [sensor.update(float(t), train.speed(0.6 * np.cos(pi * t / 1.2)), 600.0) for t in times]
    assert {r.event for r in readings[1:]} == {"running"}
    assert merged(readings).mean > 0
    met = np.concatenate([r.section[:, 2] for r in readings])
    # Ω = 0.6·cos(π·t/1.2) turns at 0.6 s; the phase there and back is 0.6·1861.5·1.2/π/2π·sin(π·t/1.2).
    phase = 0.6 * train.model.time_scale * 1.2 / pi / (2 * pi) * np.sin(pi * met / 1.2)
    assert np.abs(phase - np.round(phase)).max() < 0.1
    assert np.count_nonzero(met < 0.6) == pytest.approx(np.count_nonzero(met > 0.6), abs=2)


def test_a_jump_of_speed_is_followed_without_restart(sensor: VirtualSensor, train: GearTrain) -> None:
    drive(sensor, np.arange(0, 0.2, 0.01), train.speed(0.3))
    readings = drive(sensor, np.arange(0.2, 0.4, 0.01), train.speed(1.5))
    assert {r.event for r in readings} == {"running"}
    assert np.all(np.isfinite([r.contacts[0].force for r in readings]))


def test_a_gap_restarts_the_train_and_invents_nothing(sensor: VirtualSensor, train: GearTrain) -> None:
    drive(sensor, np.arange(0, 0.2, 0.01), train.speed(0.9))
    reading = sensor.update(0.19 + 0.51, train.speed(0.9), LOAD)
    assert (reading.event, len(reading.section)) == ("gap", 0)
    assert reading.windows == (ForceWindow(), ForceWindow())
    assert sensor.counts == {"started": 1, "accepted": 19, "gap": 1}
    assert sensor.update(0.71, train.speed(0.9), LOAD).event == "running"


def test_a_gap_of_just_the_limit_is_bridged(sensor: VirtualSensor, train: GearTrain) -> None:
    sensor.update(0.0, train.speed(0.9), LOAD)
    assert sensor.update(0.5, train.speed(0.9), LOAD).event == "running"


def test_a_clock_that_steps_far_back_restarts_the_train(sensor: VirtualSensor, train: GearTrain) -> None:
    drive(sensor, 100 + np.arange(0, 0.2, 0.01), train.speed(0.9))
    reading = sensor.update(5.0, train.speed(0.9), LOAD)
    assert reading.event == "clock stepped back"
    assert sensor.counts["clock stepped back"] == 1
    after = sensor.update(5.05, train.speed(0.9), LOAD)
    assert after.event == "running"
    assert np.all((after.section[:, 2] > 5.0) & (after.section[:, 2] < 5.051))


def test_a_restarted_train_moves_as_a_new_one(sensor: VirtualSensor, train: GearTrain) -> None:
    fresh = drive(sensor, np.arange(0, 0.2, 0.01), train.speed(0.9))
    sensor.update(7.0, train.speed(0.9), LOAD)
    sensor.reset()
    again = drive(sensor, np.arange(0, 0.2, 0.01), train.speed(0.9))
    assert [r.contacts for r in again] == [r.contacts for r in fresh]
    assert again[0].event == "started"


def test_a_diverging_solution_restarts_the_train(make_train: Callable[..., GearTrain]) -> None:
    # An error of ten kilometres throws the deflection beyond every bound at once.
    sensor = VirtualSensor(make_train({"*.error_amplitude": [1e10, 0]}))
    sensor.update(0.0, 50.0, LOAD)
    reading = sensor.update(0.1, 50.0, LOAD)
    assert reading.event == "diverged"
    assert sensor.counts["diverged"] == 1


def test_a_system_or_its_train_make_the_same_sensor(train: GearTrain) -> None:
    assert VirtualSensor(System(train)).train is train


@pytest.mark.parametrize("gap", [0.0, -1.0, float("nan")])
def test_an_impossible_gap_is_refused(train: GearTrain, gap: float) -> None:
    with pytest.raises(ValueError, match=r"max_gap is .* s, expected more than 0"):
        VirtualSensor(train, max_gap=gap)
