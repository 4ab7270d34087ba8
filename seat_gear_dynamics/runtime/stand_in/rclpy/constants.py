"""Constants."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.time import S_TO_NS

__all__ = ["S_TO_NS"]

__getattr__ = missing_from(__name__)
