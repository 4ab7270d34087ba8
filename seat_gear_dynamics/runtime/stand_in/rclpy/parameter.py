"""Parameters."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.parameters.parameter import (
    PARAMETER_SEPARATOR_STRING,
    Parameter,
    parameter_value_to_python,
)

__all__ = ["PARAMETER_SEPARATOR_STRING", "Parameter", "parameter_value_to_python"]

__getattr__ = missing_from(__name__)
