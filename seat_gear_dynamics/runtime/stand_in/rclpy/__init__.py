"""The client library of ROS 2, as far as the bundled runtime has it."""

from seat_gear_dynamics.runtime.absent import install_finder, missing_from
from seat_gear_dynamics.runtime.client_library import (
    create_node,
    get_global_executor,
    init,
    shutdown,
    spin,
    spin_once,
    spin_until_future_complete,
)
from seat_gear_dynamics.runtime.context import Context, get_default_context, ok, try_shutdown
from seat_gear_dynamics.runtime.parameters.parameter import Parameter
from seat_gear_dynamics.runtime.signals import SignalHandlerOptions, install_signal_handlers, uninstall_signal_handlers
from seat_gear_dynamics.runtime.tasks import Future

__all__ = [
    "Context",
    "Future",
    "Parameter",
    "SignalHandlerOptions",
    "create_node",
    "get_default_context",
    "get_global_executor",
    "init",
    "install_signal_handlers",
    "ok",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
    "uninstall_signal_handlers",
]

install_finder()
__getattr__ = missing_from(__name__)
