"""The chunk in progress: its records packed into one buffer, and where each message of it stands."""

from __future__ import annotations

import struct

import numpy as np
from mcap.opcode import Opcode
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.logs.batch import Batch, Integers

Bytes = NDArray[np.uint8]

_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time; the data follows
_FIELDS = 22  # bytes of a message's body before its data
_HEAD = 9 + _FIELDS
_INDEX = struct.Struct("<BQHI")  # opcode, length, channel, bytes of entries; the entries follow
_PLACE = struct.Struct("<QQQ")  # channel, log time, offset: what the index is made from
_SPARE = 65_536


class ChunkBody:
    """Collects records, one at a time or many; `size` is bytes so far, `count` messages so far."""

    def __init__(self) -> None:
        self._bytes: Bytes = np.empty(_SPARE, np.uint8)
        self._places: Integers = np.empty((1024, 3), np.int64)
        self.size = self.count = 0
        self._views()

    def _views(self) -> None:
        self._room, self._most = len(self._bytes), len(self._places)
        self._view = self._bytes.data
        self._place_view = self._places.data.cast("B")

    def _reserve(self, size: int, count: int) -> None:
        """Make room for so many more bytes and messages."""
        if self.size + size > len(self._bytes):
            self._bytes = np.append(self._bytes[: self.size], np.empty(self.size + size + _SPARE, np.uint8))
            self._views()
        if self.count + count > len(self._places):
            more = np.empty((self.count + count + 1024, 3), np.int64)
            self._places = np.concatenate((self._places[: self.count], more))
            self._views()

    def clear(self) -> None:
        """Begin an empty chunk in the same memory."""
        self.size = self.count = 0

    def append(self, records: bytes) -> None:
        """Append records that are no messages."""
        self._reserve(len(records), 0)
        self._view[self.size : self.size + len(records)] = records
        self.size += len(records)

    def add(self, channel: int, log_ns: int, data: bytes, publish_ns: int, sequence: int) -> None:
        """Append a message."""
        length, begin, place = len(data), self.size, self.count
        end = begin + _HEAD + length
        if end > self._room or place >= self._most:
            self._reserve(_HEAD + length, 1)
        self.size, self.count = end, place + 1
        _PLACE.pack_into(self._place_view, place * _PLACE.size, channel, log_ns, begin)
        _MESSAGE.pack_into(self._view, begin, 5, _FIELDS + length, channel, sequence, log_ns, publish_ns)
        self._view[begin + _HEAD : end] = data

    def add_batch(self, batch: Batch, begin: int, end: int, full: int, channels: Integers, sequences: Integers) -> int:
        """Append messages from `begin` on, up to `end` or until `size` exceeds `full`; return the first not appended.

        `channels` and `sequences` have an entry for each of the batch's names; sequences go on counting, in place.
        """
        # The bytes that lie before the chunk is full, and the message that fills it.
        self._reserve(max(0, full - self.size) + 2 * _HEAD + int(batch.size[begin:end].max(initial=0)), end - begin)
        columns = (batch.topic, batch.offset, batch.size, batch.log_ns, batch.publish_ns, batch.data)
        state = (self._bytes, self.size, self._places, self.count)
        place, self.size, self.count = _pack(begin, end, full, *columns, channels, sequences, *state)
        return int(place)

    def content(self) -> bytes:
        """Return all records."""
        return self._view[: self.size].tobytes()

    def span(self) -> tuple[int, int]:
        """Return the first and the last log time, ns; there has to be a message."""
        times = self._places[: self.count, 1]
        return int(times.min()), int(times.max())

    def indexes(self, begin: int) -> tuple[dict[int, int], dict[int, int], bytes]:
        """Return each channel's number of messages, where its index will stand in a file, and the index records.

        The next byte of that file is `begin`.
        """
        places = self._places[: self.count]
        order = np.argsort(places[:, 0].astype(np.uint16), kind="stable")
        numbers, firsts = np.unique(places[order, 0], return_index=True)
        counts: dict[int, int] = {}
        offsets: dict[int, int] = {}
        records = bytearray()
        for number, entries in zip(numbers.tolist(), np.split(places[order, 1:], firsts[1:]), strict=True):
            counts[number], offsets[number] = len(entries), begin + len(records)
            data = entries.astype("<i8").tobytes()
            records += _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(data), number, len(data)) + data
        return counts, offsets, bytes(records)


def compile_packing() -> None:
    """Compile what packs a batch: seconds where numba's cache is cold, so that they pass before messages come."""
    none, nothing = np.empty(0, np.int64), np.empty(0, np.uint8)
    ChunkBody().add_batch(Batch((), none, none, none, none, none, nothing), 0, 0, 0, none, none)


@njit(cache=True, nogil=True)
def _put(body: Bytes, begin: int, value: int, count: int) -> int:
    """Write a number in `count` bytes, the smallest first; return the place behind it."""
    for k in range(count):
        body[begin + k] = (value >> (8 * k)) & 0xFF
    return begin + count


@njit(cache=True, nogil=True)
def _pack(
    begin: int,
    end: int,
    full: int,
    topic: Integers,
    offset: Integers,
    size: Integers,
    log_ns: Integers,
    publish_ns: Integers,
    data: Bytes,
    channels: Integers,
    sequences: Integers,
    body: Bytes,
    used: int,
    places: Integers,
    count: int,
) -> tuple[int, int, int]:
    """Append message records; return the first place not appended, bytes used and messages."""
    row = begin
    while row < end and used <= full:
        name, length, first = topic[row], size[row], offset[row]
        places[count, 0], places[count, 1], places[count, 2] = channels[name], log_ns[row], used
        count += 1
        used = _put(body, used, 5, 1)
        used = _put(body, used, _FIELDS + length, 8)
        used = _put(body, used, channels[name], 2)
        used = _put(body, used, sequences[name] & 0xFFFFFFFF, 4)
        used = _put(body, used, log_ns[row], 8)
        used = _put(body, used, publish_ns[row], 8)
        sequences[name] += 1
        for k in range(length):
            body[used + k] = data[first + k]
        used += length
        row += 1
    return row, used, count
