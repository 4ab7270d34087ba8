"""Rows in their order of coming, of which every reader gets each once, and the trend of many in few."""

from collections import deque
from collections.abc import Iterable
from itertools import islice
from math import floor, sqrt

Row = list[float]


class Series:
    """The last `room` rows, numbered from 0; a reader asks for those since the number it had come to."""

    def __init__(self, room: int) -> None:
        self._rows: deque[Row] = deque(maxlen=room)
        self.end = 0
        """Number of the next row."""

    def extend(self, rows: Iterable[Row]) -> None:
        """Append rows; the oldest go."""
        before = self.end
        for row in rows:
            self._rows.append(row)
            before += 1
        self.end = before

    def since(self, number: int) -> list[Row]:
        """Return the rows from `number` on that are still kept."""
        begin = self.end - len(self._rows)
        return list(islice(self._rows, max(number - begin, 0), None))


class Trend:
    """Force windows merged over stretches of `step` s: mean of means, least, greatest, and rms of rms.

    Takes rows of (t, then mean, min, max, rms for each mesh) and gives rows of the same form, t at a stretch's middle.
    The monitor's windows are of nearly equal length, so that they count alike.
    """

    def __init__(self, step: float, room: int) -> None:
        self.series = Series(room)
        self._step = step
        self._stretch: int | None = None
        self._open: list[Row] = []

    def add(self, row: Row) -> None:
        """Take one window."""
        stretch = floor(row[0] / self._step)
        if stretch != self._stretch and self._open:
            self.series.extend([self._merged()])
            self._open = []
        self._stretch = stretch
        self._open.append(row)

    def _merged(self) -> Row:
        columns = list(zip(*self._open, strict=True))
        merged = [((self._stretch or 0) + 0.5) * self._step]
        for first in range(1, len(columns), 4):
            mean, low, high, rms = columns[first : first + 4]
            count = len(mean)
            merged += [sum(mean) / count, min(low), max(high), sqrt(sum(value * value for value in rms) / count)]
        return merged
