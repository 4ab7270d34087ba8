"""Numbers out of CDR bytes, held against rosbags' own codec."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from seat_gear_dynamics.logs.analysis.message_bytes import JointDecoder, float64
from seat_gear_dynamics.logs.errors import LogError

STORE = get_typestore(Stores.ROS2_JAZZY)
T = STORE.types
number = st.floats(allow_nan=False)
numbers = st.lists(number, max_size=4)
text = st.text("abcß/_1", max_size=9)


def encoded(frame: str, names: list[str], fields: tuple[list[float], ...], *, little: bool = True) -> bytes:
    stamp = T["builtin_interfaces/msg/Time"](sec=1_790_000_000, nanosec=123_456_789)
    header = T["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)
    arrays = [np.array(values, dtype=np.float64) for values in fields]
    message = T["sensor_msgs/msg/JointState"](header, names, *arrays)
    return bytes(STORE.serialize_cdr(message, "sensor_msgs/msg/JointState", little_endian=little))


@given(text, st.lists(text, max_size=4), st.tuples(numbers, numbers, numbers), st.booleans())
def test_what_rosbags_writes_is_read_back(
    frame: str, names: list[str], fields: tuple[list[float], list[float], list[float]], little: bool
) -> None:
    found = JointDecoder().decode(encoded(frame, names, fields, little=little))
    assert found.stamp_ns == 1_790_000_000_123_456_789
    assert list(found.names) == names
    assert [list(each) for each in found[2:]] == [list(each) for each in fields]


@given(st.lists(st.tuples(text, numbers, st.booleans()), min_size=2, max_size=6))
def test_a_remembered_layout_never_leaks_into_another_message(rows: list[tuple[str, list[float], bool]]) -> None:
    decoder = JointDecoder()
    for name, values, little in rows * 2:
        data = encoded("", [name], (values, [], values), little=little)
        assert decoder.decode(data) == JointDecoder().decode(data)


CUT = encoded("", ["a"], ([1.0], [], []))[:-9]


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\0\1\0\0" + b"\xff" * 40, CUT])
def test_other_bytes_are_refused_with_a_sentence(data: bytes) -> None:
    with pytest.raises(LogError, match="do not hold a JointState"):
        JointDecoder().decode(data)


def test_float64_of_both_byte_orders() -> None:
    assert float64(b"\0\1\0\0" + struct.pack("<d", 2.5)) == 2.5
    assert float64(b"\0\0\0\0" + struct.pack(">d", 2.5)) == 2.5
    with pytest.raises(LogError, match="a Float64 has 12"):
        float64(b"\0\1\0")
