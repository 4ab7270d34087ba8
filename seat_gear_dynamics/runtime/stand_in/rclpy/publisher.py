"""Publishers."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.endpoints import Publisher

__all__ = ["Publisher"]

__getattr__ = missing_from(__name__)
