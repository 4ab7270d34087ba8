"""Watching the regime of a running drive: a sliding record of section points while speed and load are steady."""

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes import Regime, classify
from seat_gear_dynamics.regimes.classification import undecided
from seat_gear_dynamics.sensing.steadiness import Standing

Array = NDArray[np.float64]

_RECORD = 192  # section points judged; at 1400 r/min half a second of the published time scale
_SETTLING = 32  # section points after a change of drive that are left to the transient
_EVERY = 16  # new section points between two judgements
_TOLERANCE = 0.05  # b_c; measured speed is noisy, so a periodic motion recurs only to about this
_ROOM = 4 * _RECORD  # points written before the last ones are moved to the front
FREQUENCY_FLOOR = 0.005
"""Change of dimensionless frequency that is none: 5 r/min of the packaged train, a bench's noise where it is coarse."""
LOAD_FLOOR = 10.0
"""N·m, likewise: twice the bench's noise, and a fifth of the way between two loads of a map."""


class RegimeWatch:
    """Judges the motion so far from the section points that came since the drive last changed.

    A drive is steady while frequency stays within `frequency_tolerance` (relative) and load within `load_tolerance`
    (relative) of where it was when the record began, as far as noise lets it be told: `Standing` has the test, which
    gives a change below FREQUENCY_FLOOR or LOAD_FLOOR no weight. Changing drives are undecided: a section of them mixes
    motions.
    """

    def __init__(self, *, frequency_tolerance: float = 0.01, load_tolerance: float = 0.05) -> None:
        self._frequency = Standing(frequency_tolerance, FREQUENCY_FLOOR)
        self._load = Standing(load_tolerance, LOAD_FLOOR, held=True)
        self._points = np.empty((_ROOM, 5))
        self.reset("no section point yet")

    def reset(self, reason: str) -> Regime:
        """Forget record and noise; the regime, which is returned, is undecided with `reason` until a new record."""
        self._frequency.forget()
        self._load.forget()
        self._begin(reason)
        return self.regime

    def drive(self, t: float, frequency: float, load: float) -> Regime:
        """Take the drive at time `t`, s, before the motion up to there is known; the record begins anew if it moved.

        `frequency` is dimensionless, `load` in N·m; times must not decrease. Returns the regime so far.
        """
        moved = self._frequency.moved(t, frequency), self._load.moved(t, load)
        if any(moved):
            self._frequency.begin(t, frequency)
            self._load.begin(t, load)
            self._begin("the drive is not steady")
        return self.regime

    def add(self, points: Array) -> Regime:
        """Take the section points, (n, 5) as `kernel.SECTION_COLUMNS`, met on the way to the last drive.

        Returns the regime.
        """
        if len(points):
            self._take(points)
        return self.regime

    def _begin(self, reason: str) -> None:
        self._first = self._end = 0
        self._settling = _SETTLING
        self._fresh = 0
        self.regime: Regime = undecided(reason)

    def _take(self, points: Array) -> None:
        dropped = min(self._settling, len(points))
        self._settling -= dropped
        self._keep(points[max(dropped, len(points) - _RECORD) :])
        self._fresh += len(points) - dropped
        if self._fresh >= _EVERY:
            self._fresh = 0
            self.regime = self._judge(self._points[self._first : self._end])

    def _keep(self, points: Array) -> None:
        """Write points behind those that are there; the last _RECORD count."""
        if self._end + len(points) > _ROOM:
            kept = self._end - self._first
            self._points[:kept] = self._points[self._first : self._end]
            self._first, self._end = 0, kept
        self._points[self._end : self._end + len(points)] = points
        self._end += len(points)
        self._first = max(self._first, self._end - _RECORD)

    def _judge(self, points: Array) -> Regime:
        # The drive's noise moves single periods; their mean is what the exponent is measured against.
        interval = float(np.mean(np.diff(points[:, 0]))) if len(points) > 1 else 1.0
        return classify(points[:, 1:3], points[:, 3], interval, tolerance=_TOLERANCE)
