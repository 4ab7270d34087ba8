"""Timers."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.timer import Rate, Timer

__all__ = ["Rate", "Timer"]

__getattr__ = missing_from(__name__)
