"""Durations."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.time import Duration, Infinite

__all__ = ["Duration", "Infinite"]

__getattr__ = missing_from(__name__)
