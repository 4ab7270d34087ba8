"""Clocks."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.clock import Clock, ROSClock
from seat_gear_dynamics.runtime.time import ClockType
from seat_gear_dynamics.runtime.time_jumps import ClockChange, JumpHandle, JumpThreshold, TimeJump

__all__ = ["Clock", "ClockChange", "ClockType", "JumpHandle", "JumpThreshold", "ROSClock", "TimeJump"]

__getattr__ = missing_from(__name__)
