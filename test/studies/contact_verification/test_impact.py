"""The IMPACT law: its closed form, free bounces against exact and published solutions, and the friction law."""

from itertools import pairwise
from math import gamma, inf, nan, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from seat_gear_dynamics.studies.contact_verification.impact import (
    Contact,
    checked,
    friction_coefficient,
    hertz_stiffness,
    impact,
    step,
)

LINEAR = Contact(4e8, 1.0, 2e5, 1e-4, 0.23, 0.16, 0.1, 1.0)
HERTZ = LINEAR._replace(stiffness=1.4e10, exponent=1.5)
MASS = 0.09
LONGEST_STEP = 1e-7  # s, some 1/500 of a bounce: the last step runs over the corner that the force has where it ends

contacts = st.sampled_from([LINEAR, HERTZ, HERTZ._replace(damping=0.0)])
penetrations = st.floats(-1e-4, 5e-4)
rates = st.floats(-5.0, 5.0)


def bounce(contact: Contact, speed: float, mass: float = MASS) -> tuple[float, float, float]:
    """Return (time in contact, speed after, deepest penetration) of a free mass that meets the contact at `speed`.

    Contact ends where the force does: with damping, before the penetration is gone.
    """

    def rates(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -impact(contact, y[0], y[1])[0] / mass]

    def leaves(_: float, y: np.ndarray) -> float:
        spring = contact.stiffness * abs(y[0]) ** contact.exponent * (1 if y[0] > 0 else -1)
        return float(spring + contact.damping * y[1] * step(y[0], 0.0, 0.0, contact.depth, 1.0))

    leaves.terminal, leaves.direction = True, -1  # type: ignore[attr-defined]
    found = solve_ivp(
        rates, (0, 1), [1e-15, speed], method="DOP853", rtol=1e-12, atol=1e-18, events=leaves, max_step=LONGEST_STEP
    )
    return float(found.t[-1]), -float(found.y[1, -1]), float(found.y[0].max())


def test_step_is_the_cubic_of_adams() -> None:
    assert [step(x, 1.0, 10.0, 3.0, 20.0) for x in (0.0, 1.0, 2.0, 3.0, 4.0)] == [10.0, 10.0, 15.0, 20.0, 20.0]
    assert step(1.5, 1.0, 10.0, 3.0, 20.0) == pytest.approx(10 + 10 * (3 / 16 - 2 / 64), rel=1e-14)


@given(st.floats(-2, 5), st.floats(0, 1))
def test_step_never_falls_where_it_is_to_rise(x: float, further: float) -> None:
    assert step(x + further, 0.0, -1.0, 2.0, 3.0) >= step(x, 0.0, -1.0, 2.0, 3.0)


def test_force_is_spring_plus_half_the_damping_at_half_the_depth() -> None:
    force, slope, damping = impact(LINEAR, 5e-5, 0.01)
    assert force == pytest.approx(4e8 * 5e-5 + 0.5 * 2e5 * 0.01, rel=1e-14)
    assert damping == pytest.approx(1e5, rel=1e-14)
    assert slope == pytest.approx(4e8 + 2e5 * 0.01 * 1.5 / 1e-4, rel=1e-14)  # the cubic's slope is 3/2 in its middle


def test_damping_is_full_beyond_the_depth_and_none_at_touch() -> None:
    assert impact(HERTZ, 3e-4, 0.1)[0] == pytest.approx(1.4e10 * 3e-4**1.5 + 2e5 * 0.1, rel=1e-14)
    assert impact(HERTZ, 1e-12, 1.0)[2] < 1e-10


@given(contacts, penetrations, rates)
def test_force_never_attracts_and_acts_in_contact_alone(contact: Contact, penetration: float, rate: float) -> None:
    force, _, damping = impact(contact, penetration, rate)
    assert force >= 0
    assert damping >= 0
    if penetration <= 0:
        assert force == 0


@given(contacts, st.floats(1e-6, 3e-4), st.floats(0, 1))
def test_slopes_are_the_derivatives_of_the_force(contact: Contact, penetration: float, rate: float) -> None:
    _, slope, damping = impact(contact, penetration, rate)
    # Central differences of a smooth function: error of order (1e-5)² of it; the corner of STEP at the depth less so.
    h = 1e-5 * penetration
    by_depth = (impact(contact, penetration + h, rate)[0] - impact(contact, penetration - h, rate)[0]) / (2 * h)
    by_rate = (impact(contact, penetration, rate + 1e-3)[0] - impact(contact, penetration, rate)[0]) / 1e-3
    assert slope == pytest.approx(by_depth, rel=1e-3)
    assert damping == pytest.approx(by_rate, rel=1e-6, abs=1e-3)


def test_undamped_linear_bounce_is_a_half_sine_and_keeps_its_energy() -> None:
    time, after, deepest = bounce(LINEAR._replace(damping=0.0), 1.2)
    frequency = sqrt(4e8 / MASS)
    # The last step's error is of third order in its share of the half wave, (π/470)³ = 3e-7, times a small constant.
    assert time == pytest.approx(pi / frequency, rel=1e-7)
    assert after == pytest.approx(1.2, rel=1e-7)
    assert deepest == pytest.approx(1.2 / frequency, rel=1e-5)  # the deepest of 470 samples: (π/940)²/2 = 6e-6


def test_undamped_hertzian_bounce_lasts_as_long_as_hertz_found() -> None:
    # Hertz 1882; Johnson 1985, Contact Mechanics, (11.22)-(11.24): δ* = (5·m·v²/4K)^(2/5), time 2.94·δ*/v, where
    # 2.94 is 2·√π·Γ(7/5)/Γ(9/10).
    time, after, _ = bounce(HERTZ._replace(damping=0.0), 0.8)
    deepest = (5 * MASS * 0.8**2 / (4 * HERTZ.stiffness)) ** 0.4
    constant = 2 * sqrt(pi) * gamma(1.4) / gamma(0.9)
    assert constant == pytest.approx(2.94, abs=5e-3)
    assert time == pytest.approx(constant * deepest / 0.8, rel=1e-7)
    assert after == pytest.approx(0.8, rel=1e-7)


@pytest.mark.parametrize("contact", [LINEAR, HERTZ])
def test_restitution_falls_with_damping_and_no_bounce_gains_energy(contact: Contact) -> None:
    returned = [bounce(contact._replace(damping=c), 0.5)[1] / 0.5 for c in (0.0, 1e3, 1e4, 1e5, 2e5)]
    assert returned[0] == pytest.approx(1.0, rel=1e-7)
    assert all(a > b >= 0 for a, b in pairwise(returned))


def test_friction_has_its_named_values_at_its_named_speeds() -> None:
    speeds = (0.0, 0.1, -0.1, 1.0, -1.0, 50.0, -50.0)
    found = [friction_coefficient(LINEAR, v) for v in speeds]
    assert found == pytest.approx([0.0, 0.23, -0.23, 0.16, -0.16, 0.16, -0.16], abs=1e-15)
    # Half way between the two speeds STEP is half way between the coefficients; half the stiction speed is at 3/4 of
    # the STEP from −0.1 to 0.1, where the cubic is 27/32: 0.23·(2·27/32 − 1).
    assert friction_coefficient(LINEAR, 0.55) == pytest.approx(0.195, rel=1e-14)
    assert friction_coefficient(LINEAR, 0.05) == pytest.approx(0.23 * 11 / 16, rel=1e-14)


@given(st.floats(-10, 10))
def test_friction_is_odd_bounded_and_never_gives_power(slip: float) -> None:
    mu = friction_coefficient(LINEAR, slip)
    assert mu == pytest.approx(-friction_coefficient(LINEAR, -slip), abs=1e-15)
    assert abs(mu) <= 0.23
    assert mu * slip >= 0


def test_hertz_stiffness_is_that_of_a_ball_on_a_like_one() -> None:
    # Two equal spheres: R is half their radius; E* is half the plane-strain modulus.
    found = hertz_stiffness(0.02, 0.02, 2e11, 0.3)
    assert found == pytest.approx(4 / 3 * sqrt(0.01) * 2e11 / (2 * 0.91), rel=1e-14)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("stiffness", 0.0),
        ("stiffness", nan),
        ("exponent", 0.5),
        ("damping", -1.0),
        ("damping", inf),
        ("depth", 0.0),
        ("static_friction", -0.1),
        ("dynamic_friction", nan),
        ("stiction_speed", 0.0),
        ("friction_speed", 0.05),
    ],
)
def test_impossible_contacts_are_refused_by_name(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=field.replace("_", "[ _]")):
        checked(LINEAR._replace(**{field: value}))


def test_a_possible_contact_passes_unchanged() -> None:
    frictionless = LINEAR._replace(static_friction=0.0, dynamic_friction=0.0, damping=0.0)
    assert checked(frictionless) is frictionless
