"""What the search may change, and how a set goes into a train and its description."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.description import parse_train
from seat_gear_dynamics.studies.calibration.describe import described
from seat_gear_dynamics.studies.calibration.freedom import FREEDOMS, apply, disc_mass, read

MakeTrain = Callable[..., GearTrain]
POSITIVE = [f for f in FREEDOMS if f.logarithmic]
MIDDLE = [float(np.sqrt(f.low * f.high)) if f.logarithmic else 0.7 for f in FREEDOMS]


@given(st.sampled_from(POSITIVE), st.floats(-20, 20))
def test_a_value_never_leaves_its_bounds_and_excess_says_by_how_much(freedom: object, coordinate: float) -> None:
    f = next(f for f in POSITIVE if f is freedom)
    value = f.value(coordinate)
    assert f.low * (1 - 1e-12) <= value <= f.high * (1 + 1e-12)
    if f.excess(coordinate) == 0:
        assert f.code(value) == pytest.approx(coordinate, abs=1e-9)
    else:
        assert abs(f.code(value) - coordinate) == pytest.approx(f.excess(coordinate), abs=1e-9)


@given(st.floats(-50, 50))
def test_a_phase_is_wrapped_and_stays_the_same_angle(coordinate: float) -> None:
    phase = next(f for f in FREEDOMS if not f.logarithmic)
    value = phase.value(coordinate)
    assert -pi <= value <= pi
    assert np.exp(1j * value) == pytest.approx(np.exp(1j * coordinate), abs=1e-9)
    assert phase.excess(coordinate) == 0


def test_a_set_that_was_applied_is_read_back(train: GearTrain) -> None:
    changed = apply(train, MIDDLE)
    assert read(changed) == pytest.approx(MIDDLE, rel=1e-12)
    assert changed.gears[2].support_stiffness == changed.gears[1].support_stiffness
    assert changed.gears[3].torsional_stiffness == changed.gears[0].torsional_stiffness
    assert changed.gears[2].mass == train.gears[2].mass


def test_what_the_paper_gives_is_left_alone(train: GearTrain) -> None:
    changed = apply(train, MIDDLE)
    for before, after in zip(train.gears, changed.gears, strict=True):
        assert (before.teeth, before.inertia, before.base_radius) == (after.teeth, after.inertia, after.base_radius)
    for first, second in zip(train.meshes, changed.meshes, strict=True):
        assert (first.damping_ratio, first.backlash, first.mean_model_stiffness) == (
            second.damping_ratio,
            second.backlash,
            second.mean_model_stiffness,
        )


def test_a_solid_steel_disc_of_s1_weighs_what_the_description_says(train: GearTrain) -> None:
    # π·(12.75 mm)²·10 mm·7850 kg/m³
    assert disc_mass(train.gears[0]) == pytest.approx(0.04009, rel=1e-3)


def test_a_set_written_into_a_description_is_the_set_that_is_read_from_it() -> None:
    from seat_gear_dynamics.gears import load_train

    packaged = load_train()
    wanted = apply(packaged, MIDDLE)
    text = described(packaged.text, wanted)
    found = parse_train(text)
    assert read(found) == pytest.approx(MIDDLE, rel=1e-5)  # six digits
    assert found.provenance["gears.s1.support_stiffness"].kind == "calibrated"
    assert found.provenance["gears.s3.support_stiffness"].kind == "chosen"
    assert found.provenance["gears.s1.teeth"].kind == "given"
    comments = [line for line in packaged.text.split("\n") if line.startswith("#")]
    assert [line for line in text.split("\n") if line.startswith("#")] == comments


def test_a_description_in_another_layout_is_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="has no line for"):
        described("name: x\n", train)
