"""Trains whose motion between the flanks is known in closed form, and every reading of the equations."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain, Mesh, Variant
from seat_gear_dynamics.motion import System

STEEL_SHAFT = 2.6e4  # N·m/rad: 16 mm by 20 mm


def eccentric(train: GearTrain) -> GearTrain:
    """Give the four gears different runout."""
    gears = [replace(g, eccentricity=(5 + 3 * i) * 1e-6, eccentricity_phase=0.3 * i) for i, g in enumerate(train.gears)]
    first, second = train.meshes
    return replace(train, meshes=(moved(first, gears[0], gears[1]), moved(second, gears[2], gears[3])))


def moved(mesh: Mesh, driver: object, driven: object) -> Mesh:
    return replace(mesh, driver=driver, driven=driven)  # type: ignore[arg-type]


VARIANTS: dict[str, Callable[[GearTrain], GearTrain]] = {
    "default": lambda t: t,
    "eccentric on a shaft": lambda t: eccentric(t).with_shaft(STEEL_SHAFT),
    "torsion as printed": lambda t: replace(t, variant=Variant(False, False)),
    "damping in contact": lambda t: replace(t, variant=Variant(True, True)),
    "printed, in contact, on a shaft": lambda t: replace(t, variant=Variant(False, True)).with_shaft(STEEL_SHAFT),
}


@pytest.fixture(params=list(VARIANTS))
def variant(request: pytest.FixtureRequest, train: GearTrain) -> GearTrain:
    """The train of fixed parameters in each reading."""
    return VARIANTS[request.param](train)


@pytest.fixture(scope="session")
def contact_damped(train: GearTrain) -> GearTrain:
    """The train whose mesh damping acts in contact only, so that the force jumps where contact changes."""
    return replace(train, variant=Variant(True, True))


@pytest.fixture(scope="session")
def floating(make_train: Callable[..., GearTrain], steady: Callable[[GearTrain], GearTrain]) -> System:
    """Nothing but two teeth pairs with backlash: no support to speak of, no damping, no error, no load.

    δ of each mesh then flies at constant speed between the flanks, which lie at ±1 b_c, and swings on them.
    """
    softest = {"*damping_ratio": 0, "*.error_amplitude": [0], "*.error_phase": [0], "gears.*.torsional_stiffness": 0}
    train = steady(make_train(softest | {"gears.*.support_stiffness": 1e-6}))
    return System(train).at(frequency=0.5, load=0.0)


@pytest.fixture(scope="session")
def swing(floating: System) -> NDArray[np.float64]:
    """Angular frequency of δ of each mesh of `floating` on a flank, per unit of τ, (2,)."""
    c, train = floating.coefficients, floating.train
    kappa = np.array([m.mean_model_stiffness for m in train.meshes]) / train.meshes[0].mean_model_stiffness
    return np.asarray(np.sqrt(kappa * (c.direction * c.reaction).reshape(2, 6).sum(axis=1)))
