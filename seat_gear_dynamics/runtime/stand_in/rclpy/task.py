"""Futures and tasks."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.tasks import Future, Task

__all__ = ["Future", "Task"]

__getattr__ = missing_from(__name__)
