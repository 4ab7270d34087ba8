"""Parts of managed nodes."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.lifecycle.managed_entity import ManagedEntity, SimpleManagedEntity
from seat_gear_dynamics.runtime.lifecycle.state_machine import TransitionCallbackReturn

__all__ = ["ManagedEntity", "SimpleManagedEntity", "TransitionCallbackReturn"]

__getattr__ = missing_from(__name__)
