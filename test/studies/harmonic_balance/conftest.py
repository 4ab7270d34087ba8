"""The oscillator of Kahraman & Singh as a train, and one response curve that several tests look at."""

from collections.abc import Callable
from dataclasses import fields, replace

import pytest

from seat_gear_dynamics.gears import Gear, GearTrain, Mesh, PeriodicSeries, TransmissionErrorHarmonic
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.studies.harmonic_balance import ResponseCurve, response_curve

MakeOscillator = Callable[[float, float, float], System]


class SteadyMesh(Mesh):
    """A mesh of constant stiffness: its mean at every phase."""

    @property
    def stiffness(self) -> PeriodicSeries:
        """The mean stiffness, N/m."""
        return PeriodicSeries(self.mean_model_stiffness, (0.0,), (0.0,))


@pytest.fixture(scope="session")
def oscillator(make_train: Callable[..., GearTrain]) -> MakeOscillator:
    """Make x″ + 2ζx′ + f(x) = F_m + F_ah·Ω²·sin Ωτ, b = 1, of ζ, F_m and F_ah.

    Kahraman & Singh 1990, J. Sound Vib. 142, 49-75, a spur pair of constant stiffness under its static error. Here the
    gears are too heavy to move but in rotation, and nothing holds that: x is δ/b_c, and F_ah the error over b_c.
    """
    described = make_train({"gears.*.torsional_stiffness": 0})

    def heavy(gear: Gear) -> Gear:
        return replace(gear, mass=1e9)

    def make(zeta: float, mean: float, alternating: float) -> System:
        length = described.model.displacement_scale

        def oscillating(mesh: Mesh) -> Mesh:
            copy = SteadyMesh(**{f.name: getattr(mesh, f.name) for f in fields(mesh)})
            error = (TransmissionErrorHarmonic(1, alternating * length, 0.0),)
            driver, driven = heavy(copy.driver), heavy(copy.driven)
            copy = replace(copy, driver=driver, driven=driven, backlash=2 * length, error_harmonics=error)
            unit = replace(copy, damping_ratio=1.0).damping * described.derived_time_scale / copy.mean_model_stiffness
            return replace(copy, damping_ratio=2 * zeta / unit)

        first, second = (oscillating(m) for m in described.meshes)
        system = System(replace(described, meshes=(first, second)))
        c = system.coefficients
        return system.at(load=mean * float(c.reaction[2] / c.drive[2]))

    return make


@pytest.fixture(scope="session")
def light(train: GearTrain) -> System:
    """The train of fixed parameters at 100 N·m, where teeth part at most frequencies."""
    return System(train).at(load=100.0)


@pytest.fixture(scope="session")
def curve(light: System) -> ResponseCurve:
    """Its response curve over frequency, with two pairs of folds and a period doubling."""
    return response_curve(light, 0.2, 1.0)
