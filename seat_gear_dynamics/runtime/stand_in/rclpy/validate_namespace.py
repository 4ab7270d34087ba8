"""Namespaces."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.names import validate_namespace

__all__ = ["validate_namespace"]

__getattr__ = missing_from(__name__)
