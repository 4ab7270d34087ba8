"""Service clients."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.services import Client

__all__ = ["Client"]

__getattr__ = missing_from(__name__)
