"""Find the field of a message that holds a wrong value, and say so in a sentence."""

from __future__ import annotations

import struct
from typing import Any

from seat_gear_dynamics.runtime.cdr.blocks import CODES
from seat_gear_dynamics.runtime.interfaces import Kind


def find_fault(message: Any, path: str = "") -> str:
    """Return a sentence about the first field of a message that holds a wrong value, or "" if none does."""
    if not hasattr(message, "FIELDS"):
        return ""
    for field, kind in message.FIELDS.items():
        where = f"{path}.{field}" if path else field
        if not hasattr(message, field):
            return f"{message.FULL_NAME}.{where} was deleted: assign a {kind.spelled()}."
        found = _field_fault(getattr(message, field), kind, where)
        if found:
            return found if path else f"{message.FULL_NAME}: {found}"
    return ""


def _field_fault(value: Any, kind: Kind, where: str) -> str:
    if kind.shape == "one":
        return _value_fault(value, kind, where)
    if isinstance(value, str) or not hasattr(value, "__len__"):
        return f"{where} is {value!r}, expected {kind.spelled()}: give a list or an array."
    if kind.shape == "array" and len(value) != kind.length:
        return f"{where} has {len(value)} elements, expected exactly {kind.length}."
    if kind.shape == "sequence" and kind.length and len(value) > kind.length:
        return f"{where} has {len(value)} elements, expected at most {kind.length}."
    if isinstance(value, (bytes, bytearray)) and kind.base in ("uint8", "char", "byte"):
        return ""
    items = value.tolist() if hasattr(value, "tolist") else value
    single = kind._replace(shape="one")
    for index, item in enumerate(items):
        if kind.base in ("float32", "float64") and isinstance(item, int):
            continue
        found = _value_fault(item, single, f"{where}[{index}]")
        if found:
            return found
    if hasattr(value, "ndim") and value.ndim != 1:
        return f"{where} has {value.ndim} dimensions, expected 1: give it flattened."
    return ""


_PYTHON_TYPES: dict[str, type] = {
    "bool": bool,
    "byte": bytes,
    "string": str,
    "float32": float,
    "float64": float,
}


def _value_fault(value: Any, kind: Kind, where: str) -> str:
    if not kind.primitive:
        if getattr(value, "FULL_NAME", "") == kind.base:
            return find_fault(value, where)
        return f"{where} is {value!r}, expected a {kind.base}."
    expected: type = _PYTHON_TYPES.get(kind.base, int)
    if not isinstance(value, expected):
        remedy = f": convert it with {expected.__name__}()" if expected in (int, float, str, bool) else ""
        return f"{where} is {value!r} of type {type(value).__name__}, expected {kind.spelled()}{remedy}."
    size = len(value) if isinstance(value, (bytes, str)) else 0
    if kind.base == "byte" and size != 1:
        return f"{where} is {value!r}, expected bytes of length 1."
    if kind.string_bound and size > kind.string_bound:
        return f"{where} has {size} characters, expected at most {kind.string_bound}."
    if kind.base not in ("bool", "byte", "string"):
        try:
            struct.pack("<" + CODES[kind.base], value)
        except (struct.error, OverflowError):
            return f"{where} is {value!r}, which is outside the range of {kind.base}."
    return ""
