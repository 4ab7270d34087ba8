"""Messages of a log turned into arrays for figures and reports."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.logs.errors import LogError

Array = NDArray[np.float64]
_FLOAT64 = {0: struct.Struct(">4xd"), 1: struct.Struct("<4xd")}  # by the CDR header's byte order


class Status(NamedTuple):
    """A DiagnosticStatus: s since the log's start, level (0 OK, 1 WARN, 2 ERROR, 3 STALE), text, values."""

    time: float
    level: int
    message: str
    values: dict[str, str]


@dataclass(frozen=True)
class JointSeries:
    """A JointState topic of n messages.

    `time`: log time, s since the log's start, shape (n,). `stamp_ns`: the headers' stamps, ns, shape (n,).
    `position`, `velocity`, `effort`: name → array of shape (n,) in the units of the topic, NaN where a
    message does not carry the name or the field.
    """

    time: Array
    stamp_ns: NDArray[np.int64]
    position: dict[str, Array]
    velocity: dict[str, Array]
    effort: dict[str, Array]


def scalars(messages: Iterable[tuple[str, int, int, bytes]], start_ns: int) -> tuple[Array, Array]:
    """Return time (s since `start_ns`) and value of Float64 messages; raises `LogError` for other bytes."""
    times, values = _Times(), array("d")
    for topic, log_ns, _, data in messages:
        try:
            values.append(_FLOAT64[data[1] & 1].unpack_from(data)[0])
        except (struct.error, IndexError) as cause:
            raise LogError(f"A message on {topic} has {len(data)} bytes; a Float64 has 12.") from cause
        times.append(log_ns)
    return times.seconds(start_ns), np.array(values)


def joint(messages: Iterable[tuple[str, int, int, Any]], start_ns: int) -> JointSeries:
    """Gather decoded JointState messages by joint name."""
    times, stamps = _Times(), _Times()
    columns: dict[str, dict[str, _Column]] = {"position": {}, "velocity": {}, "effort": {}}
    for row, (_, log_ns, _, message) in enumerate(messages):
        times.append(log_ns)
        stamps.append(message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec)
        for which, column in columns.items():
            # An empty field is allowed beside named joints; zip then leaves the row as NaN.
            for name, value in zip(message.name, getattr(message, which).tolist(), strict=False):
                column.setdefault(name, _Column()).append(row, value)
    count = len(stamps.nanoseconds)
    arrays = {which: {name: cells.filled(count) for name, cells in column.items()} for which, column in columns.items()}
    return JointSeries(times.seconds(start_ns), np.array(stamps.nanoseconds), **arrays)


def statuses(messages: Iterable[tuple[str, int, int, Any]], start_ns: int) -> list[Status]:
    """Return decoded DiagnosticStatus messages as tuples; a repeated key keeps its last value."""
    return [
        Status(
            (log_ns - start_ns) * 1e-9,
            int(message.level),
            message.message,
            {value.key: value.value for value in message.values},
        )
        for _, log_ns, _, message in messages
    ]


class _Times:
    """Times as they come, 8 bytes each: lists of Python's numbers take five times as much."""

    def __init__(self) -> None:
        self.nanoseconds = array("q")

    def append(self, nanoseconds: int) -> None:
        try:
            self.nanoseconds.append(nanoseconds)
        except OverflowError as cause:
            raise LogError(f"A time of {nanoseconds} ns is beyond 2^63-1; the log is damaged.") from cause

    def seconds(self, start_ns: int) -> Array:
        # The difference is taken in integers: a float64 of epoch nanoseconds is good to 256 ns only.
        try:
            return (np.array(self.nanoseconds) - start_ns).astype(np.float64) * 1e-9
        except OverflowError as cause:
            raise LogError(f"The log's first time of {start_ns} ns is beyond 2^63-1; the log is damaged.") from cause


@dataclass
class _Column:
    """The rows in which a name came, and its values."""

    rows: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))

    def append(self, row: int, value: float) -> None:
        self.rows.append(row)
        self.values.append(value)

    def filled(self, count: int) -> Array:
        column = np.full(count, np.nan)
        column[np.array(self.rows)] = self.values
        return column
