"""What Table 2 can mean: the readings of its contact stiffness, and everything else that the paper leaves open.

"4.529e8 N/m" and "5.051e8 N/m" are, within 3 %, what Hertz' formula gives for spheres of the pitch radii in N/mm^1.5:
4.407e5 and 4.909e5 with Table 1's steel, 4.507e5 and 5.020e5 with that of ADAMS (E 2.07e11 Pa, ν 0.29), times 1000 for
"per mm" to "per m" as if the exponent were 1. Both ratios, and their quotient, agree; a mesh stiffness would be none of
them. So the first reading is the default:

- `hertz`: 4.529e5 N/mm^1.5 = 1.432e10 N/m^1.5, exponent 1.5. At 5652 N one pair penetrates by 54 µm.
- `linear`: 4.529e8 N/m to the letter, exponent 1. 12.5 µm.
- `metre`: 4.529e8 N/m^1.5, as ADAMS takes the printed number in a model in metres. 0.54 mm, a third of a module.
- `mesh`: not the contact stiffness, but a pair's share of Table 2's mean mesh stiffness (mean over contact ratio),
  exponent 1: the elastic mesh of the lumped model with its two levels. 41 µm.

Damping is in N·s/m (C12 = K12/2000 also as 226.45 N·s/mm per 4.529e5), and the penetration depth 1e-4 in m: in mm
the start-up impact at 30 µm backlash would be 4e5 N.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from seat_gear_dynamics.gears import GearTrain, Mesh
from seat_gear_dynamics.studies.contact_verification.conditions import (
    CONTACT_STIFFNESS,
    DAMPING,
    DYNAMIC_FRICTION,
    MEAN_STIFFNESS,
    PENETRATION_DEPTH,
    STATIC_FRICTION,
)
from seat_gear_dynamics.studies.contact_verification.impact import Contact, checked, hertz_stiffness

_HALF_POWER = 1e3**0.5  # N/mm^1.5 to N/m^1.5 is 1e3^1.5, of which the printed number holds 1e3 already


def _hertz(mesh: int, ratio: float) -> tuple[float, float]:
    return CONTACT_STIFFNESS[mesh] * _HALF_POWER, 1.5


def _linear(mesh: int, ratio: float) -> tuple[float, float]:
    return CONTACT_STIFFNESS[mesh], 1.0


def _metre(mesh: int, ratio: float) -> tuple[float, float]:
    return CONTACT_STIFFNESS[mesh], 1.5


def _mesh(mesh: int, ratio: float) -> tuple[float, float]:
    return MEAN_STIFFNESS[mesh] / ratio, 1.0


READINGS: Mapping[str, Callable[[int, float], tuple[float, float]]] = MappingProxyType(
    {"hertz": _hertz, "linear": _linear, "metre": _metre, "mesh": _mesh}
)
"""Reading -> (mesh index, contact ratio) -> (stiffness per pair in N/m^e, exponent e)."""


@dataclass(frozen=True)
class Assumptions:
    """Everything the paper does not say of its ADAMS model; the defaults are this project's choices."""

    reading: str = "hertz"
    """Of the contact stiffness, one of READINGS."""
    corner: bool = True
    """True: tips touch before and after the path of contact, as rigid involutes do. False: pairs enter and leave at
    once, with the full penetration of the others, which jolts: no contact of solids does."""
    friction: bool = True
    """False: none, for which a rigid perfect involute pair transmits a steady force."""
    depth: float = PENETRATION_DEPTH
    """Of full damping, m."""
    stiction_speed: float = 0.1
    """m/s; the default of ADAMS View, 100 mm/s."""
    friction_speed: float = 1.0
    """m/s; the default of ADAMS View, 1000 mm/s."""
    speed_ramp: float = 0.1
    """Time in which s1 reaches its speed, s; a usual STEP."""
    load_ramp: float = 0.0
    """Time in which T4 reaches its value, s; 0: it is there from the first moment, as a constant torque is."""
    apart: bool = False
    """True: assembled with the flanks that are to drive a whole backlash apart; False: half, teeth centred."""


def contacts(train: GearTrain, assumptions: Assumptions) -> tuple[Contact, Contact]:
    """Return the contact laws of P12 and P34 with Table 2's values under `assumptions`.

    Raises ValueError for a reading that there is not, or values that the law cannot take.
    """
    if assumptions.reading not in READINGS:
        known = ", ".join(READINGS)
        raise ValueError(f"There is no reading {assumptions.reading!r} of Table 2; give one of {known}.")
    first, second = (_contact(index, mesh, assumptions) for index, mesh in enumerate(train.meshes))
    return first, second


def _contact(index: int, mesh: Mesh, assumptions: Assumptions) -> Contact:
    stiffness, exponent = READINGS[assumptions.reading](index, mesh.contact_ratio)
    static, dynamic = (STATIC_FRICTION, DYNAMIC_FRICTION) if assumptions.friction else (0.0, 0.0)
    speeds = assumptions.stiction_speed, assumptions.friction_speed
    return checked(Contact(stiffness, exponent, DAMPING[index], assumptions.depth, static, dynamic, *speeds))


def hertz_ratios(train: GearTrain) -> tuple[float, float]:
    """Return Table 2's contact stiffness over Hertz' for P12 and P34, read as in `hertz`, dimensionless.

    Pitch radii, and the driver's Young's modulus and Poisson's ratio, as in Table 1.
    """
    ratios = []
    for index, mesh in enumerate(train.meshes):
        first, second = mesh.driver, mesh.driven
        hertz = hertz_stiffness(
            first.tooth.pitch_radius, second.tooth.pitch_radius, first.youngs_modulus, first.poisson_ratio
        )
        ratios.append(_hertz(index, mesh.contact_ratio)[0] / hertz)
    return ratios[0], ratios[1]
