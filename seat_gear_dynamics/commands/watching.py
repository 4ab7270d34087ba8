"""Looking on at nodes: a listener is spun and a screen shows what it hears, until somebody ends it."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType

import rclpy

from seat_gear_dynamics.commands.listener import Listener
from seat_gear_dynamics.views.live_screen import Screen

_SPIN = 0.05  # s to wait for a message at most: how late a frame or an end may be
_NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Told:
    """Whether the program was told to end."""

    def __init__(self) -> None:
        self.to_end = False

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        self.to_end = True


@contextmanager
def told() -> Iterator[Told]:
    """Turn Ctrl-C, SIGTERM and the closing of the terminal into a word, so that the end comes in order.

    What the signals did before is put back afterwards. A closing that is ignored, as under nohup, stays so.
    """
    found = Told()
    before = {number: signal.getsignal(number) for number in _NUMBERS}
    heeded = [number for number in _NUMBERS if (number, before[number]) != (signal.SIGHUP, signal.SIG_IGN)]
    for number in heeded:
        signal.signal(number, found)
    try:
        yield found
    finally:
        for number in heeded:
            signal.signal(number, before[number])


def watch(node: Listener, screen: Screen, check: Callable[[], None], going_on: Callable[[float], bool]) -> None:
    """Spin `node` and show its state as often as `screen` wants, while `going_on(elapsed s)`.

    `check` is called before each frame; what it raises ends the watching.
    """
    begin, due, state = monotonic(), 0.0, node.state
    while going_on(elapsed := monotonic() - begin):
        state.elapsed = elapsed
        if elapsed >= due:
            check()
            if state.speed_rpm is not None:
                state.history.append((elapsed, abs(state.speed_rpm), state.level))
            screen.show(state)
            due = elapsed + screen.period
        rclpy.spin_once(node, timeout_sec=_SPIN)
