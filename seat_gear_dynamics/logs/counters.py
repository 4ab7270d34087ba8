"""What became of each message: received, written, dropped; and what is latched for late subscribers."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from seat_gear_dynamics.logs.metadata import TopicRecord


class Counters(NamedTuple):
    """Messages of one topic: handed to the writer, durable on disk, lost or refused after a failure.

    `received - written - dropped` messages wait for the next sync. Repetitions at a split are not counted.
    """

    received: int
    written: int
    dropped: int

    def __str__(self) -> str:
        return f"received {self.received}, written {self.written}, dropped {self.dropped}"


class Account:
    """What the writer remembers of one topic between messages."""

    def __init__(self, record: TopicRecord) -> None:
        self.record = record
        self.received = 0
        self._accepted = 0
        self._written = 0
        self._dropped = 0
        depths = [max(1, qos.depth) for qos in record.qos if qos.durability == "transient_local"]
        # (data, publish time, sequence) of the messages that a late subscriber would be sent.
        self.latched: deque[tuple[bytes, int, int]] | None = deque(maxlen=max(depths)) if depths else None

    @property
    def counters(self) -> Counters:
        """The counts for people."""
        return Counters(self.received, self._written, self._dropped)

    def accept(self, count: int) -> None:
        """Note messages that the file has taken, though not yet to the disk; each goes through `latch` too."""
        self._accepted += count

    def latch(self, data: bytes, publish_ns: int, sequence: int) -> None:
        """Keep a message for late subscribers, if the topic is one that keeps any."""
        if self.latched is not None:
            self.latched.append((data, publish_ns, sequence))

    def settle(self) -> None:
        """Note that everything accepted is durable."""
        self._written = self._accepted

    def drop_pending(self) -> int:
        """Note that nothing more will become durable; return how many messages that loses."""
        lost = self.received - self._written - self._dropped
        self._dropped += lost
        return lost
