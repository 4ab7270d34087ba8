"""Compiled functions that Cyclone DDS calls for each sample: one counts and stamps arrivals, one packs what is taken.

Both run without Python's lock, under the lock of the reader's queue, so that what they share needs no other. They know
Cyclone DDS 11's `dds_sample_info_t` and see nothing of a sample but its bytes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numba import cfunc, extending
from numba import types as numba_types
from numba.np.numpy_support import carray

from seat_gear_dynamics.runtime.wire.library import path

types: Any = numba_types  # its annotations do not know that types are called

ARRIVED, NEXT, SEEN, LOST, DEPTH, SECONDS, NANOSECONDS, STAMPS = range(8)
"""Places in a reader's account (int64): samples that arrived, the first that was not taken, those that had arrived at
the last take, those overwritten before they were taken, depth of the queue, a timespec, and then `depth` arrival times
on the steady clock, ns."""

ACCOUNT, READER, DATA, DATA_SIZE, DATA_USED, TABLE, TABLE_SIZE, TABLE_USED, TOO_LARGE, CONTROL = range(10)
"""Places in a sink's control block (int64): addresses of the account, number of the reader, address, size and used part
of the data, the same of the table, bytes of a sample that found no room."""

SLOT, OFFSET, SIZE, PUBLISHED, STAMP, COLUMNS = range(6)
"""Columns of a sink's table: number of the reader, place and bytes of the data, source time, ns, arrival, ns steady."""

NO_ROOM = -5  # DDS_RETCODE_OUT_OF_RESOURCES: ends a take, the sample stays in the queue

_STEADY = 1  # CLOCK_MONOTONIC
_VALID, _SOURCE = 12, 2  # dds_sample_info_t: byte that says whether there is data, place of the source time in int64

binding.load_library_permanently(path())
_clock = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.uint64))
_size = types.ExternalFunction("ddsi_serdata_size", types.uint32(types.voidptr))
_serialize = types.ExternalFunction(
    "ddsi_serdata_to_ser", types.void(types.voidptr, types.uint64, types.uint64, types.uint64)
)


def _converted(argument: Any, result: Any, instruction: str) -> Any:
    """Return the compiled conversion between a pointer and its address."""

    def convert(context: Any, value: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return getattr(builder, instruction)(arguments[0], context.get_value_type(result))

        return result(argument), generate

    return extending.intrinsic(convert)


_pointer = _converted(types.int64, types.voidptr, "inttoptr")
_address = _converted(types.voidptr, types.int64, "ptrtoint")


@cfunc(types.int32(types.voidptr, types.voidptr), cache=True)  # a C bool is the low byte of it
def arrive(info: Any, account_address: Any) -> int:
    """Count a sample of a reader's account and note when it came; a topic filter that lets everything pass."""
    head = carray(account_address, (STAMPS,), np.int64)
    _clock(_STEADY, _address(account_address) + 8 * SECONDS)
    stamps = carray(account_address, (STAMPS + head[DEPTH],), np.int64)
    stamps[STAMPS + head[ARRIVED] % head[DEPTH]] = head[SECONDS] * 1_000_000_000 + head[NANOSECONDS]
    head[ARRIVED] += 1
    return 1


@cfunc(types.int32(types.voidptr, types.voidptr, types.voidptr, types.voidptr), cache=True)
def collect(sink: Any, info: Any, sample_type: Any, sample: Any) -> int:
    """Append a sample to a sink; the queue of a keep-last reader holds the last `depth` of what arrived."""
    control = carray(sink, (CONTROL,), np.int64)
    if carray(info, (_VALID + 1,), np.uint8)[_VALID] == 0:
        return 0  # a writer left
    size = np.int64(_size(sample))
    if control[TABLE_USED] >= control[TABLE_SIZE] or control[DATA_USED] + size > control[DATA_SIZE]:
        control[TOO_LARGE] = size
        return NO_ROOM
    head = carray(_pointer(control[ACCOUNT]), (STAMPS,), np.int64)
    oldest = max(head[NEXT], head[ARRIVED] - head[DEPTH])
    head[LOST] += oldest - head[NEXT]
    head[NEXT] = oldest + 1
    head[SEEN] = head[ARRIVED]
    stamps = carray(_pointer(control[ACCOUNT]), (STAMPS + head[DEPTH],), np.int64)
    table = carray(_pointer(control[TABLE]), (control[TABLE_SIZE], COLUMNS), np.int64)
    row = control[TABLE_USED]
    table[row, SLOT] = control[READER]
    table[row, OFFSET] = control[DATA_USED]
    table[row, SIZE] = size
    table[row, PUBLISHED] = carray(info, (_SOURCE + 1,), np.int64)[_SOURCE]
    table[row, STAMP] = stamps[STAMPS + oldest % head[DEPTH]]
    _serialize(sample, 0, size, control[DATA] + control[DATA_USED])
    control[DATA_USED] += size
    control[TABLE_USED] += 1
    return 0
