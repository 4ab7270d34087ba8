"""A periodic motion of P12 out of its harmonics: deflection, mesh force and full state at any phase, and contact."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.studies.harmonic_balance.balance import Balance
from seat_gear_dynamics.studies.harmonic_balance.fourier import amplitudes, evaluate
from seat_gear_dynamics.studies.harmonic_balance.pair import COORDINATES, Conditions

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

CONTACT_STATES = ("no loss", "one-sided", "double-sided")
"""Teeth never part; they part and meet again on the same flank; they reach the other flank too (Comparin & Singh 1989,
J. Sound Vib. 134, 259-290: no impact, one-sided and two-sided impact)."""

_POLISH = 3  # Newton steps on a crossing that linear interpolation between samples found


@dataclass(frozen=True)
class Orbit:
    """The motion that `coefficients` of δ/b_c describe under one setting of a balance; phases are of its own period."""

    balance: Balance
    conditions: Conditions
    coefficients: Array

    @property
    def period(self) -> float:
        """Of the motion, units of τ."""
        return 2 * np.pi * self.balance.subharmonics / self.conditions.frequency

    def deflection(self, phase: ArrayLike) -> Array:
        """Return δ/b_c, of the phases' shape."""
        return evaluate(self.coefficients, phase)[0]

    def rate(self, phase: ArrayLike) -> Array:
        """Return dδ/dτ over b_c, of the phases' shape."""
        return evaluate(self.coefficients, phase)[1] / self.period

    def force(self, phase: ArrayLike) -> Array:
        """Return the dimensionless mesh force κ·f(δ) + c·δ′, of the phases' shape; times `force_unit` it is N."""
        pair = self.balance.pair
        delta, slope = evaluate(self.coefficients, phase)
        beyond = self.balance.beyond(delta, self.conditions)
        damper = pair.mesh_damping(self.conditions) * slope / self.period
        if pair.damping_in_contact_only:
            damper = np.where(beyond == 0, 0.0, damper)
        return np.asarray(pair.kappa.value(np.asarray(phase) * self.balance.subharmonics % 1.0) * beyond + damper)

    def states(self, phase: ArrayLike) -> Array:
        """Return the state of P12, shape (…, 12): x1, y1, u1, x2, y2, u2 over b_c, then their rates per τ."""
        angle = 2j * np.pi * np.multiply.outer(np.asarray(phase, dtype=float), self.balance.basis.orders)
        turning = np.exp(angle)
        nu = self.balance.basis.orders * self.conditions.frequency / self.balance.subharmonics
        coordinates = self._coordinates
        return np.concatenate(
            [(turning @ coordinates).real, (turning @ (1j * nu[:, None] * coordinates)).real], axis=-1
        )

    @cached_property
    def _coordinates(self) -> Complex:
        """Harmonics of the six coordinates, (H + 1, 6)."""
        pair, basis = self.balance.pair, self.balance.basis
        forces = self.balance.forces(self.coefficients, self.conditions)
        lines = np.tile(np.column_stack([forces.support, forces.support, forces.torsion]), 2)
        nu = basis.orders[:, None] * self.conditions.frequency / self.balance.subharmonics
        dynamic = pair.stiffness - nu**2 + 1j * nu * pair.damping
        free = pair.stiffness == 0
        dynamic[0, free] = 1.0
        found = -pair.reaction * lines / dynamic
        found[0] += self.conditions.load * pair.drive / dynamic[0]
        found[0, free] = 0.0
        # What nothing holds has no mean of its own: the least motion that closes the mesh to the mean deflection.
        missing = amplitudes(self.coefficients)[0] + pair.error.mean - found[0] @ pair.direction
        if free.any():
            found[0, free] = missing * pair.direction[free] / (pair.direction[free] ** 2).sum()
        return np.asarray(found)

    @cached_property
    def crossings(self) -> Array:
        """Phases in [0, 1) at which teeth part or meet, in order.

        Two crossings between neighbouring samples of the basis are not seen; they part by less than a sixteenth of
        the period of the highest harmonic kept.
        """
        basis, half = self.balance.basis, self.balance.pair.half_backlash(self.conditions)
        values = basis.values(self.coefficients)
        found: list[Array] = []
        for level in {half, -half}:
            over = values - level
            begin = np.flatnonzero((over > 0) != (np.roll(over, -1) > 0))
            after = np.roll(over, -1)[begin]
            phase = (begin + over[begin] / (over[begin] - after)) / basis.samples
            low, high = begin / basis.samples, (begin + 1) / basis.samples
            for _ in range(_POLISH):
                value, slope = evaluate(self.coefficients, phase)
                with np.errstate(divide="ignore", invalid="ignore"):
                    step = np.where(slope == 0, 0.0, (value - level) / slope)
                phase = np.clip(phase - step, low, high)
            found.append(phase)
        return np.sort(np.concatenate(found) % 1.0)

    @cached_property
    def samples(self) -> Array:
        """δ/b_c at the samples of the basis, (samples,)."""
        return self.balance.basis.values(self.coefficients)

    @property
    def contact_state(self) -> str:
        """One of CONTACT_STATES; "no loss" is also said of teeth that never touch."""
        half = self.balance.pair.half_backlash(self.conditions)
        inside = bool((np.abs(self.samples) < half).any())
        if inside and (self.samples > half).any() and (self.samples < -half).any():
            return CONTACT_STATES[2]
        return CONTACT_STATES[1] if inside and not (np.abs(self.samples) <= half).all() else CONTACT_STATES[0]

    @property
    def contact_loss(self) -> float:
        """Share of the period out of contact, 0 to 1."""
        nodes = self.crossings
        half = self.balance.pair.half_backlash(self.conditions)
        if not len(nodes):
            return float(abs(self.samples[0]) < half)
        ends = np.append(nodes[1:], nodes[0] + 1.0)
        apart = np.abs(self.deflection((nodes + ends) / 2)) < half
        return float(((ends - nodes) * apart).sum())


def state_of_train(orbit: Orbit, rest: Array) -> Array:
    """Return `rest`, a state of the train, (24,), with P12 put on the orbit at phase 0, which is mesh phase 0."""
    state = np.array(rest, dtype=float)
    own = orbit.states(0.0)
    state[:COORDINATES], state[2 * COORDINATES : 3 * COORDINATES] = own[:COORDINATES], own[COORDINATES:]
    return state
