"""The equations: kinematics, one mesh's statics and power, and the Jacobian against differences."""

from math import cos, inf, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.studies.contact_verification.impact import Contact, impact
from seat_gear_dynamics.studies.contact_verification.line_of_action import Line, line_of_action
from seat_gear_dynamics.studies.contact_verification.readings import Assumptions
from seat_gear_dynamics.studies.contact_verification.rigid_train import (
    Drive,
    MeshLoad,
    accelerations,
    input_motion,
    jacobian,
    load_torque,
    mesh_load,
    mesh_loads,
)
from seat_gear_dynamics.studies.contact_verification.verify import rigid_train

DRIVE = Drive(13.8, 0.1, 300.0, 0.05, 0.0)
SLIPPERY = Contact(1.4e10, 1.5, 2e5, 1e-4, 0.0, 0.0, 0.1, 1.0)
ROUGH = SLIPPERY._replace(static_friction=0.23, dynamic_friction=0.16)


def loaded(line: Line, contact: Contact, closing: float, *, angle: float = 0.0, eccentricity: float = 0.0) -> MeshLoad:
    return mesh_load(line, contact, angle, 13.8, closing, 0.0, eccentricity)


def single(line: Line) -> float:
    """Return a driver angle at which one pair alone is on the path of contact, at the pitch point."""
    return -pi / (2 * line.teeth)


def test_input_angle_speed_and_acceleration_are_derivatives_of_each_other() -> None:
    h = 1e-6
    for time in (0.0 + h, 0.03, 0.07, 0.1 - 2 * h, 0.3):
        before, at, after = (input_motion(DRIVE, time + shift) for shift in (-h, 0.0, h))
        # Central differences of a quartic: h² times its third derivative, 1e5 at most, and rounding over h.
        assert (after[0] - before[0]) / (2 * h) == pytest.approx(at[1], abs=1e-6)
        assert (after[1] - before[1]) / (2 * h) == pytest.approx(at[2], abs=1e-6 * 300)


def test_input_runs_at_its_speed_after_the_ramp_having_lost_half_of_it() -> None:
    assert input_motion(DRIVE, 2.0) == pytest.approx((13.8 * 1.95, 13.8, 0.0), rel=1e-14)
    assert input_motion(DRIVE._replace(speed_ramp=0.0), 0.0) == (0.0, 13.8, 0.0)


def test_load_rises_by_a_step_or_is_there_at_once() -> None:
    assert [load_torque(DRIVE, t) for t in (0.0, 0.025, 0.05, 9.0)] == [0.0, 150.0, 300.0, 300.0]
    assert load_torque(DRIVE._replace(load_ramp=0.0), 0.0) == 300.0


def test_one_pair_presses_by_impact_and_turns_by_the_base_radii(train: GearTrain) -> None:
    line = line_of_action(train.meshes[0], 0.0)
    found = loaded(line, SLIPPERY, 3e-5, angle=single(line))
    assert found.force == pytest.approx(impact(SLIPPERY, 3e-5, 0.0)[0], rel=1e-12)
    assert found.back_force == 0
    assert found.driver_torque == pytest.approx(found.force * line.driver_radius, rel=1e-12)
    assert found.driven_torque == pytest.approx(found.force * line.driven_radius, rel=1e-12)


def test_two_pairs_press_with_one_penetration(train: GearTrain) -> None:
    line = line_of_action(train.meshes[0], 0.0)
    found = loaded(
        line, SLIPPERY, 3e-5
    )  # at angle 0 pairs stand at a quarter pitch past the pitch point and one before
    assert found.force == pytest.approx(2 * impact(SLIPPERY, 3e-5, 0.0)[0], rel=1e-12)


def test_other_flanks_hold_the_driven_gear_back(train: GearTrain) -> None:
    line = line_of_action(train.meshes[0], 20e-6)
    found = loaded(line, SLIPPERY, -4e-5)
    assert found.force == 0
    assert found.back_force > 0
    assert found.driven_torque == pytest.approx(-found.back_force * line.driven_radius, rel=1e-12)
    assert found.driver_torque == pytest.approx(-found.back_force * line.driver_radius, rel=1e-12)


@pytest.mark.parametrize("closing", [-9.9e-6, 0.0, 9.9e-6])
def test_nothing_presses_within_the_backlash(train: GearTrain, closing: float) -> None:
    assert loaded(line_of_action(train.meshes[0], 20e-6), ROUGH, closing) == (0.0,) * len(MeshLoad._fields)


@pytest.mark.parametrize("angle", [0.0, 0.7, pi / 2, pi])
def test_eccentric_teeth_close_the_backlash_by_twice_their_offset_along_the_normals(
    train: GearTrain, angle: float
) -> None:
    line = line_of_action(train.meshes[0], 0.0)
    eccentricity = 40e-6
    shrink = 2 * eccentricity * line.sine * cos(angle)
    # Where neither flank presses on the other the closing may move by −shrink: probe with bisection for both ends.
    ends = []
    for side in (1, -1):
        low, high = -1e-4, 1e-4
        for _ in range(60):
            middle = (low + high) / 2
            force = mesh_load(line, SLIPPERY, angle, 0.0, side * middle, 0.0, eccentricity)
            low, high = (low, middle) if (force.force if side > 0 else force.back_force) > 0 else (middle, high)
        ends.append(low)
    # Seen at 1e-4/2^60; a force below the smallest number counts as none, which K·p^1.5 is far from at 1e-12 m.
    assert sum(ends) == pytest.approx(-shrink, abs=1e-12)
    assert ends[0] == pytest.approx(-eccentricity * (sin(angle) * line.cosine + cos(angle) * line.sine), abs=1e-12)


@given(st.floats(0, 6.3), st.floats(-80e-6, 80e-6), st.floats(0.1, 40), st.floats(-0.1, 0.1))
def test_friction_only_takes_power(train: GearTrain, angle: float, closing: float, speed: float, rate: float) -> None:
    # With corner contact the gap's own rate moves power, too: without it, what comes in less what goes out and what
    # the normal forces take up is what sliding takes.
    line = line_of_action(train.meshes[0], 20e-6, corner=False)
    found = mesh_load(line, ROUGH, angle, speed, closing, rate, 0.0)
    driven_speed = (line.driver_radius * speed - rate) / line.driven_radius
    lost = found.driver_torque * speed - found.driven_torque * driven_speed - (found.force - found.back_force) * rate
    # Rounding of powers of up to 1e6 W.
    assert lost >= -1e-9 * (1 + abs(found.driver_torque * speed))


def test_a_rolling_pair_at_the_pitch_point_has_no_friction(train: GearTrain) -> None:
    line = line_of_action(train.meshes[0], 0.0)
    rough, slippery = (loaded(line, contact, 3e-5, angle=single(line)) for contact in (ROUGH, SLIPPERY))
    assert rough.driven_torque == pytest.approx(slippery.driven_torque, rel=1e-12)


def test_approach_costs_torque_and_recess_less(train: GearTrain) -> None:
    line = line_of_action(train.meshes[0], 0.0)
    shift = 0.3e-3 / line.driver_radius
    # 10 µm are less than the gap of the next pairs, which would slide the other way.
    approach, recess = (loaded(line, ROUGH, 1e-5, angle=single(line) + side * shift) for side in (-1, 1))
    # Before the pitch point friction on the driven gear acts against its motion, past it with it.
    assert approach.driven_torque < approach.force * line.driven_radius
    assert recess.driven_torque > recess.force * line.driven_radius


@pytest.mark.parametrize("state", [(-4e-3, -6e-3, 0.1, -0.2), (-1.5e-3, -1e-3, 0.0, 0.3), (2e-3, 1e-3, 0.0, 0.0)])
def test_jacobian_is_the_difference_of_accelerations_without_friction(
    train: GearTrain, state: tuple[float, ...]
) -> None:
    bodies = rigid_train(train, 10e-6, Assumptions(friction=False, corner=False))
    y, time = np.array(state), 0.2
    stiffness, damping = np.empty((2, 2)), np.empty((2, 2))
    jacobian(bodies, *mesh_loads(bodies, DRIVE, time, y), stiffness, damping)
    for column in range(4):
        h = 1e-7
        ahead, behind = y.copy(), y.copy()
        ahead[column] += h
        behind[column] -= h
        found = (
            np.subtract(accelerations(bodies, DRIVE, time, ahead), accelerations(bodies, DRIVE, time, behind)) / 2 / h
        )
        expected = np.hstack([stiffness, damping])[:, column]
        # h is 1e-4 of the penetration's scale and less, so the differences are off by 1e-6 of the largest entry.
        scale = np.abs(np.hstack([stiffness, damping])[:, column - column % 2 :][:, :2]).max()
        assert found == pytest.approx(expected, abs=1e-5 * scale + 1e-6)


def test_accelerations_at_rest_are_those_of_the_load_alone(train: GearTrain) -> None:
    bodies = rigid_train(train, 30e-6, Assumptions())
    at_once = DRIVE._replace(load_ramp=0.0)
    middle, output = accelerations(bodies, at_once, 0.0, np.zeros(4))
    assert middle == 0.0
    assert output == pytest.approx(-300.0 / train.gears[3].inertia, rel=1e-14)


def test_an_infinite_closing_is_an_infinite_force_and_no_error(train: GearTrain) -> None:
    assert loaded(line_of_action(train.meshes[0], 0.0), SLIPPERY, inf).force == inf


def test_leads_fall_back_by_the_inputs_acceleration_where_nothing_touches(train: GearTrain) -> None:
    bodies = rigid_train(train, 30e-6, Assumptions())
    time = 0.03
    middle, output = accelerations(bodies, DRIVE._replace(load=0.0), time, np.zeros(4))
    # Free bodies stand still, and their leads are what s1's motion has gone ahead, geared down.
    ratio = bodies.first.driver_radius / bodies.first.driven_radius
    assert middle == pytest.approx(-ratio * input_motion(DRIVE, time)[2], rel=1e-12)
    assert output == pytest.approx(middle * bodies.second.driver_radius / bodies.second.driven_radius, rel=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("side", [1, -1])
def test_eccentric_teeth_press_at_the_rate_of_their_offset(train: GearTrain, angle: float, side: int) -> None:
    line = line_of_action(train.meshes[0], 0.0, corner=False)
    eccentricity, speed, h = 40e-6, 13.8, 1e-6

    def offset(at: float) -> float:
        """Return the centre's way along the flank's line of action, towards the driven gear, m."""
        return eccentricity * (cos(at) * line.sine + side * sin(at) * line.cosine)

    rate = speed * (offset(angle + h) - offset(angle - h)) / (2 * h)
    moving = mesh_load(line, SLIPPERY, angle, speed, side * 6e-5, 0.0, eccentricity)
    resting = mesh_load(line, SLIPPERY, angle, 0.0, side * 6e-5, 0.0, eccentricity)
    forces = (moving.force, resting.force) if side > 0 else (moving.back_force, resting.back_force)
    pressed = 6e-5 + offset(angle)
    expected = impact(SLIPPERY, pressed, rate)[0] / impact(SLIPPERY, pressed, 0.0)[0]
    # One pair or two, alike; the difference of a cosine over 1e-6 rad is right to 1e-10.
    assert forces[0] / forces[1] == pytest.approx(expected, rel=1e-8)
