"""Callback groups."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.groups import CallbackGroup, MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup

__all__ = ["CallbackGroup", "MutuallyExclusiveCallbackGroup", "ReentrantCallbackGroup"]

__getattr__ = missing_from(__name__)
