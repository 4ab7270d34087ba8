"""Floquet multipliers against Liouville's formula, Mathieu's equation, the nonlinear flow and the march's tangent."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b

from seat_gear_dynamics.gears import GearTrain, PeriodicSeries
from seat_gear_dynamics.motion import System, integrate
from seat_gear_dynamics.studies.harmonic_balance import Orbit, pair
from seat_gear_dynamics.studies.harmonic_balance.balance import balance
from seat_gear_dynamics.studies.harmonic_balance.first_motion import first_motion
from seat_gear_dynamics.studies.harmonic_balance.orbit import state_of_train
from seat_gear_dynamics.studies.harmonic_balance.stability import monodromy, multipliers

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]

OWN = np.r_[0:6, 12:18]
"""P12's part of the train's state."""


def orbit_of(system: System, harmonics: int = 32) -> Orbit:
    made, conditions = pair(system)
    problem = balance(made, conditions, harmonics=harmonics)
    return Orbit(problem, conditions, first_motion(system, problem, conditions.frequency))


def variant(train: GearTrain, **change: bool) -> GearTrain:
    return replace(train, variant=replace(train.variant, **change))


def flow(system: System, state: Array) -> Array:
    """Return P12's state after a mesh period, by an outside solver on the plain right-hand side."""
    period = 2 * np.pi / system.operating_point.frequency
    found = solve_ivp(
        system.derivative, (0, period), state, method="DOP853", rtol=1e-10, atol=1e-12, max_step=period / 200
    )
    return np.asarray(found.y[OWN, -1])


@pytest.mark.parametrize("contact_only", [False, True])
def test_volume_shrinks_by_liouvilles_formula(train: GearTrain, contact_only: bool) -> None:
    # det M = exp ∫ tr A dτ: supports damp all the time, the mesh all the time or while teeth touch; the saltation at
    # a jump of the force has determinant 1.
    changed = variant(train, damping_in_contact_only=contact_only)
    orbit = orbit_of(System(changed).at(frequency=0.6, load=100.0))
    assert orbit.contact_loss > 0.1
    made = orbit.balance.pair
    share = 1 - orbit.contact_loss if contact_only else 1.0
    c = made.mesh_damping(orbit.conditions) * float(made.direction @ made.reaction)
    expected = -(made.damping.sum() + c * share) * orbit.period
    # Runge-Kutta of fourth order with steps of 0.06.
    assert np.log(np.linalg.det(monodromy(orbit))) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("change", [{}, {"backlash_in_torsion": False}, {"damping_in_contact_only": True}])
def test_disturbances_grow_as_those_of_the_nonlinear_motion(train: GearTrain, change: dict[str, bool]) -> None:
    system = System(variant(train, **change)).at(frequency=0.6, load=100.0)
    orbit = orbit_of(system, 64)
    assert orbit.contact_loss > 0.1
    start = state_of_train(orbit, system.static_state())
    step, matrix = 1e-5, monodromy(orbit)
    for direction in (OWN[1], OWN[8]):
        unit = np.zeros(24)
        unit[direction] = step
        grown = (flow(system, start + unit) - flow(system, start - unit)) / (2 * step)
        column = matrix[:, list(OWN).index(direction)]
        # 64 harmonics place the instants of parting to 1e-5, and the motion's curvature there adds as much.
        assert np.abs(grown - column).max() < 1e-3 * np.abs(column).max()


def test_largest_multiplier_is_the_growth_of_the_marchs_tangent(make_train: MakeTrain) -> None:
    # Soft torsional supports would leave the slowest mode in charge; stiff ones let one pair of multipliers lead.
    train = make_train({"*.torsional_stiffness": 2e7, "*.torsional_damping_ratio": 0.2, "*damping_ratio": 0.1})
    system = System(train).at(frequency=0.8, load=100.0)
    orbit = orbit_of(system)
    response = integrate(system, transient=300, periods=600, state=state_of_train(orbit, system.static_state()))
    # A complex pair makes the growth swing; over 600 periods the swing's share of the mean is below 1/600.
    found = response.growth[:, 0].mean()
    assert found == pytest.approx(np.log(abs(multipliers(orbit)[0])), abs=2e-3)
    assert found < 0


def mathieu(train: GearTrain, frequency: float, depth: float) -> Orbit:
    """Return an orbit whose multipliers are those of y″ + (1 + depth·cos Ωτ)·y = 0, and of what does not move."""
    made, conditions = pair(System(train).at(frequency=frequency, load=600.0))
    still = replace(
        made,
        stiffness=np.zeros(6),
        damping=np.zeros(6),
        reaction=made.reaction * (np.arange(6) % 3 == 2),
        damping_per_ratio=0.0,
        kappa=PeriodicSeries(1.0, (depth,), (0.0,)),
        error=PeriodicSeries(0.0, (0.0,), (0.0,)),
    )
    problem = balance(still, conditions, harmonics=1)
    return Orbit(problem, conditions, np.array([100.0, 0.0, 0.0]))


@pytest.mark.parametrize(("q", "upper"), [(0.3, False), (0.3, True), (0.5, False), (0.5, True), (2.0, True)])
def test_edges_of_the_first_instability_are_mathieus(train: GearTrain, q: float, upper: bool) -> None:
    # With t = Ωτ/2 this is y″ + (a - 2q cos 2t)·y = 0, a = 4/Ω², q = -2·depth/Ω² (Abramowitz & Stegun 1964, 20.1.1);
    # on its characteristic curves a1, b1 a solution is periodic over twice the mesh period: multiplier -1.
    a = float(mathieu_a(1, q) if upper else mathieu_b(1, q))
    frequency = 2 / np.sqrt(a)
    found = multipliers(mathieu(train, frequency, -q * frequency**2 / 2), longest_step=0.01)
    # A double multiplier splits with the root of the error, which with steps of 0.01 is of the order 1e-9.
    assert np.abs(found + 1).min() < 1e-4
    assert np.abs(found).max() < 1 + 1e-4


def test_between_the_edges_the_linear_pair_is_unstable(train: GearTrain) -> None:
    a = float(mathieu_a(1, 0.3) + mathieu_b(1, 0.3)) / 2
    found = multipliers(mathieu(train, 2 / np.sqrt(a), -0.3 * 2 / a))
    assert np.abs(found).max() > 1.1


def test_a_parametrically_unstable_train_diverges_as_its_multipliers_say(make_train: MakeTrain) -> None:
    # No backlash, little damping: linear, and unstable where Ω is near twice the mesh's own frequency.
    train = make_train({"*damping_ratio": 0.002, "*.backlash": 0})
    growth = {}
    for frequency in np.linspace(1.8, 3.0, 13):
        system = System(train).at(frequency=float(frequency), load=600.0)
        growth[float(frequency)] = float(np.log(abs(multipliers(orbit_of(system, 8))[0])))
    worst = max(growth, key=lambda f: growth[f])
    assert growth[worst] > 0.1
    system = System(train).at(frequency=worst, load=600.0)
    found = integrate(system, transient=30, periods=60).growth[:, 0]
    assert found.mean() == pytest.approx(growth[worst], rel=0.01)  # the start's share of 90 periods


def test_crossings_are_where_the_deflection_leaves_the_backlash(train: GearTrain) -> None:
    orbit = orbit_of(System(train).at(frequency=0.6, load=100.0))
    half = orbit.balance.pair.half_backlash(orbit.conditions)
    assert len(orbit.crossings) == 4
    assert np.abs(orbit.deflection(orbit.crossings)) == pytest.approx(half, abs=1e-9)
    fine = np.arange(200_000) / 200_000
    assert orbit.contact_loss == pytest.approx((np.abs(orbit.deflection(fine)) < half).mean(), abs=1e-5)
