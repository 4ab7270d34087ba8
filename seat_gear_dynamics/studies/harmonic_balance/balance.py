"""The balance of harmonics of P12's deflection: residual, Jacobian and slope along each parameter.

With δ in harmonics k of the motion's period, n mesh periods long, and ν_k = kΩ/n, the equations of
`motion/coefficients.py` become, line by line condensed onto δ,

    δ_k + e_k + α_s(ν_k)·(N_k + D_k) + α_t(ν_k)·(T_k + D_k) = 0    for k above 0,

with N of κ·f(δ), D of the damper, T of what pulls in the torsional lines: N, or κ·δ where `backlash_in_torsion` is
off. A damper that acts in contact only is c·d f(δ)/dτ, because f has slope 1 in contact and 0 out of it: so its
harmonics are those of f(δ), continuous in δ although the force itself jumps.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.dead_zone import dead_zone
from seat_gear_dynamics.studies.harmonic_balance.fourier import Basis, amplitudes, from_amplitudes
from seat_gear_dynamics.studies.harmonic_balance.pair import PARAMETERS, Conditions, Pair

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SAMPLES_PER_HARMONIC = 16
"""Time samples for each harmonic kept: twice 8, so that corners of f(δ) are met finely enough."""


class Sampled(NamedTuple):
    """δ, f(δ) and its slope at the samples of a period, each (samples,)."""

    delta: Array
    beyond: Array
    contact: Array


@dataclass(frozen=True)
class Forces:
    """Harmonics of what acts in the mesh, amplitudes (H + 1,) of the motion's period."""

    support: Complex
    """In the lines of x and y."""
    torsion: Complex
    """In the lines of u."""


@dataclass(frozen=True)
class Balance:
    """The equations of harmonic balance of `pair`, over one of its conditions as parameter.

    `evaluate` is what Newton's method and the continuation call; the unknowns are the coefficients of δ/b_c.
    """

    pair: Pair
    conditions: Conditions
    """The conditions but for the parameter's value."""
    basis: Basis
    subharmonics: int = 1
    """n: the motion's period is n mesh periods."""
    parameter: str = "frequency"

    def __post_init__(self) -> None:
        if self.parameter not in PARAMETERS:
            raise ValueError(f"The parameter is {self.parameter!r}, expected one of {', '.join(PARAMETERS)}.")
        if self.subharmonics < 1:
            raise ValueError(f"A period of {self.subharmonics} mesh periods was asked for, expected 1 or more.")

    def at(self, value: float) -> Conditions:
        """Return the conditions with the parameter at `value`."""
        return self.conditions.with_value(self.parameter, value)

    def evaluate(self, unknowns: Array, parameter: float) -> tuple[Array, Array, Array]:
        """Return (residual, Jacobian, slope by the parameter), shapes (m,), (m, m), (m,) with m = 2·H + 1.

        The residual's mean row is a force over k̄_12·b_c, the others are displacements over b_c.
        """
        at = self.at(parameter)
        nu = self.basis.orders * at.frequency / self.subharmonics
        supports, torsions, d_supports, d_torsions = self.pair.compliance(nu[1:])
        sampled = self._sampled(unknowns, at)
        forces, slopes = self._forces(unknowns, sampled, at), self._slopes(unknowns, sampled, at)
        pulled, turned = self._derivatives(sampled, at)
        delta = amplitudes(unknowns) + self._error
        residual = delta[1:] + supports * forces.support[1:] + torsions * forces.torsion[1:]
        matrix = amplitudes(np.eye(self.basis.size))[1:] + (
            supports[:, None] * amplitudes(pulled)[1:] + torsions[:, None] * amplitudes(turned)[1:]
        )
        slope = supports * slopes.support[1:] + torsions * slopes.torsion[1:]
        if self.parameter == "frequency":
            rates = self.basis.orders[1:] / self.subharmonics
            slope = slope + rates * (d_supports * forces.support[1:] + d_torsions * forces.torsion[1:])
        mean, mean_row, mean_slope = self._mean_balance(delta[0], forces, slopes, (pulled[0], turned[0]), at)
        return (
            from_amplitudes(np.concatenate([[mean], residual])),
            from_amplitudes(np.concatenate([mean_row[None, :].astype(complex), matrix])),
            from_amplitudes(np.concatenate([[mean_slope], slope])),
        )

    def forces(self, unknowns: Array, at: Conditions) -> Forces:
        """Return the harmonics of the mesh force in the lines of x, y and of u."""
        return self._forces(unknowns, self._sampled(unknowns, at), at)

    def beyond(self, delta: Array, at: Conditions) -> Array:
        """Return f(δ) of (1) point by point, any shape."""
        half = self.pair.half_backlash(at)
        return np.asarray(delta - np.clip(delta, -half, half))

    def _mean_balance(
        self, mean: complex, forces: Forces, slopes: Forces, rows: tuple[Array, Array], at: Conditions
    ) -> tuple[complex, Array, complex]:
        """Return residual, row of the Jacobian and slope of the balance of means; `mean` is that of δ + e."""
        stiffness, drive, share_s, share_t = self.pair.static_balance()
        residual = stiffness * mean + share_s * forces.support[0] + share_t * forces.torsion[0] - drive * at.load
        row = share_s * rows[0] + share_t * rows[1]
        row[0] += stiffness
        slope = share_s * slopes.support[0] + share_t * slopes.torsion[0]
        return residual, row, slope - drive if self.parameter == "load" else slope

    def _sampled(self, unknowns: Array, at: Conditions) -> Sampled:
        delta = self.basis.values(unknowns)
        return Sampled(delta, *dead_zone(delta, self.pair.half_backlash(at)))

    def _forces(self, unknowns: Array, sampled: Sampled, at: Conditions) -> Forces:
        elastic = self._harmonics(self._kappa * sampled.beyond)
        damper = self._damper(at) * self._damped(unknowns, sampled)
        if self.pair.backlash_in_torsion:
            return Forces(elastic + damper, elastic + damper)
        return Forces(elastic + damper, self._harmonics(self._kappa * sampled.delta) + damper)

    def _derivatives(self, sampled: Sampled, at: Conditions) -> tuple[Array, Array]:
        """Return the derivative of both forces' coefficients by the unknowns, each (m, m)."""
        elastic = self.basis.multiplication(self._kappa * sampled.contact)
        damped = np.eye(self.basis.size)
        if self.pair.damping_in_contact_only:
            damped = self.basis.multiplication(sampled.contact)
        damper = from_amplitudes(self._damper(at)[:, None] * amplitudes(damped))
        if self.pair.backlash_in_torsion:
            return elastic + damper, elastic + damper
        return elastic + damper, self._linear + damper

    def _slopes(self, unknowns: Array, sampled: Sampled, at: Conditions) -> Forces:
        """Return the derivative of the forces by the parameter, at fixed δ."""
        zero = np.zeros(self.basis.harmonics + 1, dtype=complex)
        if self.parameter == "load":
            return Forces(zero, zero)
        if self.parameter == "backlash":
            shift = -np.sign(sampled.delta) * sampled.contact / (2 * self.pair.length_unit)
            elastic, damper = self._harmonics(self._kappa * shift), zero
            if self.pair.damping_in_contact_only:
                damper = self._damper(at) * self._harmonics(shift)
            return Forces(elastic + damper, damper + (elastic if self.pair.backlash_in_torsion else zero))
        if self.parameter == "frequency":
            rate = self._damper(at) / at.frequency
        else:
            rate = self._damper(at.with_value(self.parameter, 1.0))
        damper = rate * self._damped(unknowns, sampled)
        return Forces(damper, damper)

    def _damper(self, at: Conditions) -> Complex:
        """Return iν_k·c, (H + 1,)."""
        rates = self.basis.orders * at.frequency / self.subharmonics
        return np.asarray(1j * rates * self.pair.mesh_damping(at), dtype=complex)

    def _damped(self, unknowns: Array, sampled: Sampled) -> Complex:
        """Return the harmonics of what the damper takes the rate of: δ, or f(δ) where it acts in contact only."""
        return self._harmonics(sampled.beyond) if self.pair.damping_in_contact_only else amplitudes(unknowns)

    def _harmonics(self, values: Array) -> Complex:
        return amplitudes(self.basis.coefficients(values))

    @cached_property
    def _kappa(self) -> Array:
        return self.pair.kappa.value(self.basis.phases * self.subharmonics % 1.0)

    @cached_property
    def _linear(self) -> Array:
        return self.basis.multiplication(self._kappa)

    @cached_property
    def _error(self) -> Complex:
        """Harmonics of the error, (H + 1,); raises ValueError where the basis or the period has no room for one."""
        found, strange = self.pair.orders(self.subharmonics)
        if strange:
            raise ValueError(
                f"An eccentric gear comes round in {strange[0]:g} mesh periods, the motion in {self.subharmonics}; "
                f"expected a whole multiple: ask for that many subharmonics, or take the eccentricity away."
            )
        error = np.zeros(self.basis.harmonics + 1, dtype=complex)
        error[0] = self.pair.error.mean
        for order, amplitude in found:
            if order > self.basis.harmonics:
                raise ValueError(
                    f"The transmission error has harmonic {order} of the motion's period and the balance keeps "
                    f"{self.basis.harmonics}; expected at least as many: ask for more harmonics."
                )
            error[order] += amplitude
        return error


def balance(
    pair: Pair,
    conditions: Conditions,
    *,
    harmonics: int,
    subharmonics: int = 1,
    parameter: str = "frequency",
) -> Balance:
    """Return the balance of `pair` with `harmonics` of the mesh frequency, so harmonics·subharmonics of the motion's.

    Samples: 16 per harmonic kept, rounded up to a power of two.
    """
    kept = harmonics * subharmonics
    samples = 1 << (SAMPLES_PER_HARMONIC * max(kept, 1) - 1).bit_length()
    return Balance(pair, conditions, Basis(kept, samples), subharmonics, parameter)
