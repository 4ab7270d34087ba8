"""Signals."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.signals import (
    SignalHandlerOptions,
    get_current_signal_handlers_options,
    install_signal_handlers,
    uninstall_signal_handlers,
)

__all__ = [
    "SignalHandlerOptions",
    "get_current_signal_handlers_options",
    "install_signal_handlers",
    "uninstall_signal_handlers",
]

__getattr__ = missing_from(__name__)
