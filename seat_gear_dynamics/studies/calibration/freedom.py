"""What the search may change: the parameters the paper leaves open, within what steel and a seat allow."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log10, pi

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import Gear, GearTrain, Mesh, TransmissionErrorHarmonic

Array = NDArray[np.float64]

ERROR_HARMONICS = 3


@dataclass(frozen=True)
class Freedom:
    """One open parameter; positive ones are searched by their decimal logarithm."""

    name: str
    low: float
    high: float
    reason: str
    """Why the bounds stand where they stand."""
    spread: float
    """Standard deviation of a first step of the search: in decades, or in rad for a phase."""
    logarithmic: bool = True

    def code(self, value: float) -> float:
        """Return the search's coordinate of `value`."""
        return log10(value) if self.logarithmic else value

    def value(self, coordinate: float) -> float:
        """Return the value at a search coordinate, held within the bounds; phases are wrapped into (−π, π]."""
        if not self.logarithmic:
            return float(np.remainder(coordinate + pi, 2 * pi) - pi)
        return float(np.clip(10**coordinate, self.low, self.high))

    def excess(self, coordinate: float) -> float:
        """Return how far a coordinate lies out of the bounds, 0 within."""
        if not self.logarithmic:
            return 0.0
        return max(0.0, log10(self.low) - coordinate, coordinate - log10(self.high))


_STIFF = "between a plastic bush and a solid steel seat; section 2.5 puts stiffness between 1e7 and 1e9 N/m"
_TWIST = "from almost free rotation, as a motor's rotor has, to a held shaft"
_DAMP = "from bare steel on rolling bearings to a greased plastic bush"
_ERROR = "from ground gears to sintered ones of quality 9-10; section 2.5 puts displacements at 1e-6 to 1e-4 m"
_MASS = "a bored or a flanged disc, as a share of the solid one"

FREEDOMS = (
    Freedom("k1", 1.0e6, 1.6e9, _STIFF, 0.18),
    Freedom("k2", 1.0e6, 1.6e9, _STIFF, 0.18),
    Freedom("k1t", 1e2, 3.2e6, _TWIST, 0.28),
    Freedom("k2t", 1e2, 3.2e6, _TWIST, 0.28),
    Freedom("zeta1", 0.01, 0.25, _DAMP, 0.14),
    Freedom("zeta2", 0.01, 0.25, _DAMP, 0.14),
    Freedom("zeta1t", 0.01, 1.0, _DAMP, 0.21),
    Freedom("zeta2t", 0.01, 1.0, _DAMP, 0.21),
    Freedom("E1", 0.03e-6, 8e-6, _ERROR, 0.08),
    Freedom("psi1", -pi, pi, "any", 0.4, logarithmic=False),
    Freedom("E2", 0.01e-6, 5e-6, _ERROR, 0.18),
    Freedom("psi2", -pi, pi, "any", 0.6, logarithmic=False),
    Freedom("E3", 0.003e-6, 2.5e-6, _ERROR, 0.28),
    Freedom("psi3", -pi, pi, "any", 0.7, logarithmic=False),
    Freedom("load_scale", 0.0025, 1.0, "the whole static force, down to a lightly loaded mesh", 0.07),
    Freedom("mass1", 0.5, 1.41, _MASS, 0.06),
    Freedom("mass2", 0.5, 1.41, _MASS, 0.06),
)
"""Of P12; P34, which no claim constrains, takes s2's supports for s3 and s1's for s4, and keeps its masses."""
STEEL_DENSITY = 7850.0
"""kg/m³"""


def apply(train: GearTrain, values: Sequence[float]) -> GearTrain:
    """Return `train` with the open parameters set to `values`, in the order and units of FREEDOMS (SI)."""
    named = dict(zip((f.name for f in FREEDOMS), values, strict=True))
    errors = tuple(
        TransmissionErrorHarmonic(order, named[f"E{order}"], named[f"psi{order}"])
        for order in range(1, ERROR_HARMONICS + 1)
    )
    s1, s2, s3, s4 = train.gears
    first, second = train.meshes
    shaped = (_shaped(s1, named, "1"), _shaped(s2, named, "2"), _shaped(s3, named, "2"), _shaped(s4, named, "1"))
    meshes = (_mesh(first, shaped[0], shaped[1], errors), _mesh(second, shaped[2], shaped[3], errors))
    return replace(train, meshes=meshes, model=replace(train.model, load_scale=named["load_scale"]))


def read(train: GearTrain) -> list[float]:
    """Return the open parameters of `train` in the order of FREEDOMS, as `apply` would set them."""
    s1, s2 = train.gears[:2]
    by_order = {h.order: h for h in train.meshes[0].error_harmonics}
    errors = [by_order.get(n, TransmissionErrorHarmonic(n, 0.0, 0.0)) for n in range(1, ERROR_HARMONICS + 1)]
    stiffness = [s1.support_stiffness, s2.support_stiffness, s1.torsional_stiffness, s2.torsional_stiffness]
    damping = [
        s1.support_damping_ratio,
        s2.support_damping_ratio,
        s1.torsional_damping_ratio,
        s2.torsional_damping_ratio,
    ]
    waves = [v for h in errors for v in (h.amplitude, h.phase)]
    masses = [s1.mass / disc_mass(s1), s2.mass / disc_mass(s2)]
    return [*stiffness, *damping, *waves, train.model.load_scale, *masses]


def disc_mass(gear: Gear) -> float:
    """Return the mass of a solid steel disc of the gear's pitch radius and face width, kg."""
    return STEEL_DENSITY * pi * gear.tooth.pitch_radius**2 * gear.face_width


def _shaped(gear: Gear, named: dict[str, float], suffix: str) -> Gear:
    own = gear.name == f"s{suffix}"
    return replace(
        gear,
        mass=named[f"mass{suffix}"] * disc_mass(gear) if own else gear.mass,
        support_stiffness=named[f"k{suffix}"],
        torsional_stiffness=named[f"k{suffix}t"],
        support_damping_ratio=named[f"zeta{suffix}"],
        torsional_damping_ratio=named[f"zeta{suffix}t"],
    )


def _mesh(mesh: Mesh, driver: Gear, driven: Gear, errors: tuple[TransmissionErrorHarmonic, ...]) -> Mesh:
    return replace(mesh, driver=driver, driven=driven, error_harmonics=errors)
