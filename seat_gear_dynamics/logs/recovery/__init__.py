"""A readable log out of a damaged one: what a checksum vouches for is kept, the rest is named and left out."""

from seat_gear_dynamics.logs.recovery.recover import recover
from seat_gear_dynamics.logs.recovery.result import Recovery

__all__ = ["Recovery", "recover"]
