"""Managed nodes."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.lifecycle.node import LifecycleNode, LifecycleNodeMixin
from seat_gear_dynamics.runtime.lifecycle.state_machine import LifecycleState, TransitionCallbackReturn

__all__ = ["LifecycleNode", "LifecycleNodeMixin", "LifecycleState", "TransitionCallbackReturn"]

__getattr__ = missing_from(__name__)
