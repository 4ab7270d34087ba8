"""Manufacturing tolerances: the regime map of many machines drawn at random, as a probability of chaos."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from seat_gear_dynamics.gears import Gear, GearTrain, Mesh
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes.map_nodes import MapGrid, map_weights
from seat_gear_dynamics.regimes.regime_map import MapError, RegimeMap
from seat_gear_dynamics.regimes.workers import Workers

Array = NDArray[np.float64]

_PER_MESH = 6  # deviations: stiffness, damping, backlash, error, and the supports of both gears


@dataclass(frozen=True)
class Tolerances:
    """Half-widths of what machines of one drawing differ by; each deviates independently for each mesh or gear.

    The paper gives none: the defaults are this project's choice of what batches of small steel gears are held to or
    differ by. `normal`: the half-width is two standard deviations, and what lies outside is rejected at inspection.
    """

    mesh_stiffness: float = 0.05
    """Of the mean, relative."""
    damping_ratio: float = 0.20
    """Of each mesh, relative."""
    backlash: float = 2e-6
    """m; a backlash that would fall below 0 is 0."""
    support_stiffness: float = 0.10
    """Of each gear, in x and y, relative."""
    transmission_error: float = 0.10
    """Of all harmonics of a mesh alike, relative; phases stay."""
    load_scale: float = 0.05
    """Relative: torque ripple and losses before the mesh, which the load at hand does not show."""
    distribution: Literal["normal", "uniform"] = "normal"

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            highest = np.inf if name == "backlash" else 1.0
            if name != "distribution" and not 0 <= value < highest:
                raise ValueError(f"The tolerance of {name} is {value!r}, expected at least 0 and below {highest:g}.")
        if self.distribution not in ("normal", "uniform"):
            raise ValueError(f"The distribution is {self.distribution!r}, expected normal or uniform.")


def draw(train: GearTrain, tolerances: Tolerances, generator: np.random.Generator) -> GearTrain:
    """Return a machine drawn within `tolerances` of `train`.

    Always 13 numbers are taken from `generator`, so that the k-th machine of a seed does not depend on how many
    follow. A stiffer mesh has a shorter time unit (15): `time_scale` goes with it, so that a speed stays that speed.
    Limit: deviations are independent of each other and the same all around a gear.
    """
    deviations = _deviations(generator, 2 * _PER_MESH + 1, tolerances.distribution)
    first, second = train.meshes
    meshes = (
        _mesh(first, tolerances, deviations[:_PER_MESH]),
        _mesh(second, tolerances, deviations[_PER_MESH : 2 * _PER_MESH]),
    )
    drawn, model = replace(train, meshes=meshes), train.model
    faster = drawn.derived_time_scale / train.derived_time_scale
    load_scale = model.load_scale * _factor(tolerances.load_scale, deviations[-1])
    return replace(drawn, model=replace(model, load_scale=load_scale, time_scale=model.time_scale * faster))


def with_tolerances(
    nominal: RegimeMap,
    system: System,
    *,
    samples: int,
    seed: int | np.random.Generator,
    tolerances: Tolerances | None = None,
    workers: Workers | int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> RegimeMap:
    """Return map `nominal` of `system` with the probability of chaos over `samples` machines drawn at random.

    Same grid, run-in and sampled periods as the nominal map, whose regimes it keeps; `tolerances` default to
    `Tolerances()`; `progress` is told (nodes done, nodes of all machines). The same seed gives the same map. Raises
    MapError where the map is of another machine, ValueError for fewer than one sample. Limit: the interval of the
    result covers the drawing of machines, not what the model leaves out.
    """
    if samples < 1:
        raise ValueError(f"Asked for {samples} samples, expected at least 1.")
    if not nominal.belongs_to(system.train):
        raise MapError("The nominal map is of another machine than the system; compute the map of this machine.")
    weight, done = np.zeros(nominal.chaos.size), 0
    grid = MapGrid(nominal.speeds, nominal.loads, nominal.transient, nominal.periods)
    for train in machines(system.train, samples, seed, tolerances):
        for found in map_weights(train, grid, workers=workers):
            for each in found:
                weight[done % weight.size] += each
                done += 1
                if progress is not None:
                    progress(done, samples * weight.size)
    return nominal.with_chaos((weight / samples).reshape(nominal.chaos.shape), samples)


def machines(
    train: GearTrain, samples: int, seed: int | np.random.Generator, tolerances: Tolerances | None = None
) -> Iterator[GearTrain]:
    """Yield `samples` machines drawn one after the other within `tolerances` (default: `Tolerances()`) of `train`."""
    generator = np.random.default_rng(seed)
    for _ in range(samples):
        yield draw(train, tolerances or Tolerances(), generator)


def _deviations(generator: np.random.Generator, count: int, distribution: str) -> Array:
    """Return deviations in units of the tolerance's half-width, all within -1 to 1."""
    uniform = generator.random(count)
    if distribution == "uniform":
        return np.asarray(2 * uniform - 1)
    tail = ndtr(-2.0)
    return np.asarray(ndtri(tail + (1 - 2 * tail) * uniform) / 2)


def _factor(tolerance: float, deviation: float) -> float:
    return float(1 + tolerance * deviation)


def _mesh(mesh: Mesh, tolerances: Tolerances, deviations: Array) -> Mesh:
    stiffness, damping, backlash, error, driver, driven = (float(each) for each in deviations)
    grown = _factor(tolerances.transmission_error, error)
    return replace(
        mesh,
        driver=_gear(mesh.driver, tolerances, driver),
        driven=_gear(mesh.driven, tolerances, driven),
        # Set as a mean to scale to, which is where a description keeps it, also where the computed one was used.
        mean_stiffness=mesh.mean_model_stiffness * _factor(tolerances.mesh_stiffness, stiffness),
        scale_to_mean=True,
        damping_ratio=mesh.damping_ratio * _factor(tolerances.damping_ratio, damping),
        backlash=max(0.0, mesh.backlash + tolerances.backlash * backlash),
        error_harmonics=tuple(replace(each, amplitude=each.amplitude * grown) for each in mesh.error_harmonics),
    )


def _gear(gear: Gear, tolerances: Tolerances, deviation: float) -> Gear:
    return replace(gear, support_stiffness=gear.support_stiffness * _factor(tolerances.support_stiffness, deviation))
