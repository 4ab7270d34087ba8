"""One operating point from drive to regime."""

import json
from collections.abc import Callable
from math import pi

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System, integrate
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.regimes import classify, simulate

MakeTrain = Callable[..., GearTrain]


@pytest.fixture(scope="module")
def system(train: GearTrain) -> System:
    """The train of fixed parameters under a load that keeps its teeth together."""
    return System(train).at(frequency=0.5, load=600.0)


def test_dictionary_has_the_fields_that_programs_rely_on_and_is_json(system: System) -> None:
    found = simulate(system, transient=100, periods=64).as_dict()
    assert {"regime", "period", "lyapunov", "meshes", "frequency", "speed_rpm", "load"} <= set(found)
    assert set(found["meshes"]) == {"s1_s2", "s3_s4"}
    for force in found["meshes"].values():
        assert {"mean", "min", "max", "rms", "contact_loss"} <= set(force)
        assert force["min"] <= force["mean"] <= force["rms"] <= force["max"]
        assert 0 <= force["contact_loss"] <= 1
    assert found["regime"] in ("periodic", "quasi-periodic", "chaotic", "undecided")
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_period_is_an_integer_for_periodic_motion_and_null_otherwise(make_train: MakeTrain) -> None:
    # Stiff, damped supports settle at once; too few periods are undecided.
    settled = System(make_train({"*damping_ratio": 0.3, "*.torsional_stiffness": 2e7})).at(frequency=0.5, load=600.0)
    found = simulate(settled, transient=200, periods=64).as_dict()
    assert (found["regime"], found["period"]) == ("periodic", 1)
    assert found["lyapunov"] < 0
    short = simulate(settled, transient=200, periods=20).as_dict()
    assert (short["regime"], short["period"], short["lyapunov"]) == ("undecided", None, None)


def test_result_is_the_integration_and_its_classification_in_newtons(system: System) -> None:
    found = simulate(system, frequency=0.9, load=100.0, transient=50, periods=64)
    response = integrate(system.at(frequency=0.9, load=100.0), transient=50, periods=64)
    assert found.response.section.tolist() == response.section.tolist()
    assert found.regime == classify(response.section, response.growth[:, 0], 2 * pi / 0.9)
    force = found.meshes["s1_s2"]
    assert force.mean == response.windows[0].mean * response.force_unit
    assert (force.min, force.max) == tuple(
        v * response.force_unit for v in (response.windows[0].minimum, response.windows[0].maximum)
    )
    assert force.contact_loss == response.windows[0].contact_loss > 0


def test_static_force_is_that_of_the_torque_as_stated_and_the_mean_that_of_the_load_scale(system: System) -> None:
    found = simulate(system, transient=300, periods=200)
    for force, static in zip(found.meshes.values(), system.train.static_forces(600.0), strict=True):
        assert force.static == static
        assert force.mean == pytest.approx(found.load_scale * static, rel=5e-3)


def test_speed_and_frequency_give_the_same_result(system: System) -> None:
    by_speed = simulate(system, speed=1359 * RPM, transient=5, periods=16)
    by_frequency = simulate(system, frequency=system.train.frequency(1359 * RPM), transient=5, periods=16)
    assert by_speed.as_dict() == by_frequency.as_dict()
    assert by_speed.speed_rpm == pytest.approx(1359, rel=1e-12)


def test_damping_and_backlash_replace_those_of_both_meshes(system: System) -> None:
    found = simulate(system, damping=0.2, backlash=5e-6, transient=5, periods=16)
    for mesh in found.response.system.train.meshes:
        assert (mesh.damping_ratio, mesh.backlash) == (0.2, 5e-6)
    assert system.train.meshes[0].damping_ratio == 0.07


def test_without_backlash_the_teeth_never_part(system: System) -> None:
    found = simulate(system, load=1.0, frequency=0.9, backlash=0.0, transient=20, periods=40)
    assert all(force.contact_loss < 1e-3 for force in found.meshes.values())
    loose = simulate(system, load=1.0, frequency=0.9, transient=20, periods=40)
    assert loose.meshes["s1_s2"].contact_loss > 0.1


def test_reversed_load_mirrors_the_force_of_an_error_free_mesh(make_train: MakeTrain) -> None:
    system = System(make_train({"*.error_amplitude": [0, 0]}))
    forward = simulate(system, load=300.0, transient=10, periods=20).meshes["s1_s2"]
    backward = simulate(system, load=-300.0, transient=10, periods=20).meshes["s1_s2"]
    assert (backward.mean, backward.max, backward.min) == pytest.approx((-forward.mean, -forward.min, -forward.max))


@pytest.mark.parametrize("name", ["damping", "backlash"])
@pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf")])
def test_impossible_damping_or_backlash_is_refused_by_name_and_value(system: System, name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"The {name} is {value!r}, expected a finite number of at least 0"):
        simulate(system, **{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("drive", [{"frequency": float("nan")}, {"load": float("inf")}, {"frequency": 0.0}])
def test_impossible_drives_are_refused(system: System, drive: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"expected a finite number|frequency is 0"):
        simulate(system, **drive)  # type: ignore[arg-type]


@pytest.mark.parametrize("start", [float("nan"), float("inf"), 1e12])
def test_motion_from_no_finite_state_is_a_divergence_and_not_a_regime(system: System, start: float) -> None:
    with pytest.raises(DivergedError):
        integrate(system, transient=1, periods=1, state=np.full(24, start))
