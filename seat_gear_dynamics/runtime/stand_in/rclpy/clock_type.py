"""Kinds of clock."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.time import ClockType

__all__ = ["ClockType"]

__getattr__ = missing_from(__name__)
