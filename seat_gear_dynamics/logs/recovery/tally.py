"""Messages counted and summed per topic, whatever their order: equal tallies mean equal messages."""

from __future__ import annotations

import struct
import zlib

_TIMES = struct.Struct("<QQ")


class Tally:
    """Per topic the number of messages and the sum of a 32-bit checksum over times and bytes.

    Two tallies over different messages agree by chance once in 2^32 cases a topic; this guards against faults of the
    software, not against intent.
    """

    def __init__(self) -> None:
        self.topics: dict[str, tuple[int, int]] = {}

    def add(self, topic: str, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Enter one message; times in ns."""
        count, total = self.topics.get(topic, (0, 0))
        self.topics[topic] = count + 1, total + zlib.crc32(data, zlib.crc32(_TIMES.pack(log_ns, publish_ns)))
