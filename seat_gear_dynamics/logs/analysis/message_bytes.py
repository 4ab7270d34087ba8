"""Numbers out of CDR bytes without building message objects: what a log of hours needs to be read in seconds."""

from __future__ import annotations

import struct
from typing import NamedTuple

from seat_gear_dynamics.logs.errors import LogError

_FLOAT64 = {0: struct.Struct(">4xd"), 1: struct.Struct("<4xd")}  # by the CDR header's byte order


class Joint(NamedTuple):
    """A JointState: stamp in ns, names, and what it carries of each, in the topic's units (empty: not carried)."""

    stamp_ns: int
    names: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]


class _Layout(NamedTuple):
    """Where the numbers of messages with the same names lie."""

    begin: int
    """First byte after the stamp."""
    fixed: bytes
    """Bytes from there to the number of positions, the same in every message with these names."""
    names: tuple[str, ...]
    counts: tuple[tuple[int, bytes], ...]
    """(offset, bytes) of the three lengths."""
    stamp: struct.Struct
    numbers: tuple[tuple[int, struct.Struct], ...]


class JointDecoder:
    """Decodes JointState messages; remembers the layout of the last one, since a publisher repeats its names."""

    def __init__(self) -> None:
        self._layouts: dict[int, _Layout] = {}

    def decode(self, data: bytes) -> Joint:
        """Return the message in `data` (CDR with its 4-byte header); raises `LogError` for other bytes."""
        try:
            layout = self._layouts.get(len(data))
            if layout is None or not _fits(data, layout):
                layout = self._layouts[len(data)] = _layout(data)
            seconds, nanoseconds = layout.stamp.unpack_from(data, 4)
            position, velocity, effort = (numbers.unpack_from(data, at) for at, numbers in layout.numbers)
        except (struct.error, IndexError, UnicodeDecodeError) as cause:
            raise LogError(
                f"{len(data)} bytes do not hold a JointState ({cause}); the message is damaged or of another type."
            ) from cause
        return Joint(seconds * 1_000_000_000 + nanoseconds, layout.names, position, velocity, effort)


def float64(data: bytes) -> float:
    """Return the number of a std_msgs/Float64 in `data` (CDR); raises `LogError` for other bytes."""
    try:
        value: float = _FLOAT64[data[1] & 1].unpack_from(data)[0]
    except (struct.error, IndexError) as cause:
        raise LogError(f"A message has {len(data)} bytes; a Float64 has 12.") from cause
    return value


def _fits(data: bytes, layout: _Layout) -> bool:
    begin, end = layout.begin, layout.begin + len(layout.fixed)
    if data[begin:end] != layout.fixed or data[1] & 1 != (layout.stamp.format[0] == "<"):
        return False
    return all(data[at : at + 4] == count for at, count in layout.counts)


def _layout(data: bytes) -> _Layout:
    order = "<" if data[1] & 1 else ">"
    number = struct.Struct(order + "I")

    def count_at(position: int) -> int:
        found: int = number.unpack_from(data, position)[0]
        if found > len(data):
            raise IndexError(f"a length of {found} at byte {position}")
        return found

    position = _aligned(16 + count_at(12), 4)  # behind the stamp's frame
    names = []
    count, position = count_at(position), position + 4
    for _ in range(count):
        position = _aligned(position, 4)
        length = count_at(position)
        names.append(data[position + 4 : position + 4 + max(length - 1, 0)].decode())
        position += 4 + length
    end = position = _aligned(position, 4)
    counts, numbers = [], []
    for _ in range(3):
        position = _aligned(position, 4)
        count = count_at(position)
        counts.append((position, data[position : position + 4]))
        position = _aligned(position + 4, 8) if count else position + 4
        numbers.append((position, struct.Struct(f"{order}{count}d")))
        position += 8 * count
    return _Layout(12, data[12:end], tuple(names), tuple(counts), struct.Struct(order + "iI"), tuple(numbers))


def _aligned(position: int, size: int) -> int:
    """Return the next position aligned to `size`; CDR counts from behind its 4-byte header."""
    return position + (4 - position) % size
