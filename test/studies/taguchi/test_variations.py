"""The factors of the gear train: read from a system, put into it, and left out where there is nothing to vary."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.studies.taguchi import CONTROLS, NOISE, Variation

ABSOLUTE = ("damping ratio", "backlash", "load", "speed", "eccentricity")


@pytest.fixture
def system(train: GearTrain) -> System:
    return System(train).at(frequency=0.5, load=600.0)


def named(name: str) -> Variation:
    return next(variation for variation in (*CONTROLS, *NOISE) if variation.name == name)


def eccentric(system: System, micrometres: float) -> System:
    return named("eccentricity").apply(system, micrometres)


def test_names_are_different() -> None:
    names = [variation.name for variation in (*CONTROLS, *NOISE)]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("control", CONTROLS, ids=lambda control: control.name)
def test_a_control_has_three_levels_and_its_start_is_the_present_system(control: Variation, system: System) -> None:
    factor = control.factor(system)
    assert factor is not None
    assert len(factor.levels) == 3
    put = control.apply(system, factor.levels[factor.start])
    assert put.train == system.train
    assert put.operating_point.load == system.operating_point.load
    # Speed goes through r/min and back: a few roundings.
    assert put.operating_point.frequency == pytest.approx(system.operating_point.frequency, rel=1e-14)


@pytest.mark.parametrize("name", ABSOLUTE)
def test_what_is_put_in_is_read_back(name: str, system: System) -> None:
    control = named(name)
    factor = control.factor(system)
    assert factor is not None
    for level in factor.levels:
        assert control.read(control.apply(system, level)) == pytest.approx(level, rel=1e-12)


@pytest.mark.parametrize("noise", NOISE, ids=lambda noise: noise.name)
def test_a_noise_factor_has_two_levels(noise: Variation, system: System) -> None:
    factor = noise.factor(system)
    assert factor is not None
    assert len(factor.levels) == 2


def test_levels_stand_around_the_present_values(system: System) -> None:
    found = {c.name: c.factor(system) for c in CONTROLS}
    levels = {name: factor.levels for name, factor in found.items() if factor is not None}
    assert levels["damping ratio"] == pytest.approx((0.035, 0.07, 0.105))
    assert levels["backlash"] == pytest.approx((10.0, 20.0, 30.0))
    assert levels["load"] == (300.0, 600.0, 900.0)
    speed = system.train.speed(0.5) / RPM
    assert levels["speed"] == pytest.approx((0.8 * speed, speed, 1.2 * speed))


def test_a_system_without_backlash_or_eccentricity_gets_the_levels_of_table_3(
    make_train: Callable[..., GearTrain],
) -> None:
    system = System(make_train({"meshes.*.backlash": 0, "gears.*.eccentricity": 0}))
    for name, levels in (("backlash", (0.0, 10.0, 30.0)), ("eccentricity", (0.0, 20.0, 40.0))):
        factor = named(name).factor(system)
        assert factor is not None
        assert (factor.levels, factor.start) == (levels, 0)


def test_a_system_without_damping_or_error_does_not_vary_them(conservative: GearTrain) -> None:
    system = System(conservative)
    for name in ("damping ratio", "transmission error", "error phase"):
        assert named(name).factor(system) is None


@given(st.floats(0.25, 4.0))
def test_other_meshes_go_along_in_ratio(train: GearTrain, ratio: float) -> None:
    system = System(train.with_mesh(1, damping_ratio=0.1, backlash=50e-6))
    first, second = system.train.meshes
    damped = named("damping ratio").apply(system, ratio * first.damping_ratio).train.meshes
    assert [m.damping_ratio for m in damped] == pytest.approx([ratio * first.damping_ratio, ratio * 0.1])
    loose = named("backlash").apply(system, ratio * first.backlash / 1e-6).train.meshes
    assert [m.backlash for m in loose] == pytest.approx([ratio * first.backlash, ratio * second.backlash])


def test_supports_error_and_tolerance_are_factors_on_what_there_is(system: System) -> None:
    before = system.train
    softer = named("support stiffness").apply(system, 0.5).train
    assert [g.support_stiffness for g in softer.gears] == [0.5 * g.support_stiffness for g in before.gears]
    louder = named("transmission error").apply(system, 1.5).train
    wider = named("backlash tolerance").apply(system, 1.1).train
    for mesh, loud, wide in zip(before.meshes, louder.meshes, wider.meshes, strict=True):
        # The error is the same curve, so its value at any phase scales.
        assert loud.transmission_error.value(0.3) == pytest.approx(1.5 * mesh.transmission_error.value(0.3))
        assert wide.backlash == pytest.approx(1.1 * mesh.backlash)


def test_the_error_is_shifted_as_a_whole(system: System) -> None:
    shift = 0.5
    moved = named("error phase").apply(system, shift).train.meshes[0].transmission_error
    # A shift of the first harmonic by 0.5 rad is one of the phase by 0.5/2π, for all harmonics alike.
    expected = system.train.meshes[0].transmission_error.value([0.1 + shift / 6.283185307179586, 0.7])
    assert moved.value([0.1, 0.7 - shift / 6.283185307179586]) == pytest.approx(expected, rel=1e-9)


def test_eccentricity_is_that_of_the_worse_gear_of_p12(system: System) -> None:
    alike = eccentric(eccentric(system, 0.0), 20.0)
    assert [gear.eccentricity for gear in alike.train.gears] == pytest.approx([20e-6] * 4)
    first, second = alike.train.meshes
    uneven = replace(
        alike,
        train=replace(alike.train, meshes=(replace(first, driver=replace(first.driver, eccentricity=5e-6)), second)),
    )
    assert named("eccentricity").read(uneven) == pytest.approx(20.0)
    assert [gear.eccentricity for gear in eccentric(uneven, 40.0).train.gears] == pytest.approx(
        [10e-6, 40e-6, 40e-6, 40e-6]
    )


def test_the_initial_gap_is_no_quantity_of_the_system(system: System) -> None:
    assert named("initial gap").apply(system, 1.0) is system
