"""The readings of the equations: shaft, eccentricity, torsion as printed, damping in contact only."""

from collections.abc import Callable
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from seat_gear_dynamics.gears import GearTrain, Variant
from seat_gear_dynamics.motion import STATE_NAMES, Inputs, March, System, integrate

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]
STEEL_SHAFT = 2.6e4  # N·m/rad: 16 mm by 20 mm


def eccentric(train: GearTrain) -> GearTrain:
    """Give the four gears different runout."""
    gears = [
        replace(g, eccentricity=(10 + 7 * i) * 1e-6, eccentricity_phase=0.3 * i) for i, g in enumerate(train.gears)
    ]
    first, second = train.meshes
    return replace(
        train,
        meshes=(
            replace(first, driver=gears[0], driven=gears[1]),
            replace(second, driver=gears[2], driven=gears[3]),
        ),
    )


VARIANTS: dict[str, Callable[[GearTrain], GearTrain]] = {
    "shaft": lambda t: t.with_shaft(STEEL_SHAFT),
    "eccentric": eccentric,
    "eccentric on a shaft": lambda t: eccentric(t).with_shaft(STEEL_SHAFT),
    "torsion as printed": lambda t: replace(t, variant=Variant(False, False)),
    "damping in contact": lambda t: replace(t, variant=Variant(True, True)),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_the_march_and_an_outside_solver_agree_in_every_variant(train: GearTrain, name: str) -> None:
    system = replace(
        System(VARIANTS[name](train)), operating_point=System(train).at(frequency=0.6, load=900.0).operating_point
    )
    periods = 6
    end = periods * 2 * pi / 0.6
    found = integrate(system, transient=0, periods=periods, target_steps=4096).state
    outside = solve_ivp(
        system.derivative, (0, end), system.static_state(), method="DOP853", rtol=1e-10, atol=1e-12, max_step=1.0
    ).y[:, -1]
    # A contact change costs the march an error of the order of its step squared, 6e-6 here, where the force jumps.
    tolerance = 1e-4 if name == "damping in contact" else 1e-6
    assert np.abs(found - outside).max() < tolerance * np.abs(outside).max()


@pytest.mark.parametrize("load", [600.0, -300.0, 0.0])
def test_the_shaft_carries_the_torque_that_the_print_puts_on_s2_and_s3(make_train: MakeTrain, load: float) -> None:
    train = make_train({"gears.*.torsional_stiffness": 0}).with_shaft(STEEL_SHAFT)
    state = System(train).at(frequency=0.0, load=load).static_state()
    _, s2, s3, _ = train.gears
    length = train.model.displacement_scale
    twist = state[STATE_NAMES.index("u2")] * length / s2.base_radius
    twist += state[STATE_NAMES.index("u3")] * length / s3.base_radius
    torque = load * train.model.load_scale * s3.base_radius / train.gears[3].base_radius  # T3 = T4·r3/r4
    assert -STEEL_SHAFT * twist == pytest.approx(torque, rel=1e-6, abs=1e-9)
    forces = System(train).at(frequency=0.0, load=load).mesh_forces(0.0, state)
    assert np.sign(forces).tolist() == [np.sign(load)] * 2


def test_a_coupled_train_feels_both_meshes_and_a_decoupled_one_its_own(train: GearTrain) -> None:
    other = train.with_mesh(1, damping_ratio=0.2)

    def section(t: GearTrain) -> Array:
        return integrate(System(t).at(frequency=0.6, load=600.0), transient=10, periods=5).section

    assert np.array_equal(section(train), section(other))
    assert not np.array_equal(section(train.with_shaft(STEEL_SHAFT)), section(other.with_shaft(STEEL_SHAFT)))


def test_a_coupled_train_has_one_tangent(train: GearTrain) -> None:
    response = integrate(System(train.with_shaft(STEEL_SHAFT)).at(frequency=0.6, load=600.0), transient=10, periods=50)
    assert np.array_equal(response.growth[:, 0], response.growth[:, 1])


def test_runout_repeats_with_the_revolution_of_the_gear(make_train: MakeTrain) -> None:
    # Stiff, well damped shafts settle within 200 periods; only s1 is eccentric, so that P12 has the period of 17 teeth.
    train = make_train({"*damping_ratio": 0.3, "gears.*.torsional_stiffness": 2e7, "gears.s1.eccentricity": 5})
    section = integrate(System(train).at(frequency=1.5, load=900.0), transient=204, periods=51).section
    assert np.abs(section[17:] - section[:-17]).max() < 1e-9
    assert np.abs(section[16:] - section[:-16]).max() > 1e-3


def test_an_eccentric_gear_runs_out_as_a_sine_of_its_turning(make_train: MakeTrain) -> None:
    train = make_train({"gears.s2.eccentricity": 20, "gears.s2.eccentricity_phase": 0.7})
    system, plain = System(train), System(make_train())
    for tau in (0.0, 5.0, 60.0):
        angle = 0.5 / 40 * tau + 0.7  # s2 turns once in 40 mesh periods, at Ω = 0.5
        added = plain.deflections(tau, np.zeros(24))[0] - system.deflections(tau, np.zeros(24))[0]
        assert added == pytest.approx([2.0 * np.sin(angle), 0.0], abs=1e-12)


def test_runout_is_the_same_after_the_phase_went_forth_and_back(train: GearTrain) -> None:
    march = March(eccentric(train), load=600.0)
    before = march.meshes(0.5)[:, 0]
    forth, back = Inputs(0.5, 600.0), Inputs(-0.5, 600.0)
    state = march.state
    march.advance((0.0, forth), (30.0, forth))
    march.advance((march.tau, back), (2 * march.tau - 1e-6, back))
    march.state = state
    assert march.meshes(0.5)[:, 0] == pytest.approx(before, abs=1e-12)


def test_torsion_as_printed_has_no_dead_zone(train: GearTrain) -> None:
    printed = replace(train, variant=Variant(False, False))
    load = 1.0  # static deflections of (2) far below half the backlash
    state = System(printed).at(frequency=0.0, load=load).static_state()
    closing = (System(printed).coefficients.direction * state[:12]).reshape(2, 6).sum(axis=1)
    assert np.all((closing > 0) & (closing < 0.1))
    assert np.all(np.abs(state[[0, 1, 3, 4]]) < 1e-12)  # f(δ) is 0 in the lines of x and y


def test_damping_in_contact_only_leaves_free_teeth_undamped(train: GearTrain) -> None:
    state = np.zeros(24)
    state[STATE_NAMES.index("u1'")] = 0.3  # moving within the backlash
    always = System(train).at(frequency=0.0, load=0.0)
    contact = System(replace(train, variant=Variant(True, True))).at(frequency=0.0, load=0.0)
    assert always.mesh_forces(0.0, state)[0] > 0
    assert contact.mesh_forces(0.0, state)[0] == 0


@pytest.mark.parametrize("scale", [0.0, -1.0, float("inf"), "measured"])
def test_an_impossible_time_scale_is_refused(train: GearTrain, scale: object) -> None:
    with pytest.raises(ValueError, match="expected 'published', 'derived' or a positive number"):
        train.with_time_scale(scale)  # type: ignore[arg-type]
