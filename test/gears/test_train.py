"""The train as a whole: speeds, static forces, scales and immutability."""

import pickle
from dataclasses import FrozenInstanceError, fields, is_dataclass
from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain, load_train
from seat_gear_dynamics.gears.units import RPM

TRAIN = load_train()


@pytest.mark.parametrize(("frequency", "rpm"), [(1.29, 1349), (1.30, 1359), (1.52, 1589), (1.97, 2060)])
def test_published_pairs_of_frequency_and_speed_agree_when_rounded(
    train: GearTrain, frequency: float, rpm: int
) -> None:
    # 1348.89, 1359.34, 1589.38 and 2059.93: each rounds to what the paper prints, in either direction.
    assert round(train.speed(frequency) / RPM) == rpm
    assert round(train.frequency(rpm * RPM), 2) == frequency


@given(st.floats(-3, 3))
def test_frequency_and_speed_are_each_others_inverse(frequency: float) -> None:
    assert TRAIN.frequency(TRAIN.speed(frequency)) == pytest.approx(frequency, rel=1e-12, abs=1e-300)


def test_derived_time_scale_is_equation_15(train: GearTrain) -> None:
    expected = sqrt(2.234e8 * (0.01198**2 / 3.13e-6 + 0.02819**2 / 5.5485e-5))
    assert train.derived_time_scale == pytest.approx(expected, rel=1e-12)
    assert train.derived_time_scale == pytest.approx(1.1594e5, rel=1e-4)


def test_derived_time_scale_puts_unit_frequency_at_65129_rpm(train: GearTrain) -> None:
    assert train.derived_time_scale / 17 / RPM == pytest.approx(65129, abs=2)


def test_static_chain_gives_5652_newtons_at_300_newton_metres(train: GearTrain) -> None:
    first, second = train.static_forces(300.0)
    assert first == pytest.approx(300 * 0.01597 / (0.03007 * 0.02819), rel=1e-12)
    assert round(first) == 5652
    assert second == pytest.approx(300 / 0.03007, rel=1e-12)


def test_static_force_agrees_with_the_published_averages_within_five_per_cent(train: GearTrain) -> None:
    for average in (5395, 5459, 5655):
        assert train.static_forces(300.0)[0] == pytest.approx(average, rel=0.05)


@given(st.floats(-1000, 1000))
def test_static_forces_are_proportional_to_the_load(load: float) -> None:
    unit = TRAIN.static_forces(1.0)
    assert TRAIN.static_forces(load) == pytest.approx((load * unit[0], load * unit[1]), rel=1e-12)


def test_mesh_damping_is_equation_2_with_the_gears_masses(train: GearTrain) -> None:
    assert train.meshes[0].damping == pytest.approx(2 * 0.07 * sqrt(2.234e8 / (1 / 0.04 + 1 / 0.18)), rel=1e-12)


def test_equivalent_mass_is_inertia_over_base_radius_squared(train: GearTrain) -> None:
    assert train.gears[0].equivalent_mass == pytest.approx(3.13e-6 / 0.01198**2, rel=1e-12)


def test_inertias_of_the_table_are_those_of_steel_discs_in_kilogram_square_metres(train: GearTrain) -> None:
    # Erratum 1: read in kg·mm² as printed they would be a million times too light.
    for gear in train.gears:
        disc = 7850 * 3.14159 * gear.tooth.pitch_radius**4 * gear.face_width / 2
        assert 0.5 < gear.inertia / disc < 1.5


def test_another_damping_or_backlash_changes_that_mesh_alone(train: GearTrain) -> None:
    changed = train.with_mesh(1, damping_ratio=0.2, backlash=5e-6)
    assert (changed.meshes[1].damping_ratio, changed.meshes[1].backlash) == (0.2, 5e-6)
    assert changed.meshes[0] is train.meshes[0]
    kept = train.with_mesh(0, damping_ratio=0.01)
    assert (kept.meshes[0].damping_ratio, kept.meshes[0].backlash) == (0.01, train.meshes[0].backlash)
    assert train.meshes[1].damping_ratio == 0.07


def test_gears_come_in_the_order_of_the_drive(train: GearTrain) -> None:
    assert [gear.name for gear in train.gears] == ["s1", "s2", "s3", "s4"]
    assert [gear.teeth for gear in train.gears] == [17, 40, 17, 32]


@pytest.mark.parametrize("part", ["train", "mesh", "gear", "model", "band", "provenance", "tooth", "harmonic"])
def test_no_part_of_a_train_can_be_changed(train: GearTrain, part: str) -> None:
    mesh = train.meshes[0]
    parts = {
        "train": train,
        "mesh": mesh,
        "gear": mesh.driver,
        "model": train.model,
        "band": train.bands[0],
        "provenance": next(iter(train.provenance.values())),
        "tooth": mesh.driver.tooth,
        "harmonic": mesh.error_harmonics[0],
    }
    chosen = parts[part]
    assert is_dataclass(chosen)
    with pytest.raises(FrozenInstanceError):
        setattr(chosen, fields(chosen)[0].name, None)


def test_a_train_survives_the_way_to_another_process(train: GearTrain) -> None:
    assert pickle.loads(pickle.dumps(train)) == train


def test_the_computed_stiffness_that_all_callers_share_cannot_be_changed(train: GearTrain) -> None:
    stiffness = train.meshes[0].computed_stiffness
    with pytest.raises(ValueError, match="read-only"):
        stiffness.values[0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        stiffness.phase[0] = 1.0
