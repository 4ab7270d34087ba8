"""Loggers."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.logging import (
    LoggingSeverity,
    RcutilsLogger,
    get_logger,
    get_logger_effective_level,
    get_logger_level,
    get_logging_severity_from_string,
    set_logger_level,
)

__all__ = [
    "LoggingSeverity",
    "RcutilsLogger",
    "get_logger",
    "get_logger_effective_level",
    "get_logger_level",
    "get_logging_severity_from_string",
    "set_logger_level",
]

__getattr__ = missing_from(__name__)
