"""A session set to a sensor's state gives the forces of the one it was taken from, bit for bit."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.sensing import Level, Session, VirtualSensor
from seat_gear_dynamics.sensing.virtual_sensor import SENSOR_STATE_NAMES


def forces(session: Session, times: list[float], speeds: list[float], load: float) -> list[object]:
    found: list[object] = []
    for t, speed in zip(times, speeds, strict=True):
        session.feed(t, speed, load)
        found.append(session.take_windows())
    return found


@given(
    st.lists(st.floats(-2000, 2000), min_size=3, max_size=12),
    st.integers(1, 11),
    st.floats(0.004, 0.2),
    st.sampled_from([0.0, 100.0, 600.0, -50.0]),
)
@settings(max_examples=25)
def test_it_goes_on_bit_for_bit_from_any_sample(
    train: GearTrain, rpm: list[float], cut: int, step: float, load: float
) -> None:
    cut = min(cut, len(rpm) - 1)
    times, speeds = [7.3 + step * k for k in range(len(rpm))], [value * RPM for value in rpm]
    first = Session(train)
    forces(first, times[:cut], speeds[:cut], load)
    state = first.sensor.state
    assert state is not None
    second = Session(train)
    second.resume(state)
    assert forces(second, times[cut:], speeds[cut:], load) == forces(first, times[cut:], speeds[cut:], load)
    one, other = first.sensor.state, second.sensor.state
    assert one is not None
    assert other is not None
    assert one.tolist() == other.tolist()


def test_a_resumed_session_waits_for_input(train: GearTrain) -> None:
    first, second = Session(train), Session(train)
    first.feed(0.0, 100.0, 600.0)
    state = first.sensor.state
    assert state is not None
    second.feed(0.0, 180.0, 600.0)
    second.resume(state)
    assert second.reading is None
    assert (second.verdict.level, second.verdict.in_band) == (Level.STALE, False)
    assert len(second.section) == 0
    assert second.feed(0.01, 100.0, 600.0).reading.event == "running"


def test_there_is_no_state_before_a_sample_and_after_a_reset(train: GearTrain) -> None:
    sensor = VirtualSensor(train)
    assert sensor.state is None
    sensor.update(0.0, 100.0, 600.0)
    assert sensor.state is not None
    assert len(sensor.state) == len(set(SENSOR_STATE_NAMES)) == 58
    sensor.reset()
    assert sensor.state is None


@pytest.mark.parametrize("fault", ["short", "nan", "inf"])
def test_what_is_no_state_is_refused_and_changes_nothing(train: GearTrain, fault: str) -> None:
    sensor = VirtualSensor(train)
    sensor.update(0.0, 100.0, 600.0)
    before = sensor.state
    assert before is not None
    wrong = before[:-1] if fault == "short" else before.copy()
    if fault != "short":
        wrong[-1] = float(fault)
    with pytest.raises(ValueError, match=r"expected \(58,\) finite numbers"):
        sensor.state = wrong
    after = sensor.state
    assert after is not None
    assert after.tolist() == before.tolist()
