"""Messages that come many at a time: their bytes in one buffer, their times in arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.int64]


class Kept(NamedTuple):
    """One message: absolute topic, CDR bytes, log and publish time, ns."""

    topic: str
    data: bytes
    log_ns: int
    publish_ns: int


@dataclass(frozen=True)
class Batch:
    """Messages in the order in which they came; all arrays but `data` have one entry for each, shape (n,).

    `topic` counts into `names`, the absolute topic names; a message is `data[offset : offset + size]`, CDR with its
    4-byte header. Times are ns since the epoch of the caller's clock. The arrays are not copied: leave them alone.
    """

    names: tuple[str, ...]
    topic: Integers
    offset: Integers
    size: Integers
    log_ns: Integers
    publish_ns: Integers
    data: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.topic)

    def __iter__(self) -> Iterator[Kept]:
        return map(self.message, range(len(self)))

    def part(self, chosen: slice | NDArray[np.bool_] | Integers) -> Batch:
        """Return some of the messages; the buffer is shared."""
        return Batch(
            self.names,
            self.topic[chosen],
            self.offset[chosen],
            self.size[chosen],
            self.log_ns[chosen],
            self.publish_ns[chosen],
            self.data,
        )

    def counts(self) -> dict[str, int]:
        """Return the number of messages of each topic that has any."""
        found = np.bincount(self.topic, minlength=len(self.names))
        return {name: int(count) for name, count in zip(self.names, found, strict=True) if count}

    def of(self, names: frozenset[str]) -> Iterator[Kept]:
        """Yield the messages of these topics."""
        wanted = np.array([name in names for name in self.names], dtype=bool)
        for place in np.flatnonzero(wanted[self.topic]) if wanted.any() else ():
            yield self.message(int(place))

    def message(self, place: int) -> Kept:
        """Return one message with a copy of its bytes."""
        begin, size = int(self.offset[place]), int(self.size[place])
        data = self.data[begin : begin + size].tobytes()
        return Kept(self.names[self.topic[place]], data, int(self.log_ns[place]), int(self.publish_ns[place]))
