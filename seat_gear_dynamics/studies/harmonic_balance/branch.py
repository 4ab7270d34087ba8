"""A branch of periodic motions: its points with amplitude, contact and stability, and the bifurcations met on it."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.balance import Balance
from seat_gear_dynamics.studies.harmonic_balance.continuation import Point
from seat_gear_dynamics.studies.harmonic_balance.fourier import amplitudes
from seat_gear_dynamics.studies.harmonic_balance.newton import NoSolutionError, solve
from seat_gear_dynamics.studies.harmonic_balance.orbit import Orbit
from seat_gear_dynamics.studies.harmonic_balance.stability import NEUTRAL, multipliers

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SAME = 1e-7  # of b_c: two solutions nearer than this are one
_ALIKE = 1e-3  # of its range: so near a motion on the branch, and a motion of its period is that one

BIFURCATIONS = ("fold", "branch point", "period doubling", "Neimark-Sacker")
"""A multiplier at +1 where the branch turns back; at +1 where it does not; at -1; a complex pair on the unit circle."""


@dataclass(frozen=True)
class Motion:
    """One periodic motion on a branch: where it is, how large, how the teeth touch, and whether it is stable."""

    orbit: Orbit
    point: Point

    @property
    def parameter(self) -> float:
        """Value of the branch's parameter."""
        return self.point.parameter

    @cached_property
    def multipliers(self) -> Complex:
        """Floquet multipliers over the motion's period, largest first, (12,)."""
        return multipliers(self.orbit)

    @property
    def unstable(self) -> int:
        """Number of multipliers outside the unit circle, beyond the margin `stability.NEUTRAL`."""
        return int((np.abs(self.multipliers) > 1 + NEUTRAL).sum())

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out."""
        return self.unstable == 0

    @property
    def mean(self) -> float:
        """Mean of δ/b_c."""
        return float(self.orbit.coefficients[0])

    @property
    def rms(self) -> float:
        """Root mean square of δ/b_c about its mean."""
        return float(np.sqrt((self.orbit.coefficients[1:] ** 2).sum() / 2))

    @property
    def peak(self) -> float:
        """Largest distance of δ/b_c from its mean, among the samples of the basis."""
        return float(np.abs(self.orbit.samples - self.mean).max())

    @cached_property
    def force(self) -> Array:
        """Mesh force at the samples of the basis, dimensionless, (samples,)."""
        return self.orbit.force(self.orbit.balance.basis.phases)

    @property
    def subharmonic(self) -> float:
        """Share of the rms in harmonics that a motion repeating each mesh period has not, 0 to 1."""
        sizes = np.abs(amplitudes(self.orbit.coefficients))[1:] ** 2
        off = np.arange(1, len(sizes) + 1) % self.orbit.balance.subharmonics != 0
        return float(np.sqrt(sizes[off].sum() / sizes.sum())) if sizes.any() else 0.0

    @property
    def contact_state(self) -> str:
        """No loss, one-sided or double-sided, as `orbit.CONTACT_STATES` has it."""
        return self.orbit.contact_state

    @property
    def contact_loss(self) -> float:
        """Share of the period out of contact, 0 to 1."""
        return self.orbit.contact_loss


@dataclass(frozen=True)
class Bifurcation:
    """A motion at which the branch turns or its stability changes."""

    kind: str
    """One of BIFURCATIONS."""
    motion: Motion
    multiplier: complex
    """The multiplier that is on the unit circle."""

    @property
    def parameter(self) -> float:
        """Value of the branch's parameter."""
        return self.motion.parameter


@dataclass(frozen=True)
class Branch:
    """A branch in the order it was followed; bifurcations are among its motions too."""

    balance: Balance
    motions: tuple[Motion, ...]
    bifurcations: tuple[Bifurcation, ...]
    ended: str
    """Why it ends: `range`, `closed`, `halved` (it met a branch of a smaller period), `points`, or `lost`."""

    @property
    def subharmonics(self) -> int:
        """The period of its motions in mesh periods."""
        return self.balance.subharmonics

    @property
    def parameters(self) -> Array:
        """Values of the parameter along the branch, (n,)."""
        return np.array([m.parameter for m in self.motions])

    @cached_property
    def stable(self) -> NDArray[np.bool_]:
        """Which motions are stable, (n,); a bifurcation counts as its stable side."""
        marks = np.array([m.stable for m in self.motions], dtype=bool)
        margins = {id(b.motion) for b in self.bifurcations}
        for i, motion in enumerate(self.motions):
            if id(motion) in margins:
                marks[i] = bool(marks[max(i - 1, 0)] or marks[min(i + 1, len(marks) - 1)])
        return marks

    def runs(self) -> Iterator[tuple[int, int]]:
        """Yield (first, last) of stretches of stable motions along which the parameter only rises or only falls."""
        parameters, stable = self.parameters, self.stable
        first: int | None = None
        for i in range(len(stable)):
            if not stable[i]:
                if first is not None and i - 1 > first:
                    yield first, i - 1
                first = None
            elif first is None:
                first = i
            elif i - first >= 2 and (parameters[i] > parameters[i - 1]) != (parameters[i - 1] > parameters[i - 2]):
                yield first, i - 1
                first = i - 1
        if first is not None and len(stable) - 1 > first:
            yield first, len(stable) - 1


def joined(backward: Branch, forward: Branch) -> Branch:
    """Return one branch of two that were followed from the same motion in opposite directions."""
    motions = (*reversed(backward.motions[1:]), *forward.motions)
    events = (*reversed(backward.bifurcations), *forward.bifurcations)
    return Branch(forward.balance, motions, events, forward.ended)


def motions_at(branch: Branch, value: float) -> list[Motion]:
    """Return the motions of the branch at one value of its parameter, each solved there.

    Nearer to a fold than rounding, one of the two that meet there may be missing.
    """
    found: list[Motion] = []
    for a, b in pairwise(branch.motions):
        if (a.parameter - value) * (b.parameter - value) > 0 or a.parameter == b.parameter:
            continue
        share = (value - a.parameter) / (b.parameter - a.parameter)
        guess = (1 - share) * a.point.unknowns + share * b.point.unknowns
        try:
            unknowns = solve(branch.balance, guess, value)
        except NoSolutionError:
            continue
        if not any(np.abs(unknowns - m.point.unknowns).max() < _SAME for m in found):
            point = Point(unknowns, value, a.point.tangent)
            found.append(Motion(Orbit(branch.balance, branch.balance.at(value), unknowns), point))
    return found


def lies_on(branch: Branch, point: Point) -> bool:
    """Return whether a motion of the branch's period lies on the branch, in whichever mesh period it begins."""
    basis, n = branch.balance.basis, branch.subharmonics
    if len(point.unknowns) != basis.size:
        return False
    values = basis.values(point.unknowns)
    for other in motions_at(branch, point.parameter):
        for shift in range(n):
            turned = other.orbit.deflection(basis.phases + shift / n)
            if np.abs(turned - values).max() < _ALIKE * np.ptp(values):
                return True
    return False
