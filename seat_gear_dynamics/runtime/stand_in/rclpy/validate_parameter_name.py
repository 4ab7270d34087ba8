"""Parameter names."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.names import validate_parameter_name

__all__ = ["validate_parameter_name"]

__getattr__ = missing_from(__name__)
