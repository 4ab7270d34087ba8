"""Publishers of managed nodes."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.lifecycle.publisher import LifecyclePublisher

__all__ = ["LifecyclePublisher"]

__getattr__ = missing_from(__name__)
