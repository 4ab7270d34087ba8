"""Readers whose samples are counted and stamped as they arrive, and taken many at a time into one buffer."""

from __future__ import annotations

import ctypes as ct
import time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.runtime.wire import collect
from seat_gear_dynamics.runtime.wire.entity import ReaderEndpoint
from seat_gear_dynamics.runtime.wire.library import checked, delete, library

Integers = NDArray[np.int64]

_ROWS = 16_384
_BYTES = 4_000_000
_SAMPLE_INFO_FILTER = 3  # DDS_TOPIC_FILTER_SAMPLEINFO_ARG


class _Filter(ct.Structure):
    _fields_ = (("mode", ct.c_int), ("function", ct.c_void_p), ("argument", ct.c_void_p))


class _LostStatus(ct.Structure):
    _fields_ = (("total", ct.c_uint32), ("change", ct.c_int32))


class Taken(NamedTuple):
    """Samples in order of arrival: reader's number, place and bytes in `data`, and times, ns since 1970.

    `arrived_ns` is when the receiving thread had the sample, `published_ns` the source's stamp, 0 without one.
    """

    slot: Integers
    offset: Integers
    size: Integers
    published_ns: Integers
    arrived_ns: Integers
    data: NDArray[np.uint8]


class Sink:
    """The buffers that samples are taken into, `rows` of them and `size` bytes at most; they grow for a larger one."""

    def __init__(self, rows: int = _ROWS, size: int = _BYTES) -> None:
        self._table = np.empty((rows, collect.COLUMNS), np.int64)
        self._data = np.empty(size, np.uint8)
        self.control = np.zeros(collect.CONTROL, np.int64)
        self.address = self.control.ctypes.data
        self._point()

    def _point(self) -> None:
        control = self.control
        control[[collect.DATA, collect.DATA_SIZE]] = self._data.ctypes.data, len(self._data)
        control[[collect.TABLE, collect.TABLE_SIZE]] = self._table.ctypes.data, len(self._table)

    @property
    def full(self) -> bool:
        """Whether a sample found no room."""
        return bool(self.control[collect.TOO_LARGE])

    def empty(self) -> Taken | None:
        """Return what was taken since the last call, None if nothing was, and make room."""
        control = self.control
        rows, used, refused = (int(control[i]) for i in (collect.TABLE_USED, collect.DATA_USED, collect.TOO_LARGE))
        control[[collect.TABLE_USED, collect.DATA_USED, collect.TOO_LARGE]] = 0
        taken = self._taken(self._table[:rows], used) if rows else None
        if refused > len(self._data):
            self._data = np.empty(2 * refused, np.uint8)
            self._point()
        return taken

    def _taken(self, table: Integers, used: int) -> Taken:
        # Each reader's samples lie together in their order; merged by the steady clock, which no step disturbs.
        columns = np.ascontiguousarray(table[np.argsort(table[:, collect.STAMP], kind="stable")].T)
        columns[collect.STAMP] += time.time_ns() - time.monotonic_ns()
        slot, offset, size, published, arrived = columns
        return Taken(slot, offset, size, published, arrived, self._data[:used].copy())


class CountedReader(ReaderEndpoint):
    """A keep-last DDS reader of serialized samples; `number` stands for it in what it puts into a sink.

    Raises `RCLError` when DDS refuses. Only for types without keys, which all of ROS 2's common interfaces are. Its
    account has to outlive the DDS entity, so that whoever makes a reader closes it, or keeps it until its participant
    is gone.
    """

    def __init__(self, topic: Any, make_reader: Any, depth: int, number: int) -> None:
        self._account = np.zeros(collect.STAMPS + depth, np.int64)
        self._account[collect.DEPTH] = depth
        self._depth, self._number = depth, number
        self._topic = topic
        function = ct.c_void_p(collect.arrive.address)
        rule = _Filter(_SAMPLE_INFO_FILTER, function, self._account.ctypes.data)
        checked(library().dds_set_topic_filter_extended(topic._ref, ct.byref(rule)), "counting arrivals")
        super().__init__(make_reader(topic))
        self._take = library().dds_take_with_collector
        self._collector = collect.collect.address

    def take(self, sink: Sink) -> bool:
        """Move what waits into a sink; return whether nothing is left, so far as the sink has room."""
        control, account = sink.control, self._account
        control[collect.ACCOUNT], control[collect.READER] = account.ctypes.data, self._number
        most = self._depth + 1  # one more than can wait, for the notice that a writer left
        count = self._take(self._ref, most, 0, _ANY_STATE, self._collector, sink.address)
        if sink.full:
            return False
        checked(count, "taking samples")
        missing = int(account[collect.SEEN] - account[collect.NEXT])
        if count and missing > 0:  # what outlived its publisher's lifespan in the queue was never taken
            account[collect.LOST] += missing
            account[collect.NEXT] = account[collect.SEEN]
        return True

    @property
    def lost(self) -> int:
        """Samples that arrived and were overwritten before they were taken, and those DDS itself reports as lost."""
        status = _LostStatus()
        checked(library().dds_get_sample_lost_status(self._ref, ct.byref(status)), "asking for lost samples")
        waiting = int(self._account[collect.ARRIVED] - self._account[collect.NEXT])
        return int(self._account[collect.LOST]) + max(0, waiting - self._depth) + int(status.total)

    def close(self) -> None:
        """Delete the reader, and with it the topic that counts for it."""
        super().close()
        delete(self._topic)


_ANY_STATE = 0x7F
