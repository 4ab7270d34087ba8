"""Calls into Cyclone DDS's C library that its Python package does not make."""

from __future__ import annotations

import ctypes as ct
from functools import cache
from typing import Any

from seat_gear_dynamics.runtime.exceptions import RCLError


def path() -> str:
    """Return the file of Cyclone's C library that this process uses."""
    from cyclonedds.internal import DDS

    return str(DDS._dll_handle._name)


@cache
def library() -> ct.CDLL:
    """Return Cyclone's C library with the signatures of the calls made here.

    It is opened a second time, so that these signatures do not touch those the Python package sets.
    """
    library = ct.CDLL(path())
    entity, status = ct.c_int32, ct.c_int32
    signatures: dict[str, tuple[Any, ...]] = {
        "dds_create_waitset": (entity, entity),
        "dds_waitset_attach": (status, entity, entity, ct.c_void_p),
        "dds_waitset_detach": (status, entity, entity),
        "dds_waitset_wait": (status, entity, ct.POINTER(ct.c_void_p), ct.c_size_t, ct.c_int64),
        "dds_create_readcondition": (entity, entity, ct.c_uint32),
        "dds_create_guardcondition": (entity, entity),
        "dds_set_guardcondition": (status, entity, ct.c_bool),
        "dds_assert_liveliness": (status, entity),
        "dds_get_matched_subscriptions": (status, entity, ct.c_void_p, ct.c_size_t),
        "dds_get_matched_publications": (status, entity, ct.c_void_p, ct.c_size_t),
        "dds_get_sample_lost_status": (status, entity, ct.c_void_p),
        "dds_set_topic_filter_extended": (status, entity, ct.c_void_p),
        "dds_take_with_collector": (
            *(status, entity, ct.c_uint32, ct.c_uint64, ct.c_uint32),
            *(ct.c_void_p, ct.c_void_p),
        ),
    }
    for name, (result, *arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


def checked(code: int, what: str) -> int:
    """Return a result of Cyclone; RCLError with `what` and Cyclone's reason where it is negative."""
    if code < 0:
        from cyclonedds.core import DDSException

        raise RCLError(f"{what} failed: {DDSException(code)}")
    return code


def delete(entity: Any) -> None:
    """Delete a DDS entity now; its Python object then has nothing left to delete."""
    if entity._entities.pop(entity._ref, None) is not None:
        entity._delete(entity._ref)
