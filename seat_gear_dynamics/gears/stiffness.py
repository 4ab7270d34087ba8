"""Time-varying mesh stiffness of a spur pair by the potential-energy method, (3)-(9)."""

from dataclasses import dataclass
from functools import lru_cache
from math import pi, sin

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears.excitation import PeriodicSeries, fourier_series
from seat_gear_dynamics.gears.tooth import Tooth, base_pitch, contact_ratio, path_of_contact

Array = NDArray[np.float64]

_SAMPLES = 1024  # per mesh period; the double-contact boundary is then placed to 0.1 % of a period


@dataclass(frozen=True)
class MeshStiffness:
    """Mesh stiffness sampled at equal steps over one mesh period; phase 0 is where a tooth pair enters contact."""

    phase: Array
    """shape (n,), mesh phase in [0, 1)"""
    values: Array
    """shape (n,), N/m"""
    contact_ratio: float

    @property
    def mean(self) -> float:
        """Mean over the period, N/m."""
        return float(np.mean(self.values))

    def series(self, harmonics: int) -> PeriodicSeries:
        """Return its first `harmonics` Fourier harmonics, N/m; jumps ring (Gibbs), by less the more are kept."""
        return fourier_series(self.values, harmonics)


@lru_cache(maxsize=32)
def mesh_stiffness(driver: Tooth, driven: Tooth, *, foundation: bool = True) -> MeshStiffness:
    """Return the potential-energy stiffness of a pair over one mesh period.

    Tooth pairs in contact act in parallel, and in a pair the Hertzian (5), bending (6), axial (7), shear (8) and, with
    `foundation`, fillet-foundation compliances of both gears act in series (9).

    Limits: contact ratios from 1 to 2; ideal involutes without deviation; neighbouring teeth do not share their
    foundation, which overstates the stiffness of double contact by some per cent (Xie et al. 2017).
    """
    ratio = contact_ratio(driver, driven)
    if not 1 <= ratio < 2:
        raise ValueError(
            f"The pair's contact ratio is {ratio:.3f}; the stiffness model covers 1 to 2: change the gears."
        )
    phase = np.arange(_SAMPLES) / _SAMPLES
    start, _ = path_of_contact(driver, driven)
    pitch = base_pitch(driver)
    values = np.array([_pair_stiffness(driver, driven, start + p * pitch, foundation) for p in phase])
    for i in np.flatnonzero(phase < ratio - 1):
        values[i] += _pair_stiffness(driver, driven, start + (phase[i] + 1) * pitch, foundation)
    for shared in (phase, values):  # every caller gets the same arrays from the cache
        shared.setflags(write=False)
    return MeshStiffness(phase, values, ratio)


def _pair_stiffness(driver: Tooth, driven: Tooth, position: float, foundation: bool) -> float:
    """Return the stiffness of one tooth pair in contact at `position` on the line of action, N/m."""
    line = (driver.pitch_radius + driven.pitch_radius) * sin(driver.pressure_angle)
    rolls = (position / driver.base_radius, (line - position) / driven.base_radius)
    compliance = _hertzian_compliance(driver, driven)
    for tooth, roll in zip((driver, driven), rolls, strict=True):
        compliance += tooth.beam_compliance(roll)
        if foundation:
            compliance += tooth.foundation_compliance(roll)
    return 1 / compliance


def _hertzian_compliance(driver: Tooth, driven: Tooth) -> float:
    """Return 1/k_h of (5), m/N, with the common face width and the mean of the two materials' compliances."""
    width = min(driver.width, driven.width)
    per_tooth = [4 * (1 - t.poisson_ratio**2) / (pi * t.youngs_modulus * width) for t in (driver, driven)]
    return sum(per_tooth) / 2
