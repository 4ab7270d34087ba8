"""Where two stretches of an estimate meet: whether the later one goes on as the earlier one would have."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import STATE_NAMES
from seat_gear_dynamics.motion.tables import LEVELS, tables
from seat_gear_dynamics.sensing.virtual_sensor import SENSOR_STATE_NAMES

Array = NDArray[np.float64]

SAME_MOTION = 0.05
"""b_c, and b_c per τ: as near as the monitor takes points of a measured periodic motion for the same one."""
SAME_PHASE = 0.01
"""Mesh periods of P12; the seams of a day are within a tenth of it, as the phase is the integral of the speed."""
_LONGEST = 16
"""Mesh periods of the longest motion looked for."""
_HALF = len(STATE_NAMES) // 2  # displacements, then as many rates
_TAU, _PLACE, _FREQUENCY = (SENSOR_STATE_NAMES.index(name) for name in ("tau", "phase/place", "sample/frequency"))
_RESTARTED, _SAMPLE = (SENSOR_STATE_NAMES.index(name) for name in ("restarted/s", "sample/s"))


class Join(Enum):
    """How the later of two stretches goes on at a seam."""

    SAME = "same"
    """In the state in which the earlier ended."""
    SHIFTED = "shifted"
    """In the same motion of more than one mesh period, some mesh periods earlier or later."""
    CHAOS = "chaos"
    """In chaos, as the earlier ended, on another path."""
    NONE = "none"
    """Elsewhere."""


class Seam(NamedTuple):
    """A session at one sample: its sensor's state (58,), its last section points (n, 3), what it says of the drive."""

    state: Array
    section: Array
    level: int
    in_band: bool
    regime: str


class Phase:
    """Mesh phases of P12 as a march counts them: in finest steps of the cycle after which all teeth meet again."""

    def __init__(self, train: GearTrain) -> None:
        grid = tables(train)
        self._period, self._cycle = grid.base << (LEVELS - 1), grid.cycle
        self._time_scale, self._coupled = train.model.time_scale, train.shaft.couples

    def set(self, state: Array, phase: float) -> Array:
        """Return a sensor's state at another phase, in mesh periods."""
        moved = state.copy()
        moved[_PLACE] = round(phase * self._period) % self._cycle
        return moved

    def join(self, earlier: Seam, later: Seam) -> Join:
        """Return how two sessions at the same sample agree; NONE too where they do not say the same of the drive.

        The model is deterministic: equal state, phase and drive give equal motion ever after, and what differs by less
        than SAME_MOTION in calm motion dies out as any transient. A motion of n mesh periods is the same motion
        begun a mesh period later; then P12 is held against the section that many points ago, P34 as it is. In chaos
        no two paths agree, nor do those of two builds of this program; both being chaotic at one drive is all that can
        be asked, and says nothing where two chaotic motions coexist.
        """
        if (earlier.level, earlier.in_band, earlier.regime) != (later.level, later.in_band, later.regime):
            return Join.NONE
        apart = (earlier.state[_PLACE] - later.state[_PLACE] + self._cycle / 2) % self._cycle - self._cycle / 2
        if abs(apart) > SAME_PHASE * self._period:
            return Join.NONE
        near = self._near(earlier.state, later.state)
        if near[0] and near[1]:
            return Join.SAME
        if earlier.regime == "chaotic":
            return Join.CHAOS
        shifted = not self._coupled and near[1] and _shifted(earlier.section, later.section)
        return Join.SHIFTED if shifted and earlier.regime == "periodic" else Join.NONE

    def _near(self, a: Array, b: Array) -> tuple[bool, bool]:
        """Return of each pair whether its state is the same.

        Each march is ahead of the sample by less than a step; that is taken out to first order, from the rates.
        """
        rates = b[_HALF : 2 * _HALF]
        places = np.abs(a[:_HALF] - b[:_HALF] - (self._lead(a) - self._lead(b)) * rates)
        apart = np.maximum(places, np.abs(a[_HALF : 2 * _HALF] - rates)).reshape(2, -1).max(axis=1)
        return bool(apart[0] < SAME_MOTION), bool(apart[1] < SAME_MOTION)

    def _lead(self, state: Array) -> float:
        """Return by how much a march is ahead of its sample, units of τ."""
        return float(state[_TAU] - (state[_SAMPLE] - state[_RESTARTED]) * self._time_scale)


def _shifted(earlier: Array, later: Array) -> bool:
    """Return whether the last section points are those of some points before."""
    for shift in range(1, _LONGEST):
        a, b = earlier[-_LONGEST - shift : -shift, :2], later[-_LONGEST:, :2]
        if len(a) == len(b) == _LONGEST and np.abs(a - b).max() < SAME_MOTION:
            return True
    return False
