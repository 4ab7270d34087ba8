"""Units that a system description may use, and their factors to SI."""

from math import pi

from seat_gear_dynamics.gears.errors import DescriptionError

RPM = 2 * pi / 60
"""One revolution per minute in rad/s."""

# dimension -> unit as written in a description -> factor to the SI unit (the one whose factor is 1)
_FACTORS: dict[str, dict[str, float]] = {
    "number": {"1": 1.0},
    "length": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6},
    "angle": {"rad": 1.0, "deg": pi / 180},
    "mass": {"kg": 1.0, "g": 1e-3},
    "inertia": {"kg·m²": 1.0, "kg*m^2": 1.0},
    "pressure": {"Pa": 1.0, "N/m²": 1.0, "N/m^2": 1.0, "GPa": 1e9},
    "stiffness": {"N/m": 1.0},
    "angular velocity": {"rad/s": 1.0, "r/min": RPM, "rpm": RPM},
    "torsional stiffness": {"N·m/rad": 1.0, "N*m/rad": 1.0, "Nm/rad": 1.0},
    "torque": {"N·m": 1.0, "N*m": 1.0, "Nm": 1.0},
}


def to_si(key: str, value: float, unit: object, dimension: str) -> float:
    """Return `value` in the SI unit of `dimension`.

    Raises DescriptionError, naming `key`, where `unit` does not measure that dimension.
    """
    factors = _FACTORS[dimension]
    if not isinstance(unit, str) or unit not in factors:
        accepted = ", ".join(repr(name) for name in factors)
        raise DescriptionError(
            f"{key}: the unit is {unit!r}, but this is a {dimension}, "
            f"which is given in one of {accepted}; correct the unit."
        )
    return value * factors[unit]


def si_unit(dimension: str) -> str:
    """Return the SI unit's name of a dimension, as reports write it."""
    return next(name for name, factor in _FACTORS[dimension].items() if factor == 1.0)
