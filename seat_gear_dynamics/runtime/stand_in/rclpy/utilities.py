"""Context helpers."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.client_library import remove_ros_args
from seat_gear_dynamics.runtime.context import get_default_context, ok, try_shutdown
from seat_gear_dynamics.runtime.context import shutdown_context as shutdown

__all__ = ["get_default_context", "ok", "remove_ros_args", "shutdown", "try_shutdown"]

__getattr__ = missing_from(__name__)
