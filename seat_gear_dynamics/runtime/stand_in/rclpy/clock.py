"""Clocks."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.clock import Clock, ROSClock
from seat_gear_dynamics.runtime.time import ClockType

__all__ = ["Clock", "ClockType", "ROSClock"]

__getattr__ = missing_from(__name__)
