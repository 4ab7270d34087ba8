"""Machines within tolerances: what is drawn, and that a seed gives the same machines."""

from collections.abc import Callable
from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes.regime_map import MapError, RegimeMap, fingerprint
from seat_gear_dynamics.regimes.tolerance import Tolerances, draw, with_tolerances

MakeTrain = Callable[..., GearTrain]

EXACT = Tolerances(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def drawn(train: GearTrain, seed: int, tolerances: Tolerances | None = None) -> GearTrain:
    return draw(train, tolerances or Tolerances(), np.random.default_rng(seed))


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), uniform=st.booleans())
def test_every_parameter_stays_within_its_tolerance(train: GearTrain, seed: int, uniform: bool) -> None:
    found = drawn(train, seed, Tolerances(distribution="uniform" if uniform else "normal"))
    slack = 1 + 1e-12  # rounding of 1 + deviation
    for new, old in zip(found.meshes, train.meshes, strict=True):
        assert abs(new.mean_model_stiffness / old.mean_model_stiffness - 1) <= 0.05 * slack
        assert abs(new.damping_ratio / old.damping_ratio - 1) <= 0.20 * slack
        assert abs(new.backlash - old.backlash) <= 2e-6 * slack
        for a, b in zip(new.error_harmonics, old.error_harmonics, strict=True):
            assert abs(a.amplitude / b.amplitude - 1) <= 0.10 * slack
            assert (a.phase, a.order) == (b.phase, b.order)
    for gear, nominal in zip(found.gears, train.gears, strict=True):
        assert abs(gear.support_stiffness / nominal.support_stiffness - 1) <= 0.10 * slack
        assert replace(gear, support_stiffness=nominal.support_stiffness) == nominal
    assert abs(found.model.load_scale / train.model.load_scale - 1) <= 0.05 * slack


def test_no_tolerances_give_the_machine_itself(train: GearTrain) -> None:
    assert fingerprint(drawn(train, 1, EXACT)) == fingerprint(train)


def test_a_seed_gives_the_same_machines_and_another_seed_others(train: GearTrain) -> None:
    assert drawn(train, 3) == drawn(train, 3)
    assert fingerprint(drawn(train, 3)) != fingerprint(drawn(train, 4))


def test_a_machine_does_not_depend_on_the_size_of_other_tolerances(train: GearTrain) -> None:
    # Every machine takes the same count of numbers from the generator.
    one, two = np.random.default_rng(5), np.random.default_rng(5)
    draw(train, EXACT, one)
    draw(train, Tolerances(), two)
    assert draw(train, Tolerances(), one) == draw(train, Tolerances(), two)


def test_a_stiffer_mesh_is_met_at_the_same_speed_by_a_lower_dimensionless_frequency(train: GearTrain) -> None:
    # Omega is the mesh frequency over omega_d of (15), which goes with the root of the stiffness of P12.
    found = drawn(train, 7, replace(EXACT, mesh_stiffness=0.05))
    stiffer = found.meshes[0].mean_model_stiffness / train.meshes[0].mean_model_stiffness
    assert stiffer != 1
    assert found.frequency(100.0) == pytest.approx(train.frequency(100.0) / sqrt(stiffer), rel=1e-12)


def test_a_mesh_that_keeps_its_computed_stiffness_varies_about_that(make_train: MakeTrain) -> None:
    free = make_train({"meshes.*.scale_to_mean": False})
    found = drawn(free, 2)
    for new, old in zip(found.meshes, free.meshes, strict=True):
        assert new.mean_model_stiffness == pytest.approx(old.mean_model_stiffness, rel=0.05)
        assert new.mean_model_stiffness == pytest.approx(new.stiffness.mean, rel=1e-12)
    assert fingerprint(drawn(free, 2, EXACT)) != fingerprint(free)  # scaled to the same mean, said in another way
    assert drawn(free, 2, EXACT).meshes[0].stiffness == free.meshes[0].stiffness


@pytest.mark.parametrize(
    ("distribution", "deviation"),
    # Standard deviation in half-widths: 1/√3, and half that of a normal one cut at ±2, √(1 − 4φ(2)/(2Φ(2) − 1)).
    [("uniform", 1 / sqrt(3)), ("normal", 0.5 * sqrt(1 - 4 * 0.0539909665 / 0.9544997361))],
)
def test_deviations_have_the_spread_of_their_distribution(
    train: GearTrain, distribution: str, deviation: float
) -> None:
    tolerances = Tolerances(distribution=distribution)  # type: ignore[arg-type]
    generator = np.random.default_rng(0)
    machines = [draw(train, tolerances, generator) for _ in range(1500)]
    found = np.array([m.meshes[0].damping_ratio / train.meshes[0].damping_ratio - 1 for m in machines]) / 0.20
    # Of 1500 the mean scatters by deviation/√1500 and the deviation by less than that: four of these.
    assert found.mean() == pytest.approx(0, abs=4 * deviation / sqrt(1500))
    assert found.std() == pytest.approx(deviation, abs=4 * deviation / sqrt(1500))


def test_a_backlash_smaller_than_its_tolerance_never_falls_below_nothing(make_train: MakeTrain) -> None:
    tight = make_train({"meshes.*.backlash": 0.1})
    found = [drawn(tight, seed).meshes[0].backlash for seed in range(20)]
    assert min(found) == 0.0
    assert max(found) > 0.0


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"damping_ratio": -0.1}, "tolerance of damping_ratio is -0.1, expected at least 0 and below 1"),
        ({"mesh_stiffness": 1.0}, "tolerance of mesh_stiffness is 1.0"),
        ({"backlash": float("nan")}, "tolerance of backlash is nan, expected at least 0 and below inf"),
        ({"distribution": "cauchy"}, "distribution is 'cauchy', expected normal or uniform"),
    ],
)
def test_impossible_tolerances_are_refused(change: dict[str, float], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        Tolerances(**change)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def system(make_train: MakeTrain) -> System:
    """A train whose motion turns chaotic between the two speeds of the map."""
    return System(make_train({"meshes.*.damping_ratio": 0.05}))


@pytest.fixture(scope="module")
def nominal(system: System) -> RegimeMap:
    speeds = [system.train.speed(frequency) for frequency in (0.6, 1.0)]
    return RegimeMap.compute(system, speeds, [100.0], transient=200, periods=96)


def test_without_tolerances_every_machine_says_what_the_nominal_one_says(system: System, nominal: RegimeMap) -> None:
    assert nominal.chaos.tolist() == [[0.0, 1.0]]
    found = with_tolerances(nominal, system, samples=2, seed=0, tolerances=EXACT)
    assert found.chaos.tolist() == nominal.chaos.tolist()
    assert found.samples == 2
    assert found.interval_at(float(nominal.speeds[0]), 100.0)[1] > 0.5  # two machines prove little


def test_a_seed_gives_the_same_map_whatever_the_threads(system: System, nominal: RegimeMap) -> None:
    told: list[tuple[int, int]] = []
    first = with_tolerances(nominal, system, samples=2, seed=11, workers=1, progress=lambda *done: told.append(done))
    second = with_tolerances(nominal, system, samples=2, seed=np.random.default_rng(11), workers=3)
    assert first.chaos.tolist() == second.chaos.tolist()
    assert first.codes.tolist() == nominal.codes.tolist()
    assert told == [(k, 4) for k in range(1, 5)]


def test_a_map_of_another_machine_and_no_samples_are_refused(system: System, nominal: RegimeMap) -> None:
    other = System(system.train.with_mesh(0, backlash=1e-6))
    with pytest.raises(MapError, match="of another machine than the system"):
        with_tolerances(nominal, other, samples=1, seed=0)
    with pytest.raises(ValueError, match="Asked for 0 samples, expected at least 1"):
        with_tolerances(nominal, system, samples=0, seed=0)
