"""Interface types by name."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.messages import get_message, get_service

__all__ = ["get_message", "get_service"]

__getattr__ = missing_from(__name__)
