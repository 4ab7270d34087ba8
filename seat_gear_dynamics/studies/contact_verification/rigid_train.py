"""The verification model's equations: s1 driven by a motion, s2 and s3 one rigid body, s4 loaded, contacts between.

State y = (lead of s2-s3, lead of s4, their rates), rad and rad/s: how far they are ahead of where s1's motion alone
would put them, each positive in its own driving direction; all are 0 where the machine was assembled, at rest and with
teeth centred in their backlash. Leads stay as small as the contacts' penetrations, and apart from them forces hardly
depend on time, which is what lets a stiff integrator take long steps.
"""

from math import cos, floor, pi, sin
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.studies.contact_verification.impact import Contact, friction_coefficient, impact, step
from seat_gear_dynamics.studies.contact_verification.line_of_action import Line, gap

Array = NDArray[np.float64]


class Drive(NamedTuple):
    """What is done to the machine; both ramps are ADAMS STEPs from 0 at time 0."""

    speed: float
    """Of s1, rad/s, after the ramp."""
    speed_ramp: float
    """s; 0 is at once."""
    load: float
    """T4, N·m, after the ramp."""
    load_ramp: float
    """s; 0 is at once."""
    eccentricity: float
    """Of s1's teeth from its axis, m; towards s2 at time 0."""


class Train(NamedTuple):
    """The rigid bodies and their contacts."""

    first: Line
    second: Line
    first_contact: Contact
    second_contact: Contact
    middle_inertia: float
    """Of s2 and s3 together, kg·m²."""
    output_inertia: float
    """Of s4, kg·m²."""


class MeshLoad(NamedTuple):
    """What a mesh does at one moment, and how that changes with its closing δ (m) and its rate (m/s)."""

    force: float
    """Normal force on the driving flanks, all pairs together, N."""
    back_force: float
    """The same on the other flanks, N."""
    driver_torque: float
    """That holds the driver back, N·m."""
    driven_torque: float
    """That drives the driven gear, N·m."""
    driver_slope: float
    driven_slope: float
    driver_rate_slope: float
    driven_rate_slope: float


@njit(cache=True, nogil=True, error_model="numpy")
def input_motion(drive: Drive, time: float) -> tuple[float, float, float]:
    """Return (angle, speed, acceleration) of s1 at `time`, rad, rad/s, rad/s²: the STEP-ramped speed and its like."""
    if time >= drive.speed_ramp:
        return drive.speed * (time - drive.speed_ramp / 2), drive.speed, 0.0
    share = time / drive.speed_ramp
    angle = drive.speed * drive.speed_ramp * share * share * share * (1.0 - share / 2)
    acceleration = drive.speed * 6.0 * share * (1.0 - share) / drive.speed_ramp
    return angle, drive.speed * share * share * (3.0 - 2.0 * share), acceleration


@njit(cache=True, nogil=True, error_model="numpy")
def load_torque(drive: Drive, time: float) -> float:
    """Return T4 at `time`, N·m."""
    if time >= drive.load_ramp:
        return drive.load
    return step(time, 0.0, 0.0, drive.load_ramp, drive.load)


@njit(cache=True, nogil=True, error_model="numpy")
def _flank(
    line: Line,
    contact: Contact,
    side: float,
    advance: float,
    closing: float,
    rate: float,
    driver_speed: float,
    driven_speed: float,
) -> tuple[float, float, float, float, float, float, float]:
    """Return (force, torque on driver and driven, their slopes over `closing` and `rate`) of one side's flanks.

    `side` is 1 for the driving flanks and −1 for the others, whose line of action is the mirror image and is travelled
    backwards; `advance` is how far the driver's base circle has turned since a tooth stood on the line of centres, m.
    A pair at s slides with v = ω_a·s − ω_b·(L − s); friction turns the driven gear by µ(v)·N·(L − s) and holds the
    driver by µ(v)·N·s. Force and friction are taken on the line of action for corner contact, too.
    """
    force = driver = driven = driver_slope = driven_slope = driver_rate = driven_rate = 0.0
    travel = side * (driver_speed * line.driver_radius)
    # A tooth centred on the line of centres has passed the pitch point by a quarter of the base pitch.
    place = line.pitch_point + line.pitch / 4 + side * advance
    place -= line.pitch * floor((place - line.start) / line.pitch) + line.pitch
    while place < line.end + line.pitch:
        separation, slope = gap(line, place)
        penetration = closing - separation
        if penetration > 0.0:
            normal, stiff, damp = impact(contact, penetration, rate - slope * travel)
            slip = driver_speed * place - driven_speed * (line.length - place)
            mu = friction_coefficient(contact, slip)
            on_driver = side * line.driver_radius + place * mu
            on_driven = side * line.driven_radius + (line.length - place) * mu
            force += normal
            driver += normal * on_driver
            driven += normal * on_driven
            driver_slope += side * stiff * on_driver
            driven_slope += side * stiff * on_driven
            driver_rate += side * damp * on_driver
            driven_rate += side * damp * on_driven
        place += line.pitch
    return force, driver, driven, driver_slope, driven_slope, driver_rate, driven_rate


@njit(cache=True, nogil=True, error_model="numpy")
def mesh_load(
    line: Line,
    contact: Contact,
    angle: float,
    speed: float,
    closing: float,
    rate: float,
    eccentricity: float,
) -> MeshLoad:
    """Return what a mesh does with its driver at `angle`, rad, and `speed`, rad/s.

    `closing` is the driver's base-circle arc less the driven gear's, m; `rate` its rate, m/s. The driver's teeth are
    `eccentricity`, m, off its axis, towards the driven gear at angle 0. With n the direction of a flank's line of
    action, penetration grows by the centre's offset along n: on the driving flanks by e·sin(θ + α), on the others by
    e·sin(α − θ), so that the backlash shrinks by 2·e·sin α·cos θ.
    """
    other_speed = (line.driver_radius * speed - rate) / line.driven_radius
    advance = line.pitch * line.teeth * angle / (2 * pi)
    c, s = eccentricity * cos(angle), eccentricity * sin(angle)
    ahead = closing - line.half_backlash + s * line.cosine + c * line.sine
    ahead_rate = rate + speed * (c * line.cosine - s * line.sine)
    behind = -closing - line.half_backlash + c * line.sine - s * line.cosine
    behind_rate = -rate - speed * (s * line.sine + c * line.cosine)
    f = _flank(line, contact, 1.0, advance, ahead, ahead_rate, speed, other_speed)
    b = _flank(line, contact, -1.0, advance, behind, behind_rate, speed, other_speed)
    return MeshLoad(f[0], b[0], f[1] + b[1], f[2] + b[2], f[3] + b[3], f[4] + b[4], f[5] + b[5], f[6] + b[6])


@njit(cache=True, nogil=True, error_model="numpy")
def mesh_loads(train: Train, drive: Drive, time: float, y: Array) -> tuple[MeshLoad, MeshLoad]:
    """Return what P12 and P34 do at `time`, s, in state `y`, shape (4,)."""
    a, b = train.first, train.second
    angle, speed, _ = input_motion(drive, time)
    first = mesh_load(
        a, train.first_contact, angle, speed, -a.driven_radius * y[0], -a.driven_radius * y[2], drive.eccentricity
    )
    ratio = a.driver_radius / a.driven_radius
    closing, rate = b.driver_radius * y[0] - b.driven_radius * y[1], b.driver_radius * y[2] - b.driven_radius * y[3]
    return first, mesh_load(b, train.second_contact, ratio * angle + y[0], ratio * speed + y[2], closing, rate, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def accelerations(train: Train, drive: Drive, time: float, y: Array) -> tuple[float, float]:
    """Return the second derivatives of both leads, rad/s², at `time`, s, in state `y`, shape (4,)."""
    a, b = train.first, train.second
    first, second = mesh_loads(train, drive, time, y)
    _, _, moved = input_motion(drive, time)
    moved *= a.driver_radius / a.driven_radius
    middle = (first.driven_torque - second.driver_torque) / train.middle_inertia
    output = (second.driven_torque - load_torque(drive, time)) / train.output_inertia
    return middle - moved, output - moved * b.driver_radius / b.driven_radius


@njit(cache=True, nogil=True, error_model="numpy")
def jacobian(train: Train, first: MeshLoad, second: MeshLoad, stiffness: Array, damping: Array) -> None:
    """Fill the accelerations' derivatives, shape (2, 2) each, over the angles and over the speeds.

    Friction coefficients are held, and so are positions on the lines of action: an approximation that the integrator
    allows.
    """
    a, b = train.first, train.second
    jm, jo = train.middle_inertia, train.output_inertia
    stiffness[0, 0] = -(first.driven_slope * a.driven_radius + second.driver_slope * b.driver_radius) / jm
    stiffness[0, 1] = second.driver_slope * b.driven_radius / jm
    stiffness[1, 0] = second.driven_slope * b.driver_radius / jo
    stiffness[1, 1] = -second.driven_slope * b.driven_radius / jo
    damping[0, 0] = -(first.driven_rate_slope * a.driven_radius + second.driver_rate_slope * b.driver_radius) / jm
    damping[0, 1] = second.driver_rate_slope * b.driven_radius / jm
    damping[1, 0] = second.driven_rate_slope * b.driver_radius / jo
    damping[1, 1] = -second.driven_rate_slope * b.driven_radius / jo
