"""End a spinning program on SIGINT and SIGTERM, with rclpy's meaning of both."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from enum import Enum
from types import FrameType
from typing import Any

_Handler = Callable[[int, FrameType | None], Any]


class SignalHandlerOptions(Enum):
    """Which signals `rclpy.init` takes over."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


_originals: dict[int, Any] = {}
_invalidators: list[Callable[[], None]] = []


def on_signal(invalidate: Callable[[], None]) -> None:
    """Have a function called when one of the signals comes; it must only mark and wake."""
    _invalidators.append(invalidate)


def _handle(number: int, frame: FrameType | None) -> None:
    """Mark every context as shut down, then let the earlier handler act.

    Python's own SIGINT handler raises KeyboardInterrupt; SIGTERM has none, so that spinning ends with
    ExternalShutdownException.
    """
    for invalidate in tuple(_invalidators):
        invalidate()
    original = _originals.get(number)
    if callable(original):
        original(number, frame)


def install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    """Take over SIGINT, SIGTERM, both or neither. Outside the main thread Python allows none: nothing happens."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number, option in (
        (signal.SIGINT, SignalHandlerOptions.SIGINT),
        (signal.SIGTERM, SignalHandlerOptions.SIGTERM),
    ):
        if options in (option, SignalHandlerOptions.ALL) and number not in _originals:
            _originals[number] = signal.signal(number, _handle)


def uninstall_signal_handlers() -> None:
    """Give SIGINT and SIGTERM back, unless somebody has taken them over since."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in tuple(_originals):
        if signal.getsignal(number) is _handle:
            signal.signal(number, _originals.pop(number))


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Return which signals are taken over now."""
    have = (signal.SIGINT in _originals) + 2 * (signal.SIGTERM in _originals)
    return SignalHandlerOptions(have)
