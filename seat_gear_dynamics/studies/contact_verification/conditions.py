"""Section 4 of the paper as data: Table 2 (settings), Table 3 (conditions) and Table 4 (forces), as printed."""

from dataclasses import dataclass
from math import sqrt

from seat_gear_dynamics.gears.units import RPM

RUNNING_TIME = 5.0
"""s (Table 2)"""
MEAN_STIFFNESS = (2.234e8, 3.097e8)
"""Average mesh stiffness of P12 and P34, N/m (Table 2)."""
CONTACT_STIFFNESS = (4.529e8, 5.051e8)
"""As printed "K12 = 4.529e8 N/m, K34 = 5.051e8 N/m" (Table 2); `readings` says what the unit can be."""
PRINTED_DAMPING = (2.2645e5, 2.526e6)
""""Dynamic damping C12 = 2.2645E+05, C23 = 2.526E+06", without unit (Table 2)."""
DAMPING = (2.2645e5, 2.526e5)
"""As used, N·s/m: C12 is K12/2000, and so is the second, which is C34 and not C23, with an exponent less."""
PENETRATION_DEPTH = 1e-4
""""Penetration depth coefficient", without unit (Table 2); read in m, which is ADAMS' usual 0.1 mm."""
STATIC_FRICTION = 0.23
"""Table 2"""
DYNAMIC_FRICTION = 0.16
"""Printed "dynamic damping coefficient" (Table 2)."""


@dataclass(frozen=True)
class Condition:
    """One row of Table 3."""

    number: int
    eccentricity: float
    """m"""
    backlash: float
    """On the line of action of P12, m."""
    load: float
    """T4, N·m"""
    speed: float
    """Of s1, rad/s"""

    @property
    def name(self) -> str:
        """Number and values in the paper's units."""
        lengths = f"eccentricity {self.eccentricity * 1e6:g} µm, backlash {self.backlash * 1e6:g} µm"
        return f"condition {self.number}: {lengths}, {self.load:g} N·m, {self.speed / RPM:.0f} r/min"


# (eccentricity µm, backlash µm, load N·m, speed r/min) of conditions 1 to 11.
_TABLE_3 = (
    (0, 0, 300, 132),
    (20, 0, 300, 132),
    (40, 0, 300, 132),
    (0, 0, 300, 132),
    (0, 10, 300, 132),
    (0, 30, 300, 132),
    (20, 30, 100, 132),
    (20, 30, 300, 132),
    (20, 30, 600, 132),
    (0, 30, 300, 60),
    (0, 30, 300, 300),
)

CONDITIONS = {
    number: Condition(number, eccentricity * 1e-6, backlash * 1e-6, float(load), speed * RPM)
    for number, (eccentricity, backlash, load, speed) in enumerate(_TABLE_3, start=1)
}
"""Table 3 by number; conditions 1 and 4 are the same."""


@dataclass(frozen=True)
class PrintedForce:
    """One row of Table 4, N: the P12 force. The heading says µm, an erratum."""

    minimum: float
    maximum: float
    mean: float
    rms: float

    @property
    def deviation(self) -> float:
        """Standard deviation that mean and rms imply, N."""
        return sqrt(self.rms**2 - self.mean**2)


TABLE_4 = {
    4: PrintedForce(3890.0, 6752.0, 5395.0, 5424.0),
    5: PrintedForce(3894.0, 6823.0, 5459.0, 5488.0),
    6: PrintedForce(3888.0, 21480.0, 5655.0, 5826.0),
}
"""Table 4 by condition."""


def share_at_maximum(row: PrintedForce, calm: PrintedForce) -> float:
    """Return the least share of the time that `row` must spend at its maximum to deviate as it does, 0 to 1.

    If the rest of the time is as `calm`: deviation² = calm's + share·(maximum − mean)². Lower peaks would need longer.
    """
    return (row.deviation**2 - calm.deviation**2) / (row.maximum - row.mean) ** 2
