"""Subscriptions."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.endpoints import Subscription

__all__ = ["Subscription"]

__getattr__ = missing_from(__name__)
