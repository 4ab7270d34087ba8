"""Executors."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.executor import (
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)

__all__ = [
    "Executor",
    "ExternalShutdownException",
    "MultiThreadedExecutor",
    "ShutdownException",
    "SingleThreadedExecutor",
    "TimeoutException",
]

__getattr__ = missing_from(__name__)
