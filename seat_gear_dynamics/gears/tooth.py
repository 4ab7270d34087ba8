"""The involute spur tooth as a tapered cantilever: its outline, contact kinematics and compliance."""

from dataclasses import dataclass
from math import cos, pi, sin, sqrt, tan

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ADDENDUM_FACTOR = 1.0  # standard full-depth teeth: addendum 1·m; the dedendum is what the full height leaves
_SHEAR_FACTOR = 1.2  # rectangular section, as in (8)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True)
class Tooth:
    """One spur tooth and the gear body below it; SI units, angles in rad."""

    teeth: int
    module: float
    pressure_angle: float
    height: float
    width: float
    bore_radius: float
    youngs_modulus: float
    poisson_ratio: float

    @property
    def pitch_radius(self) -> float:
        """m·z/2, m."""
        return self.module * self.teeth / 2

    @property
    def base_radius(self) -> float:
        """Pitch radius times cos(pressure angle), m."""
        return self.pitch_radius * cos(self.pressure_angle)

    @property
    def tip_radius(self) -> float:
        """Pitch radius plus the addendum, m."""
        return self.pitch_radius + _ADDENDUM_FACTOR * self.module

    @property
    def root_radius(self) -> float:
        """Tip radius less the full tooth height, m."""
        return self.tip_radius - self.height

    @property
    def base_half_angle(self) -> float:
        """Half the tooth's angle at the base circle: π/(2z) + inv(α), rad."""
        return pi / (2 * self.teeth) + tan(self.pressure_angle) - self.pressure_angle

    @property
    def tip_roll(self) -> float:
        """Roll angle of the involute at the tip, rad."""
        return sqrt((self.tip_radius / self.base_radius) ** 2 - 1)

    def outline(self, roll: Array) -> tuple[Array, Array]:
        """Return (distance along the tooth's centre line from the gear centre, half thickness), m, on the involute.

        `roll` is the roll angle, rad, any shape; 0 is the base circle.
        """
        radius = self.base_radius * np.sqrt(1 + roll**2)
        angle = self.base_half_angle - (roll - np.arctan(roll))
        return radius * np.cos(angle), radius * np.sin(angle)

    def beam_compliance(self, roll: float) -> float:
        """Return bending (6), axial (7) and shear (8) compliance for a unit force at `roll`, m/N.

        Below the base circle, where there is no involute, the flank is taken as the radial line from the involute's
        foot to the root circle (the paper does not say; see Liang, Zuo & Patel 2014, doi:10.1177/0954406213486734,
        for what neglecting that part costs). Undercut and the fillet's own outline are neglected.
        """
        load_angle = roll - self.base_half_angle
        across, along = cos(load_angle), sin(load_angle)  # F_b and F_a of (4) per unit force
        contact_x, contact_h = (float(v) for v in self.outline(np.asarray(roll)))
        total = 0.0
        for x, half, weight in self._sections(roll):
            moment = across * (contact_x - x) - along * contact_h
            area = 2 * half * self.width
            inertia = (2 * half) ** 3 * self.width / 12
            shear_modulus = self.youngs_modulus / (2 * (1 + self.poisson_ratio))
            integrand = moment**2 / (self.youngs_modulus * inertia)
            integrand += along**2 / (self.youngs_modulus * area)
            integrand += _SHEAR_FACTOR * across**2 / (shear_modulus * area)
            total += float(np.sum(weight * integrand))
        return total

    def _sections(self, roll: float) -> list[tuple[Array, Array, Array]]:
        """Return quadrature nodes (x, half thickness, weight dx) of the radial root part and of the involute part."""
        parts = []
        if self.root_radius < self.base_radius:
            centre, half_span = (
                (self.base_radius + self.root_radius) / 2,
                (self.base_radius - self.root_radius) / 2,
            )
            radius = centre + half_span * _NODES
            c, s = cos(self.base_half_angle), sin(self.base_half_angle)
            parts.append((radius * c, radius * s, half_span * _WEIGHTS * c))
            first = 0.0
        else:
            first = sqrt((self.root_radius / self.base_radius) ** 2 - 1)
        psi = (roll + first) / 2 + (roll - first) / 2 * _NODES
        x, half = self.outline(psi)
        # x = r_b·(cos(a − ψ) − ψ·sin(a − ψ)), a the base half angle, so dx/dψ = r_b·ψ·cos(a − ψ).
        slope = self.base_radius * psi * np.cos(self.base_half_angle - psi)
        parts.append((x, half, (roll - first) / 2 * _WEIGHTS * slope))
        return parts

    def foundation_compliance(self, roll: float) -> float:
        """Return the fillet-foundation compliance for a unit force at `roll`, m/N.

        Sainsot, Velex & Duverger 2004, doi:10.1115/1.1758252: an elastic ring with linear stress at the root.
        """
        load_angle = roll - self.base_half_angle
        half_root = self.base_half_angle if self.root_radius < self.base_radius else self._root_half_angle()
        ratio = self.root_radius / self.bore_radius
        contact_x, contact_h = (float(v) for v in self.outline(np.asarray(roll)))
        root_x = self.root_radius * cos(half_root)
        root_chord = 2 * self.root_radius * half_root
        lever = (contact_x - contact_h * tan(load_angle) - root_x) / root_chord
        coefficients = {name: _foundation(name, ratio, half_root) for name in _SAINSOT}
        shape = coefficients["L"] * lever**2 + coefficients["M"] * lever
        shape += coefficients["P"] * (1 + coefficients["Q"] * tan(load_angle) ** 2)
        return cos(load_angle) ** 2 / (self.youngs_modulus * self.width) * shape

    def _root_half_angle(self) -> float:
        roll = sqrt((self.root_radius / self.base_radius) ** 2 - 1)
        return self.base_half_angle - (roll - float(np.arctan(roll)))


# Coefficients A..F of Sainsot's polynomial X(h, θ) = A/θ² + B·h² + C·h/θ + D/θ + E·h + F.
_SAINSOT = {
    "L": (-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045),
    "M": (60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086),
    "P": (-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236),
    "Q": (-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904),
}


def _foundation(name: str, ratio: float, angle: float) -> float:
    a, b, c, d, e, f = _SAINSOT[name]
    return a / angle**2 + b * ratio**2 + c * ratio / angle + d / angle + e * ratio + f


def contact_ratio(driver: Tooth, driven: Tooth) -> float:
    """Return the transverse contact ratio of a standard pair at its reference centre distance, dimensionless."""
    start, end = path_of_contact(driver, driven)
    return (end - start) / base_pitch(driver)


def base_pitch(tooth: Tooth) -> float:
    """Return the base pitch π·m·cos α, m."""
    return pi * tooth.module * cos(tooth.pressure_angle)


def path_of_contact(driver: Tooth, driven: Tooth) -> tuple[float, float]:
    """Return where contact starts and ends on the line of action, m from the driver's base-circle tangent point."""
    line = (driver.pitch_radius + driven.pitch_radius) * sin(driver.pressure_angle)
    start = line - sqrt(driven.tip_radius**2 - driven.base_radius**2)
    end = sqrt(driver.tip_radius**2 - driver.base_radius**2)
    return start, end
