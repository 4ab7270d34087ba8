"""When a log syncs, when it starts a new file, and which of its files it lets go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from seat_gear_dynamics.logs.batch import Integers
from seat_gear_dynamics.logs.errors import LogError

NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class Limits:
    """Bytes of a chunk, seconds between syncs, bytes and seconds of a file, files and bytes kept; None is no limit."""

    chunk_size: int
    sync_interval_s: float
    max_size_bytes: int | None
    max_duration_s: float | None
    keep_files: int | None = None
    keep_bytes: int | None = None

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

    def run(self, log_ns: Integers, last_ns: int | None, size: int, start_ns: int | None) -> int:
        """Return how many messages can be written before the limits have to be asked again; at least one.

        `log_ns` are the messages' log times, `last_ns` that of the last sync (None before one), `size` and `start_ns`
        those of the present file. A sync is due behind the last of the run at the earliest, a new file before its
        successor; the size is one that only a closed chunk changes.
        """
        if self.file_full(size, None, 0):
            return 1  # a new file that its declarations alone fill
        last = int(log_ns[0]) if last_ns is None else last_ns
        due = np.flatnonzero(np.abs(log_ns - last) >= self.sync_interval_s * NANOSECONDS)
        run = int(due[0]) + 1 if len(due) else len(log_ns)
        if self.max_duration_s is not None:
            first = np.minimum.accumulate(log_ns)
            if start_ns is not None:
                first = np.minimum(first, start_ns)
            old = np.flatnonzero(log_ns[1:] - first[:-1] >= self.max_duration_s * NANOSECONDS)
            run = min(run, int(old[0]) + 1) if len(old) else run
        return run

    def surplus(self, sizes: Sequence[int]) -> int:
        """Return how many of a bag's files to let go, the oldest first, before another one is begun.

        `sizes` are the bytes of the finished files, the oldest first. The last is always kept, so that the moment of a
        split leaves no hole; together with the file being written a bag outgrows `keep_bytes` by up to that file.
        """
        gone = 0
        while gone < len(sizes) - 1 and self._too_many(sizes[gone:]):
            gone += 1
        return gone

    def _too_many(self, sizes: Sequence[int]) -> bool:
        if self.keep_files is not None and len(sizes) >= self.keep_files:
            return True
        return self.keep_bytes is not None and sum(sizes) > self.keep_bytes
