"""The condensed balance of P12: exact frequency response, derivatives, variants, and what is refused."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.studies.harmonic_balance import PARAMETERS, Conditions, Orbit, pair
from seat_gear_dynamics.studies.harmonic_balance.balance import Balance, balance
from seat_gear_dynamics.studies.harmonic_balance.first_motion import first_motion
from seat_gear_dynamics.studies.harmonic_balance.fourier import Basis, amplitudes

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
MakeTrain = Callable[..., GearTrain]


def frequency_response(train: GearTrain, frequency: float, error: complex) -> Complex:
    """Return the amplitudes of x1, y1, u1, x2, y2, u2 over b_c under an error of one frequency, teeth in contact.

    Assembled in SI units from the train as `test_tangent.least_decay` does, and solved by linear algebra.
    """
    mesh = train.meshes[0]
    gears = (mesh.driver, mesh.driven)
    mass = np.array([m for g in gears for m in (g.mass, g.mass, g.equivalent_mass)])
    stiff = np.array([k for g in gears for k in (g.support_stiffness, g.support_stiffness, g.torsional_stiffness)])
    zeta = np.array(
        [z for g in gears for z in (g.support_damping_ratio, g.support_damping_ratio, g.torsional_damping_ratio)]
    )
    s, c = np.sin(mesh.driver.pressure_angle), np.cos(mesh.driver.pressure_angle)
    w = np.array([-s, c, 1, s, -c, 1])
    omega = frequency * train.derived_time_scale
    contact = mesh.mean_model_stiffness + 1j * omega * mesh.damping
    dynamic = np.diag(stiff - mass * omega**2 + 2j * omega * zeta * np.sqrt(stiff * mass)) + contact * np.outer(w, w)
    return np.asarray(np.linalg.solve(dynamic, contact * w * error))


def solved(system: System, harmonics: int = 8, subharmonics: int = 1) -> Orbit:
    made, conditions = pair(system)
    problem = balance(made, conditions, harmonics=harmonics, subharmonics=subharmonics)
    return Orbit(problem, conditions, first_motion(system, problem, conditions.frequency))


@pytest.mark.parametrize("frequency", [0.3, 0.7, 1.3])
def test_steady_mesh_in_contact_has_the_exact_frequency_response(
    make_train: MakeTrain, steady: Callable[[GearTrain], GearTrain], frequency: float
) -> None:
    train = steady(make_train({"*.error_amplitude": [0.5, 0.3], "*.error_phase": [0.4, 2.0]}))
    orbit = solved(System(train).at(frequency=frequency, load=1500.0))
    assert orbit.contact_state == "no loss"
    phase = np.arange(16) / 16
    expected = np.tile(System(train).at(load=1500.0).static_state()[:6], (16, 1))
    for order, (size, angle) in enumerate(((0.5, 0.4), (0.3, 2.0)), start=1):
        error = -1j * size * 1e-6 / train.model.displacement_scale * np.exp(1j * angle)
        turning = np.exp(2j * np.pi * order * phase)
        expected += (turning[:, None] * frequency_response(train, order * frequency, error)).real
    # u is the small difference of torque and mesh force over a soft support: rounding of what each alone would turn.
    c = System(train).coefficients
    alone = 1500.0 * np.abs(c.drive[[2, 5]] / c.stiffness[[2, 5]]).max()
    assert np.abs(orbit.states(phase)[:, :6] - expected).max() < 1e-15 * alone


def test_an_eccentric_gear_shakes_the_mesh_once_a_turn(
    make_train: MakeTrain, steady: Callable[[GearTrain], GearTrain]
) -> None:
    described = {"gears.s1.eccentricity": 2, "gears.s1.eccentricity_phase": 0.7, "*.error_amplitude": [0, 0]}
    train = steady(make_train(described))
    orbit = solved(System(train).at(frequency=0.9, load=1500.0), harmonics=1, subharmonics=17)
    shaken = frequency_response(train, 0.9 / 17, -1j * 0.2 * np.exp(0.7j))
    w = orbit.balance.pair.direction
    delta = w @ shaken + 1j * 0.2 * np.exp(0.7j)
    assert amplitudes(orbit.coefficients)[1] == pytest.approx(delta, abs=1e-10)  # TOLERANCE of the balance
    assert np.abs(amplitudes(orbit.coefficients)[2:]).max() < 1e-10


def test_an_eccentric_gear_needs_whole_turns(make_train: MakeTrain) -> None:
    train = make_train({"gears.s2.eccentricity": 20})
    with pytest.raises(ValueError, match="comes round in 40 mesh periods, the motion in 17"):
        solved(System(train).at(frequency=0.9, load=600.0), subharmonics=17)


def test_the_mean_carries_the_load(train: GearTrain) -> None:
    # Over a period nothing accelerates: each torsional line's mean force is the torque less what its support takes.
    system = System(train).at(frequency=0.5, load=100.0)
    orbit = solved(system, harmonics=24)
    c, states = system.coefficients, orbit.states(np.arange(1024) / 1024)
    force = amplitudes(orbit.balance.basis.coefficients(orbit.force(orbit.balance.basis.phases)))[0].real
    for i in (2, 5):
        balance_of_means = 100.0 * c.drive[i] - c.stiffness[i] * states[:, i].mean() - c.reaction[i] * force
        # The force is sampled plainly here, with the second power of 384 samples.
        assert balance_of_means == pytest.approx(0.0, abs=1e-5 * c.reaction[i])


@pytest.mark.parametrize("parameter", PARAMETERS)
@pytest.mark.parametrize(("in_torsion", "contact_only"), [(True, False), (False, False), (True, True), (False, True)])
def test_derivatives_are_those_of_the_residual(
    train: GearTrain, parameter: str, in_torsion: bool, contact_only: bool
) -> None:
    made, conditions = pair(System(train).at(frequency=0.6, load=100.0))
    made = replace(made, backlash_in_torsion=in_torsion, damping_in_contact_only=contact_only)
    problem = Balance(made, conditions, Basis(4, 4096), 2, parameter)
    unknowns = np.random.default_rng(5).normal(size=problem.basis.size) * 0.3
    unknowns[0] = 0.9
    value = getattr(conditions, parameter)
    _, jacobian, slope = problem.evaluate(unknowns, value)
    step = 1e-6
    columns = [
        (problem.evaluate(unknowns + step * e, value)[0] - problem.evaluate(unknowns - step * e, value)[0]) / (2 * step)
        for e in np.eye(problem.basis.size)
    ]
    # Corners are weighed to the third power of a cell in the residual, to the second in its derivative: 4096^-2·2π·…
    assert np.abs(jacobian - np.array(columns).T).max() < 1e-4 * np.abs(jacobian).max()
    higher, lower = (problem.evaluate(unknowns, value * (1 + s * step))[0] for s in (1, -1))
    assert np.abs(slope - (higher - lower) / (2 * step * value)).max() < 1e-4 * np.abs(slope).max()


def test_printed_torsion_pulls_through_the_backlash(train: GearTrain) -> None:
    # With δ in the torsional lines the load is carried at δ = F/κ̄ instead of half a backlash beyond it.
    printed = replace(train, variant=replace(train.variant, backlash_in_torsion=False))
    whole, through = (solved(System(t).at(frequency=0.02, load=600.0)).coefficients[0] for t in (train, printed))
    assert whole - through > 0.5 * train.meshes[0].backlash / 2 / train.model.displacement_scale


def test_a_train_that_nothing_holds_carries_its_load_in_the_mesh(make_train: MakeTrain) -> None:
    undamped = {"gears.*.torsional_damping_ratio": 0}  # a ratio's damping falls only with the root of the stiffness
    free = make_train(undamped | {"gears.*.torsional_stiffness": 0})
    held = make_train(undamped | {"gears.*.torsional_stiffness": 1e-3})
    found = [solved(System(t).at(frequency=0.5, load=100.0), harmonics=16) for t in (free, held)]
    # A spring of 1e-3 N/m against a mesh of 2e8.
    assert found[0].coefficients == pytest.approx(found[1].coefficients, abs=1e-9)
    assert found[0].states(0.25)[:6] @ found[0].balance.pair.direction == pytest.approx(
        float(found[0].deflection(0.25)) + found[0].balance.pair.error.value(0.25), abs=1e-4
    )  # δ of the states is short of the force's harmonics above the 16th


def test_a_coupled_train_is_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="harmonic balance follows P12 alone"):
        pair(System(train.with_shaft(2.6e4)).at(frequency=0.5))


@pytest.mark.parametrize("frequency", [0.0, -0.5, float("nan")])
def test_only_forward_drives_have_a_balance(train: GearTrain, frequency: float) -> None:
    with pytest.raises(ValueError, match="frequency is"):
        Conditions(frequency, 600.0, 0.07, 2e-5)


@pytest.mark.parametrize(("name", "value"), [("damping_ratio", -0.1), ("backlash", float("nan"))])
def test_impossible_conditions_are_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"The {name} is"):
        Conditions(0.5, 600.0, 0.07, 2e-5).with_value(name, value)


def test_a_strange_parameter_is_refused(train: GearTrain) -> None:
    made, conditions = pair(System(train).at(frequency=0.5))
    with pytest.raises(ValueError, match="expected one of frequency, load"):
        balance(made, conditions, harmonics=8, parameter="speed")


def test_an_error_beyond_the_harmonics_kept_is_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="ask for more harmonics"):
        solved(System(train).at(frequency=0.5), harmonics=1)


def test_a_motion_of_no_period_is_refused(train: GearTrain) -> None:
    made, conditions = pair(System(train).at(frequency=0.5))
    with pytest.raises(ValueError, match="expected 1 or more"):
        Balance(made, conditions, Basis(8, 64), subharmonics=0)
