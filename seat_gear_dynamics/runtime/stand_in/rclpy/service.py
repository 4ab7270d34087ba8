"""Service servers."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.services import Service

__all__ = ["Service"]

__getattr__ = missing_from(__name__)
