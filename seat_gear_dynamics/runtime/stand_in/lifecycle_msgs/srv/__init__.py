"""Services of the ROS package lifecycle_msgs, made when first used."""

from collections.abc import Callable
from typing import Any

from seat_gear_dynamics.runtime.messages import expose

__getattr__: Callable[[str], Any] = expose(__name__)
