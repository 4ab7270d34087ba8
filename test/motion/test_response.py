"""A response: run in, then sampled period by period."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System, integrate


@settings(max_examples=25)
@given(st.floats(-2.2, 2.2).filter(lambda f: abs(f) > 0.02), st.integers(0, 5), st.integers(1, 7))
def test_there_is_one_section_point_for_each_period_asked(
    train: GearTrain, frequency: float, transient: int, periods: int
) -> None:
    response = integrate(
        System(train).at(frequency=frequency, load=600.0), transient=transient, periods=periods, target_steps=34
    )
    assert response.section.shape == (periods, 2)
    assert response.growth.shape == (periods, 2)
    assert response.period == pytest.approx(2 * pi / abs(frequency))
    # With 34 steps a period the drive creeps below 0.03, where steps are not locked to the period.
    assert response.windows[0].duration == pytest.approx(periods * response.period, rel=1e-9, abs=0.1)


@pytest.mark.parametrize("frequency", [1.9, 0.3, 0.004, 0.0029, 0.0014181818, -0.0016363636])
def test_there_is_one_section_point_for_each_period_down_to_creep(train: GearTrain, frequency: float) -> None:
    response = integrate(System(train).at(frequency=frequency, load=600.0), transient=1, periods=2)
    assert response.section.shape == (2, 2)


def test_section_is_the_deflection_of_the_state_at_phase_zero(train: GearTrain) -> None:
    system = System(train).at(frequency=0.9, load=100.0)
    response = integrate(system, transient=3, periods=5)
    delta, rate = system.deflections(0.0, response.state)
    assert response.section[-1] == pytest.approx([delta[0], rate[0]], rel=1e-9, abs=1e-9)


def test_going_on_from_a_state_is_going_on(train: GearTrain) -> None:
    # After 40 periods of P12 both meshes are at phase 0 again, where `state` starts.
    system = System(train).at(frequency=0.9, load=100.0)
    first = integrate(system, transient=0, periods=40)
    second = integrate(system, transient=0, periods=10, state=first.state)
    at_once = integrate(system, transient=40, periods=10)
    assert second.section.tolist() == at_once.section.tolist()
    assert second.state.tolist() == at_once.state.tolist()


def test_the_same_drive_gives_the_same_response_bit_for_bit(train: GearTrain) -> None:
    system = System(train).at(frequency=1.0, load=20.0)
    first, second = (integrate(system, transient=10, periods=20) for _ in range(2))
    assert first.section.tolist() == second.section.tolist()
    assert first.windows == second.windows


@pytest.mark.parametrize("frequency", [1.3, -0.5, 0.0029])
def test_progress_is_told_up_to_the_end_and_changes_no_bit(train: GearTrain, frequency: float) -> None:
    system, told = System(train).at(frequency=frequency, load=600.0), list[tuple[int, int]]()
    plain = integrate(system, transient=150, periods=100, target_steps=34)
    found = integrate(system, transient=150, periods=100, target_steps=34, progress=lambda *given: told.append(given))
    assert found.windows == plain.windows
    assert found.state.tobytes() == plain.state.tobytes()
    assert found.section.tobytes() == plain.section.tobytes()
    assert told == sorted(told)
    assert told[-1] == (250, 250)
    assert len(told) > 4


def test_zero_frequency_is_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="frequency is 0, where there is no mesh period"):
        integrate(System(train).at(frequency=0.0))


@pytest.mark.parametrize(("transient", "periods"), [(-1, 10), (10, 0)])
def test_impossible_numbers_of_periods_are_refused(train: GearTrain, transient: int, periods: int) -> None:
    with pytest.raises(ValueError, match=f"Asked for {transient} transient and {periods} sampled periods"):
        integrate(System(train), transient=transient, periods=periods)


def test_mean_force_under_load_is_the_static_force(train: GearTrain) -> None:
    # Over whole cycles of a settled, periodic motion no momentum is left: the mean force is what the torque needs.
    system = System(train).at(frequency=0.5, load=600.0)
    response = integrate(system, transient=400, periods=400)
    static = np.array(train.static_forces(600.0)) * train.model.load_scale
    means = [window.mean * response.force_unit for window in response.windows]
    assert means == pytest.approx(static, rel=1e-3)


# Section point, then P12's mean, rms, maximum and share of time out of contact, then P34's mean and rms; with eight
# times as many steps they agree to 0.6 % of a period's time out of contact and to 2e-4 otherwise.
GOLDEN = [
    0.9810201234541536,
    0.1484786929756869,
    0.08431927437743779,
    0.12622571047924344,
    0.28751663044017445,
    0.2058823529411641,
    0.1488426038050435,
    0.1691914982015359,
]


def test_response_of_the_fixed_train_keeps_its_golden_values(train: GearTrain) -> None:
    response = integrate(System(train).at(frequency=0.9, load=200.0), transient=40, periods=40)
    first, second = response.windows
    found = [*response.section[-1], first.mean, first.rms, first.maximum, first.contact_loss, second.mean, second.rms]
    assert found == pytest.approx(GOLDEN, rel=1e-7)
