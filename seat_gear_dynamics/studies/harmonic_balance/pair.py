"""The pair P12 by itself, as harmonic balance wants it: six coordinates folded into the compliance of one deflection.

Mesh and supports of P12 meet only in δ: with the mesh force of frequency ν, each coordinate answers by itself, and
δ + e − w·q(load) = −α(ν)·F with the compliance α(ν) = Σ w_i·(w_i/m_i)/(K_i − ν² + iνC_i). So the harmonics of δ are
all there is to solve for, however many coordinates stand behind it.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import PeriodicSeries
from seat_gear_dynamics.motion import System

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

COORDINATES = 6
PARAMETERS = ("frequency", "load", "damping_ratio", "backlash")
"""What a motion may be followed over."""


@dataclass(frozen=True)
class Conditions:
    """Where the pair works; each of these may be the parameter of a branch."""

    frequency: float
    """Dimensionless mesh frequency Ω, above 0."""
    load: float
    """T4, N·m."""
    damping_ratio: float
    """ξ of the mesh."""
    backlash: float
    """b, m."""

    def __post_init__(self) -> None:
        if not self.frequency > 0:
            raise ValueError(f"The frequency is {self.frequency!r}, expected a number above 0; give a forward drive.")
        for name in ("damping_ratio", "backlash"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"The {name} is {getattr(self, name)!r}, expected a number of at least 0.")

    def with_value(self, parameter: str, value: float) -> "Conditions":
        """Return the same conditions with one of PARAMETERS changed; raises ValueError for another name."""
        if parameter not in PARAMETERS:
            raise ValueError(f"The parameter is {parameter!r}, expected one of {', '.join(PARAMETERS)}.")
        return replace(self, **{parameter: float(value)})


@dataclass(frozen=True)
class Pair:
    """Mass-normalised dimensionless coefficients of P12, (6,) in the order x1, y1, u1, x2, y2, u2; P34 is not in it."""

    stiffness: Array
    damping: Array
    direction: Array
    reaction: Array
    drive: Array
    """Acceleration by the given torques per N·m of T4, (6,)."""
    damping_per_ratio: float
    """c of (2) in dimensionless form, per unit of ξ."""
    kappa: PeriodicSeries
    """Mesh stiffness over its mean, of the mesh phase."""
    error: PeriodicSeries
    """Transmission error over b_c, of the mesh phase."""
    eccentricity: Array
    """Amplitude of each gear's own error over b_c, (2,)."""
    eccentricity_phase: Array
    shaft_turns: Array
    """Revolutions of each gear in a mesh period, (2,)."""
    backlash_in_torsion: bool
    damping_in_contact_only: bool
    length_unit: float
    """b_c, m."""
    force_unit: float
    """k̄_12·b_c, N."""

    @cached_property
    def kappa_coefficients(self) -> Array:
        """The mesh stiffness as coefficients of `fourier.evaluate`, of the mesh phase."""
        return np.array([self.kappa.mean, *self.kappa.cosine, *self.kappa.sine])

    def half_backlash(self, conditions: Conditions) -> float:
        """Return b/(2·b_c)."""
        return conditions.backlash / 2 / self.length_unit

    def mesh_damping(self, conditions: Conditions) -> float:
        """Return the dimensionless mesh damping c."""
        return self.damping_per_ratio * conditions.damping_ratio

    def compliance(self, frequencies: Array) -> tuple[Complex, Complex, Complex, Complex]:
        """Return α(ν) by the supports and by the torsional lines, then the slope of both by ν, each (n,); ν above 0."""
        nu = np.asarray(frequencies, dtype=float)[:, None]
        dynamic = self.stiffness - nu**2 + 1j * nu * self.damping
        each = self.direction * self.reaction / dynamic
        slope = -each / dynamic * (1j * self.damping - 2 * nu)
        turning = np.arange(COORDINATES) % 3 == 2
        return (
            each[:, ~turning].sum(axis=1),
            each[:, turning].sum(axis=1),
            slope[:, ~turning].sum(axis=1),
            slope[:, turning].sum(axis=1),
        )

    def static_balance(self) -> tuple[float, float, float, float]:
        """Return (κ_0, s, σ_s, σ_t) of κ_0·(δ + e) + σ_s·F_s + σ_t·F_t = s·load, the balance of the mean.

        κ_0 is the inverse of α(0), σ the share in α(0) of the supports and of the torsional lines. A coordinate that
        nothing holds takes the whole of α(0): κ_0 is 0 then, and the mesh carries the load alone.
        """
        turning = np.arange(COORDINATES) % 3 == 2
        share = self.direction * self.reaction
        free = (self.stiffness == 0) & (share != 0)
        if free.any():
            first = int(np.flatnonzero(free)[0])
            return 0.0, float(self.drive[first] / self.reaction[first]), 0.0, 1.0
        soft = share / self.stiffness
        whole = soft.sum()
        moved = float((self.direction * self.drive / self.stiffness).sum())
        return float(1 / whole), moved / whole, float(soft[~turning].sum() / whole), float(soft[turning].sum() / whole)

    def orders(self, subharmonics: int) -> tuple[list[tuple[int, complex]], list[float]]:
        """Return the harmonics of the error as (order in the motion's period, amplitude), and what does not fit.

        The second list holds the periods, in mesh periods, of eccentric gears that do not come round in the motion's.
        """
        found = [
            (subharmonics * m, complex(c, -s))
            for m, (c, s) in enumerate(zip(self.error.cosine, self.error.sine, strict=True), start=1)
            if c or s
        ]
        strange = []
        for size, phase, turns in zip(self.eccentricity, self.eccentricity_phase, self.shaft_turns, strict=True):
            order = subharmonics * turns
            if size and abs(order - round(order)) > 1e-9:
                strange.append(float(1 / turns))
            elif size:
                found.append((round(order), complex(size * np.sin(phase), -size * np.cos(phase))))
        return found, strange


def pair(system: System) -> tuple[Pair, Conditions]:
    """Return P12 of `system` and the conditions it is in; `System.at` and `with_mesh` set these.

    Raises ValueError where a shaft couples the pairs: P34 then shakes P12 at 17/40 of its frequency, the motion's
    period is 40 mesh periods, and the unknowns are a hundred times as many; integrate that train instead. Also where
    the frequency is not above 0.
    """
    train, c = system.train, system.coefficients
    if train.shaft.couples:
        raise ValueError(
            f"The train has a shaft of {train.shaft.stiffness:g} N·m/rad between s2 and s3, expected none: "
            f"harmonic balance follows P12 alone; take the shaft away, or integrate the coupled train."
        )
    mesh, own, point = train.meshes[0], slice(0, COORDINATES), system.operating_point
    unit = train.with_mesh(0, damping_ratio=1.0).meshes[0].damping
    made = Pair(
        stiffness=c.stiffness[own],
        damping=c.damping[own],
        direction=c.direction[own],
        reaction=c.reaction[own],
        drive=c.drive[own],
        damping_per_ratio=unit * train.derived_time_scale / mesh.mean_model_stiffness,
        kappa=mesh.stiffness.scaled(1 / mesh.mean_model_stiffness),
        error=mesh.transmission_error.scaled(1 / c.length_unit),
        eccentricity=c.eccentricity[:2],
        eccentricity_phase=c.eccentricity_phase[:2],
        shaft_turns=c.shaft_turns[:2],
        backlash_in_torsion=c.backlash_in_torsion,
        damping_in_contact_only=c.damping_in_contact_only,
        length_unit=c.length_unit,
        force_unit=c.force_unit,
    )
    return made, Conditions(point.frequency, point.load, mesh.damping_ratio, mesh.backlash)
