"""Loggers with rclpy's filters, rcl's console format on stderr, and a way out to /rosout."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Any


class LoggingSeverity(IntEnum):
    """Severities of log messages; UNSET means "as the parent logger"."""

    UNSET = 0
    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50


_levels: dict[str, LoggingSeverity] = {"": LoggingSeverity.INFO}
_sinks: dict[str, Callable[[dict[str, Any]], None]] = {}
_lock = threading.Lock()
_state = {"console": True}

_DEFAULT_FORMAT = "[{severity}] [{time}] [{name}]: {message}"


def configure(levels: Mapping[str, str], console: bool) -> None:
    """Apply the levels of a command line by logger name ("" is all), and whether to write to the console.

    Raises:
        RuntimeError: a level is not one of debug, info, warn, error, fatal, unset.
    """
    _state["console"] = console
    for name, level in levels.items():
        _levels[name] = get_logging_severity_from_string(level)


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Return the severity of a name in any case.

    Raises:
        RuntimeError: it is not such a name.
    """
    try:
        return LoggingSeverity[log_severity.upper()]
    except KeyError:
        raise RuntimeError(
            f"{log_severity!r} is not a log level: expected debug, info, warn, error, fatal or unset."
        ) from None


def set_logger_level(name: str, level: int | LoggingSeverity, detailed_error: bool = False) -> None:
    """Set the lowest severity a logger and its children let through."""
    _levels[name] = LoggingSeverity(level)


def get_logger_level(name: str) -> LoggingSeverity:
    """Return the severity set for exactly this logger."""
    return _levels.get(name, LoggingSeverity.UNSET)


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """Return the lowest severity a logger lets through, its own or its nearest parent's."""
    while True:
        level = _levels.get(name, LoggingSeverity.UNSET)
        if level or not name:
            return level or LoggingSeverity.INFO
        name = name.rpartition(".")[0]


def add_sink(name: str, sink: Callable[[dict[str, Any]], None]) -> None:
    """Send what a logger and its children let through to a function too (that is how /rosout gets it)."""
    with _lock:
        _sinks[name] = sink


def remove_sink(name: str) -> None:
    """Stop sending a logger's messages to its function."""
    with _lock:
        _sinks.pop(name, None)


class _Site:
    """State of the filters at one place of the source."""

    def __init__(self, severity: LoggingSeverity, filters: tuple[tuple[str, Any], ...]) -> None:
        self.severity = severity
        self.filters = filters
        self.last_ns = 0
        self.calls = 0

    def lets_through(self) -> bool:
        """Return whether the message at this place passes; every filter sees every call."""
        options = dict(self.filters)
        self.calls += 1
        if options.get("throttle_duration_sec"):
            clock = options.get("throttle_time_source_type")
            now = clock.now().nanoseconds if clock is not None else time.time_ns()
            if now < self.last_ns + options["throttle_duration_sec"] * 1e9:
                return False
            self.last_ns = now
        if options.get("skip_first") and self.calls == 1:
            return False
        if options.get("once"):
            first = 2 if options.get("skip_first") else 1
            return self.calls == first
        return True


_FILTERS = ("throttle_duration_sec", "throttle_time_source_type", "skip_first", "once")


class RcutilsLogger:
    """A named logger; `debug` to `fatal` take the filters throttle_duration_sec (s), skip_first and once."""

    def __init__(self, name: str = "") -> None:
        self.name = name
        self._sites: dict[tuple[Any, int], _Site] = {}

    def get_child(self, name: str) -> RcutilsLogger:
        """Return the logger `name` below this one.

        Raises:
            ValueError: the name is empty.
        """
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(f"{self.name}.{name}" if self.name else name)

    def set_level(self, level: int | LoggingSeverity) -> None:
        """Set the lowest severity this logger and its children let through."""
        set_logger_level(self.name, level)

    def get_effective_level(self) -> LoggingSeverity:
        """Return the lowest severity this logger lets through."""
        return get_logger_effective_level(self.name)

    def is_enabled_for(self, severity: int | LoggingSeverity) -> bool:
        """Return whether a severity is let through."""
        return severity >= get_logger_effective_level(self.name)

    def log(self, message: str, severity: int | LoggingSeverity, **kwargs: Any) -> bool:
        """Log a message; return whether it was not held back by the level or a filter.

        Raises:
            TypeError: an option is not one of the filters.
            ValueError: severity or filters change between calls at one place of the source.
        """
        return self._log(message, LoggingSeverity(severity), kwargs)

    def debug(self, message: str, **kwargs: Any) -> bool:
        """Log with severity DEBUG; see `log`."""
        return self._log(message, LoggingSeverity.DEBUG, kwargs)

    def info(self, message: str, **kwargs: Any) -> bool:
        """Log with severity INFO; see `log`."""
        return self._log(message, LoggingSeverity.INFO, kwargs)

    def warning(self, message: str, **kwargs: Any) -> bool:
        """Log with severity WARN; see `log`."""
        return self._log(message, LoggingSeverity.WARN, kwargs)

    def warn(self, message: str, **kwargs: Any) -> bool:
        """Log with severity WARN; see `log`."""
        return self._log(message, LoggingSeverity.WARN, kwargs)

    def error(self, message: str, **kwargs: Any) -> bool:
        """Log with severity ERROR; see `log`."""
        return self._log(message, LoggingSeverity.ERROR, kwargs)

    def fatal(self, message: str, **kwargs: Any) -> bool:
        """Log with severity FATAL; see `log`."""
        return self._log(message, LoggingSeverity.FATAL, kwargs)

    def _log(self, message: str, severity: LoggingSeverity, options: dict[str, Any]) -> bool:
        if severity < get_logger_effective_level(self.name):
            return False
        name = options.pop("name", self.name)
        frame = sys._getframe(2)
        if options and not self._site(frame, severity, options).lets_through():
            return False
        code = frame.f_code
        _emit(severity, name, str(message), code.co_filename, code.co_name, frame.f_lineno)
        return True

    def _site(self, frame: Any, severity: LoggingSeverity, options: dict[str, Any]) -> _Site:
        for option in options:
            if option not in _FILTERS:
                raise TypeError(f"parameter {option!r} is not one of the recognized logging options {list(_FILTERS)}")
        key = (frame.f_code, frame.f_lasti)
        filters = tuple(options.items())
        site = self._sites.setdefault(key, _Site(severity, filters))
        if site.severity != severity:
            raise ValueError("Logger severity cannot be changed between calls.")
        if site.filters != filters:
            raise ValueError("Logging filter parameters cannot be changed between calls.")
        return site


def _emit(severity: LoggingSeverity, name: str, message: str, path: str, function: str, line: int) -> None:
    now = time.time_ns()
    if _state["console"]:
        pattern = os.environ.get("RCUTILS_CONSOLE_OUTPUT_FORMAT", _DEFAULT_FORMAT)
        values = {
            "severity": severity.name,
            "time": f"{now // 10**9}.{now % 10**9:09d}",
            "time_as_nanoseconds": str(now),
            "name": name,
            "message": message,
            "file_name": path,
            "function_name": function,
            "line_number": str(line),
        }
        text = pattern
        for token, value in values.items():
            if token != "message":
                text = text.replace(f"{{{token}}}", value)
        sys.stderr.write(text.replace("{message}", message) + "\n")
    sink = _sink_of(name)
    if sink is not None:
        sink(
            {
                "now_ns": now,
                "level": int(severity),
                "name": name,
                "msg": message,
                "file": path,
                "function": function,
                "line": line,
            }
        )


def _sink_of(name: str) -> Callable[[dict[str, Any]], None] | None:
    while name:
        if name in _sinks:
            return _sinks[name]
        name = name.rpartition(".")[0]
    return None


_root = RcutilsLogger()


def get_logger(name: str) -> RcutilsLogger:
    """Return the logger of a name; dots make children.

    Raises:
        ValueError: the name is empty.
    """
    if not name:
        raise ValueError("Logger name must not be empty.")
    return _root.get_child(name)
