"""Messages as bytes."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.client_library import deserialize_message, serialize_message

__all__ = ["deserialize_message", "serialize_message"]

__getattr__ = missing_from(__name__)
