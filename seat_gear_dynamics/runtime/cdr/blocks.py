"""Move numbers between Python sequences and little-endian bytes, for the generated CDR functions."""

from __future__ import annotations

import struct
from array import array
from typing import Any

HEADER = b"\x00\x01\x00\x00"
"""Encapsulation header: little-endian CDR, no options."""


CODES = {
    "bool": "?",
    "byte": "c",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
"""`struct` and `array` codes of the primitives."""


SIZES = {base: struct.calcsize("<" + code) for base, code in CODES.items()}


def pack_block(code: str, values: Any) -> bytes:
    """Return the numbers of a list, tuple, array or numpy array as little-endian bytes.

    Raises:
        TypeError, OverflowError: an element is not a number of that kind, or is out of its range.
    """
    if type(values) is array and values.typecode == code:
        return values.tobytes()
    if isinstance(values, (bytes, bytearray)) and code == "B":
        return bytes(values)
    dtype = getattr(values, "dtype", None)
    if dtype is not None and dtype.kind in "biuf":
        if values.ndim != 1:
            raise TypeError("an array of one dimension is expected")
        if (dtype.kind == "f") != (code in "fd"):
            raise TypeError("integers and floats do not mix")
        return bytes(array(code, values.tolist()).tobytes() if dtype.char != code else values.tobytes())
    if isinstance(values, str):
        raise TypeError("text is not a sequence of numbers")
    return array(code, values).tobytes()


def pack_flags(values: Any) -> bytes:
    """Return booleans as one byte each.

    Raises:
        TypeError: an element is not a bool.
    """
    items = values.tolist() if hasattr(values, "tolist") else values
    if not all(item is True or item is False for item in items):
        raise TypeError("bool elements are expected")
    return bytes(items)


def pack_octets(values: Any) -> bytes:
    """Return a `byte` sequence, given as bytes or as a list of bytes of length 1.

    Raises:
        TypeError: an element is not one byte.
    """
    if isinstance(values, (bytes, bytearray)):
        return bytes(values)
    if not all(isinstance(item, bytes) and len(item) == 1 for item in values):
        raise TypeError("elements of type bytes and length 1 are expected")
    return b"".join(values)


def within(values: Any, shape: str, length: int) -> int:
    """Return the element count, checked against an array's length or a sequence's bound.

    Raises:
        ValueError: the count does not fit.
    """
    count = len(values)
    if (shape == "array" and count != length) or (shape == "sequence" and length and count > length):
        raise ValueError("wrong number of elements")
    return count


def unpack_block(code: str, data: bytes, position: int, end: int) -> array[Any]:
    """Return little-endian numbers as an `array`.

    Raises:
        ValueError: the bytes end too early.
    """
    if end > len(data):
        raise ValueError("the bytes end too early")
    values: array[Any] = array(code)
    values.frombytes(data[position:end])
    return values


def need_float(value: Any) -> float:
    """Return a float given as a subclass of float (numpy.float64 is one).

    Raises:
        TypeError: the value is not a float. ROS refuses an int here too.
    """
    if isinstance(value, float):
        return value
    raise TypeError("float expected")


def fixed(values: array[Any]) -> Any:
    """Return a fixed-size number array as rclpy gives it: a numpy array."""
    import numpy as np

    return np.array(values)
