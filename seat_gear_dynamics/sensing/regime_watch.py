"""Watching the regime of a running drive: a sliding record of section points while speed and load are steady."""

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes import Regime, classify
from seat_gear_dynamics.regimes.classification import undecided

Array = NDArray[np.float64]

_RECORD = 192  # section points judged; at 1400 r/min half a second of the published time scale
_SETTLING = 32  # section points after a change of drive that are left to the transient
_EVERY = 16  # new section points between two judgements
_TOLERANCE = 0.05  # b_c; measured speed is noisy, so a periodic motion recurs only to about this


class RegimeWatch:
    """Judges the motion so far from the section points that came since the drive last changed.

    A drive is steady while frequency stays within `frequency_tolerance` (relative) and load within `load_tolerance`
    (relative) of where it was when the record began. Changing drives are undecided: a section of them mixes motions.
    """

    def __init__(self, *, frequency_tolerance: float = 0.01, load_tolerance: float = 0.05) -> None:
        self._tolerances = (frequency_tolerance, load_tolerance)
        self.reset("no section point yet")

    def reset(self, reason: str) -> None:
        """Forget the record; the regime is undecided with `reason` until there is a new one."""
        self._points = np.empty((0, 5))
        self._anchor: tuple[float, float] | None = None
        self._settling = _SETTLING
        self._fresh = 0
        self.regime: Regime = undecided(reason)

    def add(self, points: Array, frequency: float, load: float) -> Regime:
        """Take new section points, (n, 5) as `kernel.SECTION_COLUMNS`, met at this drive; return the regime."""
        if self._anchor is None or self._moved(frequency, load):
            reason = "the drive is not steady" if self._anchor is not None else "no section point yet"
            self.reset(reason)
            self._anchor = (frequency, load)
        dropped = min(self._settling, len(points))
        self._settling -= dropped
        kept = points[dropped:]
        if len(kept):
            self._points = np.concatenate([self._points, kept])[-_RECORD:]
            self._fresh += len(kept)
        if self._fresh >= _EVERY:
            self._fresh = 0
            self.regime = self._judge()
        return self.regime

    def _moved(self, frequency: float, load: float) -> bool:
        assert self._anchor is not None
        for now, then, tolerance in zip((frequency, load), self._anchor, self._tolerances, strict=True):
            if abs(now - then) > tolerance * abs(then):
                return True
        return False

    def _judge(self) -> Regime:
        # The drive's noise moves single periods; their mean is what the exponent is measured against.
        interval = float(np.mean(np.diff(self._points[:, 0]))) if len(self._points) > 1 else 1.0
        return classify(self._points[:, 1:3], self._points[:, 3], interval, tolerance=_TOLERANCE)
