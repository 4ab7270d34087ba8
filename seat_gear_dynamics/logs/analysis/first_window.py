"""The first force window of a log: it may begin behind a message that was published before anybody recorded."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from seat_gear_dynamics.sensing import ForceWindow

Windows = tuple[ForceWindow, ForceWindow]

_ROOM = 512
"""Samples looked back over; a window is as long as the monitor's force period, 0.02 s by default."""


class FirstWindow:
    """Keeps the force windows sample by sample until the first force message of a log has come.

    A recorder finds each topic by itself, so the inputs may be whole where the first forces are missing. The window of
    the first message there is then begins at a sample that the log holds and at a message that it does not.
    """

    def __init__(self) -> None:
        self._samples: deque[Windows] = deque(maxlen=_ROOM)

    def feed(self, windows: Windows) -> None:
        """Take what one sample added."""
        self._samples.append(windows)

    def later(self) -> Iterator[Windows]:
        """Yield the window from each sample behind the first on, the latest beginning first.

        Samples are merged in the order in which a session merges them, so one of these is the monitor's bit for bit.
        """
        samples = list(self._samples)
        for begin in range(len(samples) - 1, 0, -1):
            first, second = ForceWindow(), ForceWindow()
            for a, b in samples[begin:]:
                first, second = first.merged(a), second.merged(b)
            yield first, second
