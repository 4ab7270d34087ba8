"""Contexts."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.context import Context

__all__ = ["Context"]

__getattr__ = missing_from(__name__)
