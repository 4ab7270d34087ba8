"""Points in time."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.time import Time

__all__ = ["Time"]

__getattr__ = missing_from(__name__)
