"""The other witness: a motion of P12 integrated by the march, sampled over its period, and as a start for a branch."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion import Inputs, March, System
from seat_gear_dynamics.studies.harmonic_balance.balance import Balance
from seat_gear_dynamics.studies.harmonic_balance.fourier import Basis
from seat_gear_dynamics.studies.harmonic_balance.orbit import Orbit

Array = NDArray[np.float64]

FINE_STEPS = 17 * 64
"""Steps per mesh period, rounded up by the march to a multiple of 17, at which its own error is below 1e-5."""
_POINTS = 16 * 17
_SLACK = 1e-5  # of a part: less than the shortest step, more than rounding of τ


@dataclass(frozen=True)
class Recorded:
    """δ of P12 over whole mesh periods from mesh phase 0 on."""

    deflection: Array
    """δ/b_c at even phases, (periods, n)."""
    state: Array
    """State of the train at the end, (24,), at mesh phase 0."""

    def repeats(self, periods: int) -> float:
        """Return how far δ is from itself `periods` mesh periods later, over its range; NaN if it was too short."""
        if len(self.deflection) <= periods:
            return float("nan")
        apart = np.abs(self.deflection[periods:] - self.deflection[:-periods]).max()
        return float(apart / np.ptp(self.deflection))


def settle(
    system: System, *, periods: int, transient: int, state: Array | None = None, target_steps: int = FINE_STEPS
) -> Recorded:
    """Integrate `transient` mesh periods from `state` (24,), or from rest, and record δ over `periods` more.

    Raises `motion.march.DivergedError` where the solution blows up. The pair's slowest mode outlives any transient of
    moderate length where its torsional supports are as soft as the packaged ones; it hardly shows in δ.
    """
    point = system.operating_point
    march = March(system.train, load=point.load, target_steps=max(-(-target_steps // _POINTS), 1) * _POINTS)
    if state is not None:
        march.state = state
    inputs, part = Inputs(point.frequency, point.load), 2 * pi / point.frequency / _POINTS

    def through(parts: int) -> None:
        march.advance((march.tau, inputs), ((parts - _SLACK) * part, inputs))

    begin = transient * _POINTS
    through(begin)
    found = np.empty(periods * _POINTS)
    for i in range(len(found)):
        found[i] = march.meshes(point.frequency)[0, 0]
        through(begin + i + 1)
    return Recorded(found.reshape(periods, _POINTS), march.state)


def coefficients(recorded: Recorded, balance: Balance) -> Array:
    """Return the harmonics of the first n recorded periods, as a start for Newton's method, n the balance's."""
    values = recorded.deflection[: balance.subharmonics].ravel()
    kept = min(balance.basis.harmonics, (len(values) - 1) // 2)
    return balance.basis.resampled(Basis(kept, len(values)).coefficients(values))


def difference(recorded: Recorded, orbit: Orbit) -> float:
    """Return the largest distance of recorded δ from the orbit over one period of it, over the orbit's range.

    The recording may begin in any of the orbit's mesh periods; the nearest is taken.
    """
    n = orbit.balance.subharmonics
    values = recorded.deflection[:n].ravel()
    if len(values) < n * _POINTS:
        raise ValueError(f"{len(recorded.deflection)} mesh periods were recorded, expected at least {n}.")
    expected = orbit.deflection(np.arange(len(values)) / len(values))
    apart = min(float(np.abs(np.roll(expected, shift * _POINTS) - values).max()) for shift in range(n))
    return apart / float(np.ptp(expected))
