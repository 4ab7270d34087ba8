"""The involute tooth: geometry, and compliance against independent integration and the literature's closed forms."""

from dataclasses import replace
from math import cos, pi, sin, sqrt, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from seat_gear_dynamics.gears import GearTrain, Tooth, contact_ratio
from seat_gear_dynamics.gears.tooth import base_pitch, path_of_contact

S1 = Tooth(17, 1.5e-3, pi / 9, 3.375e-3, 10e-3, 4e-3, 2.05e11, 0.269)
S2 = Tooth(40, 1.5e-3, pi / 9, 3.375e-3, 8e-3, 8e-3, 2.05e11, 0.269)


def textbook_contact_ratio(z1: int, z2: int, angle: float) -> float:
    """ε = [z1·(tan α_a1 − tan α) + z2·(tan α_a2 − tan α)]/2π, as gear textbooks give it for standard teeth."""
    total = 0.0
    for z in (z1, z2):
        tip = np.arccos(z * cos(angle) / (z + 2))
        total += z * (tan(tip) - tan(angle))
    return float(total / (2 * pi))


def test_published_pairs_have_contact_ratios_of_1_6142_and_1_5912(train: GearTrain) -> None:
    assert [round(mesh.contact_ratio, 4) for mesh in train.meshes] == [1.6142, 1.5912]


@given(st.integers(17, 80), st.integers(17, 80), st.floats(0.25, 0.45), st.floats(5e-4, 5e-3))
def test_contact_ratio_is_the_textbook_formula_whatever_the_module(
    z1: int, z2: int, angle: float, module: float
) -> None:
    first = replace(S1, teeth=z1, module=module, pressure_angle=angle)
    second = replace(first, teeth=z2)
    assert contact_ratio(first, second) == pytest.approx(textbook_contact_ratio(z1, z2, angle), rel=1e-9)
    assert contact_ratio(second, first) == pytest.approx(contact_ratio(first, second), rel=1e-12)


def test_contact_starts_at_the_driven_tip_and_ends_at_the_drivers() -> None:
    line = (S1.pitch_radius + S2.pitch_radius) * sin(S1.pressure_angle)
    start, end = path_of_contact(S1, S2)
    assert sqrt(S2.base_radius**2 + (line - start) ** 2) == pytest.approx(S2.tip_radius, rel=1e-12)
    assert sqrt(S1.base_radius**2 + end**2) == pytest.approx(S1.tip_radius, rel=1e-12)
    assert base_pitch(S1) == pytest.approx(2 * pi * S1.base_radius / 17, rel=1e-12)


@pytest.mark.parametrize("tooth", [S1, S2], ids=["s1", "s2"])
def test_tooth_is_half_a_pitch_thick_on_the_pitch_circle(tooth: Tooth) -> None:
    x, half = tooth.outline(np.array([tan(tooth.pressure_angle)]))  # the roll angle of the pitch point is tan α
    assert np.hypot(x, half) == pytest.approx(tooth.pitch_radius, rel=1e-12)
    assert np.arctan2(half, x) == pytest.approx(pi / (2 * tooth.teeth), rel=1e-12)


def test_involute_is_as_far_from_its_base_tangent_point_as_the_string_unwound() -> None:
    roll = np.linspace(0.0, S1.tip_roll, 50)
    x, half = S1.outline(roll)
    angle = S1.base_half_angle - roll  # direction of the point where the string leaves the base circle
    tangent_x, tangent_y = S1.base_radius * np.cos(angle), S1.base_radius * np.sin(angle)
    assert np.hypot(x - tangent_x, half - tangent_y) == pytest.approx(S1.base_radius * roll, abs=1e-15)


def beam_compliance_over_x(tooth: Tooth, roll: float) -> float:
    """Integrate (6)-(8) over x by adaptive quadrature, the outline inverted for its half thickness at each x."""
    a, r = tooth.base_half_angle, tooth.base_radius

    def flank(psi: float) -> tuple[float, float]:
        turn = a - psi
        return r * (cos(turn) - psi * sin(turn)), r * (sin(turn) + psi * cos(turn))

    contact_x, contact_h = flank(roll)
    across, along = cos(roll - a), sin(roll - a)
    shear_modulus = tooth.youngs_modulus / 2 / (1 + tooth.poisson_ratio)

    def density(x: float) -> float:
        on_involute = x > r * cos(a)
        half = flank(brentq(lambda psi: flank(psi)[0] - x, 0.0, roll, xtol=1e-15))[1] if on_involute else x * tan(a)
        area, inertia = 2 * half * tooth.width, tooth.width * (2 * half) ** 3 / 12
        bending = (across * (contact_x - x) - along * contact_h) ** 2 / tooth.youngs_modulus / inertia
        return bending + along**2 / tooth.youngs_modulus / area + 1.2 * across**2 / shear_modulus / area

    root = tooth.root_radius * cos(a)
    below, _ = quad(density, root, r * cos(a), epsabs=0, epsrel=1e-11)
    above, _ = quad(density, r * cos(a), contact_x, epsabs=0, epsrel=1e-11, limit=200)
    return float(below + above)


@pytest.mark.parametrize("tooth", [S1, S2], ids=["s1", "s2"])
@pytest.mark.parametrize("roll", [0.15, 0.3, 0.45])
def test_beam_compliance_equals_adaptive_integration_over_x(tooth: Tooth, roll: float) -> None:
    assert tooth.beam_compliance(roll) == pytest.approx(beam_compliance_over_x(tooth, roll), rel=1e-7)


@pytest.mark.parametrize("roll", [0.1, 0.25, 0.5])
def test_beam_compliance_of_a_tooth_on_its_base_circle_is_yang_and_lins(roll: float) -> None:
    # Yang & Lin 1987, doi:10.1115/1.3269429: the same energies as integrals over the pressure angle, from base circle.
    tooth = replace(S1, height=S1.tip_radius - S1.base_radius)
    a2, e, width, nu = tooth.base_half_angle, tooth.youngs_modulus, tooth.width, tooth.poisson_ratio
    a1 = roll - a2

    def density(a: float) -> float:
        thick = sin(a) + (a2 - a) * cos(a)
        step = (a2 - a) * cos(a)
        bending = 3 * (1 + cos(a1) * ((a2 - a) * sin(a) - cos(a))) ** 2 * step / (2 * e * width * thick**3)
        shear = 1.2 * (1 + nu) * step * cos(a1) ** 2 / (e * width * thick)
        return bending + shear + step * sin(a1) ** 2 / (2 * e * width * thick)

    expected, _ = quad(density, -a1, a2, epsabs=0, epsrel=1e-12)
    assert tooth.beam_compliance(roll) == pytest.approx(expected, rel=1e-9)


def test_a_tooth_is_softer_the_nearer_its_tip_it_is_loaded() -> None:
    compliances = [S1.beam_compliance(roll) for roll in np.linspace(0.1, S1.tip_roll, 12)]
    assert np.all(np.diff(compliances) > 0)


@settings(max_examples=40)
@given(st.floats(1e-3, 5e-2), st.floats(1e10, 1e12), st.floats(0.1, 0.5))
def test_compliances_fall_as_width_and_modulus_grow(width: float, modulus: float, roll: float) -> None:
    other = replace(S1, width=width, youngs_modulus=modulus)
    factor = S1.width * S1.youngs_modulus / (width * modulus)
    assert other.beam_compliance(roll) == pytest.approx(factor * S1.beam_compliance(roll), rel=1e-9)
    assert other.foundation_compliance(roll) == pytest.approx(factor * S1.foundation_compliance(roll), rel=1e-9)


def test_foundation_compliance_is_sainsots_formula() -> None:
    # Sainsot, Velex & Duverger 2004, written out for one case: the line of action crosses the centre line at u_f.
    roll, theta = 0.3, S1.base_half_angle
    turn, r_root = roll - theta, 1.5e-3 * 17 / 2 + 1.5e-3 - 3.375e-3
    u = S1.base_radius / cos(turn) - r_root * cos(theta)
    s = 2 * r_root * theta
    h = r_root / 4e-3
    length = -5.574e-5 / theta**2 - 1.9986e-3 * h**2 - 2.3015e-4 * h / theta + 4.7702e-3 / theta + 0.0271 * h + 6.8045
    mixed = 60.111e-5 / theta**2 + 28.1e-3 * h**2 - 83.431e-4 * h / theta - 9.9256e-3 / theta + 0.1624 * h + 0.9086
    p = -50.952e-5 / theta**2 + 185.5e-3 * h**2 + 0.0538e-4 * h / theta + 53.3e-3 / theta + 0.2895 * h + 0.9236
    q = -6.2042e-5 / theta**2 + 9.0889e-3 * h**2 - 4.0964e-4 * h / theta + 7.8297e-3 / theta - 0.1472 * h + 0.6904
    shape = length * (u / s) ** 2 + mixed * u / s + p * (1 + q * tan(turn) ** 2)
    assert S1.foundation_compliance(roll) == pytest.approx(cos(turn) ** 2 / (2.05e11 * 0.01) * shape, rel=1e-12)


def test_foundation_compliance_keeps_its_golden_value() -> None:
    assert S1.foundation_compliance(0.3) == pytest.approx(3.2110644939541287e-09, rel=1e-12)


def test_foundation_of_a_tooth_rooted_on_the_involute_starts_where_the_involute_does() -> None:
    # 60 teeth: the root circle lies above the base circle, and the root is the involute's angle there, not the base's.
    tooth = replace(S1, teeth=60)
    assert tooth.root_radius > tooth.base_radius
    roll = sqrt((tooth.root_radius / tooth.base_radius) ** 2 - 1)
    x, half = tooth.outline(np.array(roll))
    shallow = replace(tooth, height=tooth.tip_radius - tooth.base_radius)
    assert np.arctan2(half, x) < tooth.base_half_angle
    assert tooth.foundation_compliance(0.4) != pytest.approx(shallow.foundation_compliance(0.4), rel=1e-3)
