"""When a log syncs and when it starts a new file."""

from __future__ import annotations

from dataclasses import dataclass, fields

from seat_gear_dynamics.logs.errors import LogError

NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class Limits:
    """Bytes of a chunk, seconds between syncs, bytes and seconds of a file; None is no limit."""

    chunk_size: int
    sync_interval_s: float
    max_size_bytes: int | None
    max_duration_s: float | None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not value > 0:
                raise LogError(f"{field.name} is {value}; expected a number above 0 (or None for no limit).")

    def sync_due(self, last_ns: int, now_ns: int) -> bool:
        """Whether a sync is due; a clock that jumps back far enough counts too."""
        return abs(now_ns - last_ns) >= self.sync_interval_s * NANOSECONDS

    def file_full(self, size: int, start_ns: int | None, now_ns: int) -> bool:
        """Whether a file of `size` bytes that began at `start_ns` should take no message of `now_ns`."""
        if self.max_size_bytes is not None and size >= self.max_size_bytes:
            return True
        if self.max_duration_s is None or start_ns is None:
            return False
        return now_ns - start_ns >= self.max_duration_s * NANOSECONDS
