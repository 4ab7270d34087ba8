"""Noise of a measured quantity, from how each sample lies off the line between its neighbours."""

from collections import deque
from math import pi, sqrt

_KEPT = 32  # last samples that the noise is measured on
_LEAST = 16  # samples below which no noise is measured
_OLDEST = 2.0  # s; what is older says nothing of the noise now
_MEDIAN = 0.6744897501960817  # of |x| where x is normal with deviation 1
_MEAN = sqrt(2 / pi)  # likewise


class Differences:
    """Second differences of the last 32 samples, at most 2 s old; times in s, the quantity in its own unit.

    A second difference sees neither level nor slope (von Neumann et al. 1941). Where a value is `held` between its
    measurements, samples that repeat it are none. Each is worked out once, as its last sample comes.
    """

    def __init__(self, *, held: bool = False) -> None:
        self._held = held
        self._samples: deque[tuple[float, float]] = deque(maxlen=_KEPT)
        self._off: deque[float] = deque(maxlen=_KEPT - 2)

    def add(self, t: float, value: float) -> None:
        """Take a sample; times must not decrease."""
        kept = self._samples
        if not (self._held and kept and value == kept[-1][1]):
            if len(kept) >= 2:
                self._off.append(_off_line(kept[-2], kept[-1], (t, value)))
            kept.append((t, value))
        while kept and kept[0][0] < t - _OLDEST:
            kept.popleft()
            if self._off:
                self._off.popleft()

    def robust(self) -> float:
        """Return the standard deviation of white noise by the median difference; 0 for less than 16 samples.

        Neither a step nor a single spike moves it (Rousseeuw & Croux 1993); a sensor's steps may hide the noise in it.
        """
        if len(self._samples) < _LEAST:
            return 0.0
        ordered, half = sorted(self._off), len(self._off) // 2
        middle = ordered[half] if len(ordered) % 2 else (ordered[half - 1] + ordered[half]) / 2
        return middle / _MEDIAN

    def average(self) -> float:
        """Return it by the mean difference, which a sensor's steps do not hide; 0 for less than 16 samples.

        A step of the quantity by s adds about s/20 to it until 32 samples have passed.
        """
        return sum(self._off) / len(self._off) / _MEAN if len(self._samples) >= _LEAST else 0.0


def _off_line(first: tuple[float, float], middle: tuple[float, float], last: tuple[float, float]) -> float:
    """Return how far `middle` lies off the line between its neighbours, over what unit noise gives; (s, value) each."""
    whole = last[0] - first[0]
    after = (middle[0] - first[0]) / whole if whole > 0 else 0.5
    off = middle[1] - ((1 - after) * first[1] + after * last[1])
    return abs(off) / sqrt(1 + (1 - after) * (1 - after) + after * after)
