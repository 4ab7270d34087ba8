"""Section 4's tables against their text, and the readings of Table 2 against Hertz."""

from math import nan, sqrt

import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.studies.contact_verification.conditions import (
    CONDITIONS,
    CONTACT_STIFFNESS,
    DAMPING,
    MEAN_STIFFNESS,
    PRINTED_DAMPING,
    TABLE_4,
    PrintedForce,
    share_at_maximum,
)
from seat_gear_dynamics.studies.contact_verification.readings import READINGS, Assumptions, contacts, hertz_ratios

# Tables 3 and 4 as the paper's text has them, without their headings.
TABLE_3_TEXT = """
Condition 1 0 0 300 132
Condition 2 20 0 300 132
Condition 3 40 0 300 132
Condition 4 0 0 300 132
Condition 5 0 10 300 132
Condition 6 0 30 300 132
Condition 7 20 30 100 132
Condition 8 20 30 300 132
Condition 9 20 30 600 132
Condition 10 0 30 300 60
Condition 11 0 30 300 300
"""
TABLE_4_TEXT = """
Condition 4 3890 6752 5395 5424
Condition 5 3894 6823 5459 5488
Condition 6 3888 21480 5655 5826
"""


def rows(text: str) -> dict[int, list[float]]:
    split = [line.split()[1:] for line in text.strip().splitlines()]
    return {int(number): [float(value) for value in values] for number, *values in split}


def test_conditions_are_table_3() -> None:
    found = {
        number: [c.eccentricity * 1e6, c.backlash * 1e6, c.load, c.speed / RPM] for number, c in CONDITIONS.items()
    }
    assert list(found) == list(rows(TABLE_3_TEXT))
    for number, values in rows(TABLE_3_TEXT).items():
        assert found[number] == pytest.approx(values, rel=1e-12)
        assert CONDITIONS[number].number == number


def test_forces_are_table_4() -> None:
    found = {number: [row.minimum, row.maximum, row.mean, row.rms] for number, row in TABLE_4.items()}
    assert found == rows(TABLE_4_TEXT)


def test_a_condition_names_itself_in_the_papers_units() -> None:
    name = "condition 7: eccentricity 20 µm, backlash 30 µm, 100 N·m, 132 r/min"
    assert CONDITIONS[7].name == name


def test_damping_is_stiffness_over_2000_but_for_the_printed_exponent() -> None:
    # To the four digits printed.
    assert [k / 2000 for k in CONTACT_STIFFNESS] == pytest.approx(list(DAMPING), rel=5e-4)
    assert PRINTED_DAMPING[1] / DAMPING[1] == pytest.approx(10)


def test_mean_and_rms_give_the_deviation() -> None:
    assert PrintedForce(0, 5, 3, 5).deviation == 4


def test_share_at_the_maximum_is_that_of_a_two_level_signal() -> None:
    # A share s at M and the rest at 0, held against a calm of no deviation: mean s·M, square mean s·M².
    share, top = 0.02, 1000.0
    row = PrintedForce(0.0, top, share * top, top * sqrt(share))
    # variance/(M − mean)² = s·(1 − s)/(1 − s)², where the mean itself is moved by the peaks.
    assert share_at_maximum(row, PrintedForce(0, 0, 0, 0)) == pytest.approx(share / (1 - share), rel=1e-12)


def test_printed_contact_stiffness_is_hertz_in_millimetres(train: GearTrain) -> None:
    first, second = hertz_ratios(train)
    assert first == pytest.approx(1.0, abs=0.03)
    assert second == pytest.approx(1.0, abs=0.03)
    # Steel drops out of the quotient: the square root of the pairs' relative radii, to the digits printed.
    quotient = sqrt((17 * 32 * 2 / 49) / (17 * 40 * 1.5 / 57))
    assert CONTACT_STIFFNESS[1] / CONTACT_STIFFNESS[0] == pytest.approx(quotient, rel=2e-3)


@pytest.mark.parametrize(
    ("reading", "micrometres"), [("hertz", 53.8), ("linear", 12.5), ("metre", 538), ("mesh", 40.8)]
)
def test_readings_penetrate_as_documented(train: GearTrain, reading: str, micrometres: float) -> None:
    contact, _ = contacts(train, Assumptions(reading=reading))
    static, _ = train.static_forces(300.0)
    assert (static / contact.stiffness) ** (1 / contact.exponent) == pytest.approx(micrometres * 1e-6, rel=5e-3)


def test_mesh_reading_has_the_mean_stiffness_over_the_mean_number_of_pairs(train: GearTrain) -> None:
    for mesh, contact, mean in zip(
        train.meshes, contacts(train, Assumptions(reading="mesh")), MEAN_STIFFNESS, strict=True
    ):
        assert contact.stiffness * mesh.contact_ratio == pytest.approx(mean, rel=1e-12)


def test_every_reading_gives_laws_with_table_2s_damping_and_friction(train: GearTrain) -> None:
    for reading in READINGS:
        laws = contacts(train, Assumptions(reading=reading))
        assert [law.damping for law in laws] == list(DAMPING)
        assert {(law.static_friction, law.dynamic_friction, law.depth) for law in laws} == {(0.23, 0.16, 1e-4)}


def test_friction_can_be_left_out(train: GearTrain) -> None:
    assert {law.static_friction for law in contacts(train, Assumptions(friction=False))} == {0.0}


def test_unknown_readings_and_impossible_values_are_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match=r"no reading 'guess'.*hertz, linear"):
        contacts(train, Assumptions(reading="guess"))
    with pytest.raises(ValueError, match="depth is nan"):
        contacts(train, Assumptions(depth=nan))
