"""Managed nodes."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.lifecycle.managed_entity import ManagedEntity, SimpleManagedEntity
from seat_gear_dynamics.runtime.lifecycle.node import LifecycleNode, LifecycleNodeMixin
from seat_gear_dynamics.runtime.lifecycle.publisher import LifecyclePublisher
from seat_gear_dynamics.runtime.lifecycle.state_machine import LifecycleState, TransitionCallbackReturn

Node = LifecycleNode
NodeMixin = LifecycleNodeMixin
State = LifecycleState
Publisher = LifecyclePublisher

__all__ = [
    "LifecycleNode",
    "LifecycleNodeMixin",
    "LifecyclePublisher",
    "LifecycleState",
    "ManagedEntity",
    "SimpleManagedEntity",
    "TransitionCallbackReturn",
]

__getattr__ = missing_from(__name__)
