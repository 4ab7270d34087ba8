"""Message classes, their constants and defaults, and their bytes against rosbags."""

from __future__ import annotations

import contextlib
from array import array
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from seat_gear_dynamics.runtime import client_library as rclpy
from seat_gear_dynamics.runtime import interfaces
from seat_gear_dynamics.runtime.messages import get_message, get_service, message_class

STORE = get_typestore(Stores.ROS2_JAZZY)
NINE = [
    "std_msgs/msg/Float64",
    "std_msgs/msg/Bool",
    "std_msgs/msg/String",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/PointCloud2",
    "sensor_msgs/msg/CameraInfo",
    "diagnostic_msgs/msg/DiagnosticArray",
    "rcl_interfaces/msg/ParameterEvent",
    "std_msgs/msg/UInt8MultiArray",
]

_INTEGERS = {f"{sign}int{bits}": (sign, bits) for sign in ("", "u") for bits in (8, 16, 32, 64)}
_INTEGERS["char"] = ("u", 8)


def primitive(base: str) -> st.SearchStrategy[Any]:
    if base in _INTEGERS:
        sign, bits = _INTEGERS[base]
        return st.integers(0, 2**bits - 1) if sign else st.integers(-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    return {
        "bool": st.booleans(),
        "byte": st.binary(min_size=1, max_size=1),
        "string": st.text(st.characters(exclude_characters="\0", codec="utf-8"), max_size=9),
        "float32": st.floats(width=32, allow_nan=False),
        "float64": st.floats(allow_nan=False),
    }[base]


def messages(name: str) -> st.SearchStrategy[Any]:
    fields = {}
    for field, kind in message_class(name).FIELDS.items():
        one = primitive(kind.base) if kind.primitive else messages(kind.base)
        if kind.shape == "array":
            one = st.lists(one, min_size=kind.length, max_size=kind.length)
        elif kind.shape == "sequence":
            one = st.lists(one, max_size=min(kind.length or 3, 3))
        fields[field] = one
    return st.builds(message_class(name), **fields)


def by_rosbags(message: Any) -> Any:
    """Return the same content as an object of rosbags."""
    dtypes = {"bool": np.bool_, "char": np.uint8, "byte": np.uint8}

    def convert(value: Any, kind: interfaces.Kind) -> Any:
        if kind.shape == "one":
            if not kind.primitive:
                return by_rosbags(value)
            # rosbags takes a single byte as a signed number.
            return int.from_bytes(value, "little", signed=True) if kind.base == "byte" else value
        single = kind._replace(shape="one")
        values = [item[0] if kind.base == "byte" else convert(item, single) for item in value]
        if kind.primitive and kind.base != "string":
            return np.array(values, dtype=dtypes.get(kind.base, kind.base))
        return values

    fields = {name: convert(getattr(message, name), kind) for name, kind in message.FIELDS.items()}
    return STORE.types[message.FULL_NAME](**fields)


@pytest.mark.parametrize("name", NINE)
def test_bytes_equal_rosbags(name: str) -> None:
    @settings(max_examples=40, deadline=None, database=None)
    @given(messages(name))
    def check(message: Any) -> None:
        ours = rclpy.serialize_message(message)
        assert ours == bytes(STORE.serialize_cdr(by_rosbags(message), name))
        again = rclpy.deserialize_message(ours, type(message))
        assert rclpy.serialize_message(again) == ours

    check()


def test_every_type_of_the_store_encodes_its_defaults() -> None:
    for name in STORE.fielddefs:
        message = message_class(name)()
        data = rclpy.serialize_message(message)
        assert rclpy.deserialize_message(data, type(message)) == message
        assert bytes(STORE.serialize_cdr(STORE.deserialize_cdr(data, name), name)) == data, name


def test_constants_defaults_and_keywords() -> None:
    status = get_message("diagnostic_msgs/msg/DiagnosticStatus")
    assert (status.OK, status.WARN, status.ERROR, status.STALE) == (b"\x00", b"\x01", b"\x02", b"\x03")
    message = status(level=status.WARN, name="gear")
    assert (message.level, message.name, message.values, message.hardware_id) == (b"\x01", "gear", [], "")
    joint = get_message("sensor_msgs/msg/JointState")()
    assert joint.position == array("d")
    assert joint.header.stamp.nanosec == 0
    assert joint.header is not get_message("sensor_msgs/JointState")().header
    assert get_message("geometry_msgs/msg/Quaternion")().w == 1.0
    assert get_message("sensor_msgs/msg/PointField").FLOAT64 == 8


def test_fields_and_types_as_rosidl_spells_them() -> None:
    joint = get_message("sensor_msgs/msg/JointState")
    assert joint.get_fields_and_field_types() == {
        "header": "std_msgs/Header",
        "name": "sequence<string>",
        "position": "sequence<double>",
        "velocity": "sequence<double>",
        "effort": "sequence<double>",
    }
    assert get_message("diagnostic_msgs/DiagnosticStatus").get_fields_and_field_types()["level"] == "octet"


@pytest.mark.parametrize(
    "values", [[1.0, 2.0], (1.0, 2.0), array("d", [1, 2]), np.array([1.0, 2.0]), np.array([1, 2], dtype="f4")]
)
def test_number_sequences_take_lists_and_arrays(values: Any) -> None:
    joint = get_message("sensor_msgs/msg/JointState")
    assert rclpy.serialize_message(joint(position=values)) == rclpy.serialize_message(joint(position=[1.0, 2.0]))


@pytest.mark.parametrize("data", [b"\1\2", bytearray(b"\1\2"), array("B", [1, 2]), np.array([1, 2], np.uint8), [1, 2]])
def test_octet_sequences_take_bytes_and_arrays(data: Any) -> None:
    cloud = get_message("sensor_msgs/msg/PointCloud2")
    assert rclpy.serialize_message(cloud(data=data)) == rclpy.serialize_message(cloud(data=[1, 2]))


@pytest.mark.parametrize(
    ("name", "values", "says"),
    [
        ("std_msgs/msg/Float64", {"data": 1}, "data is 1 of type int, expected double: convert it with float()"),
        ("std_msgs/msg/Float64", {"data": "x"}, "data is 'x' of type str"),
        ("std_msgs/msg/Bool", {"data": 1}, "data is 1 of type int, expected bool"),
        ("std_msgs/msg/UInt8", {"data": 256}, "outside the range of uint8"),
        ("std_msgs/msg/String", {"data": b"x"}, "expected string"),
        ("sensor_msgs/msg/JointState", {"name": "abc"}, "name is 'abc', expected sequence<string>"),
        ("sensor_msgs/msg/JointState", {"position": ["a"]}, "position[0] is 'a'"),
        ("sensor_msgs/msg/JointState", {"header": 3}, "header is 3, expected a std_msgs/msg/Header"),
        ("sensor_msgs/msg/CameraInfo", {"k": [1.0]}, "k has 1 elements, expected exactly 9"),
        ("diagnostic_msgs/msg/DiagnosticStatus", {"level": 1}, "level is 1 of type int, expected octet"),
        ("rcl_interfaces/msg/ParameterDescriptor", {"integer_range": [1, 2]}, "expected at most 1"),
    ],
)
def test_wrong_values_are_sentences(name: str, values: dict[str, Any], says: str) -> None:
    with pytest.raises(TypeError) as caught:
        rclpy.serialize_message(message_class(name)(**values))
    assert says in str(caught.value)
    assert name in str(caught.value)


def test_wrong_fields_and_types_are_sentences() -> None:
    with pytest.raises(TypeError, match="has no field 'dat': its fields are data"):
        get_message("std_msgs/msg/Float64")(dat=1.0)
    message = get_message("std_msgs/msg/Float64")()
    with pytest.raises(AttributeError, match="dta"):
        message.dta = 1.0
    with pytest.raises(AttributeError, match="is not a message type of ROS 2 Jazzy"):
        get_message("std_msgs/msg/Float65")
    with pytest.raises(ValueError, match="does not name a message type"):
        get_message("Float64")
    with pytest.raises(AttributeError, match="is not a service type of the bundled runtime"):
        get_service("std_srvs/srv/Nothing")


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "start with nothing"),
        (b"\0\0\0\0" + bytes(8), "expected 00 01"),
        (b"\0\1\0\0abc", "are not a std_msgs/msg/Float64"),
    ],
)
def test_wrong_bytes_are_sentences(data: bytes, says: str) -> None:
    with pytest.raises(ValueError, match="std_msgs/msg/Float64") as caught:
        rclpy.deserialize_message(data, get_message("std_msgs/msg/Float64"))
    assert says in str(caught.value)


@settings(max_examples=200, deadline=None, database=None)
@given(st.binary(max_size=80))
def test_no_bytes_make_the_decoder_fail_otherwise(tail: bytes) -> None:
    for name in ("sensor_msgs/msg/JointState", "diagnostic_msgs/msg/DiagnosticArray"):
        with contextlib.suppress(ValueError):
            rclpy.deserialize_message(b"\0\1\0\0" + tail, message_class(name))


JAZZY_LIFECYCLE = {
    "msg/TransitionEvent": "d5f8873a2f0146498f812d7885c7327ce27e463d36811d8792f35ee38c0d6c38",
    "srv/ChangeState_Request": "d74c6f524e14cade7b67e7297190360ed749264af300524fc1456f27cc2a553a",
    "srv/ChangeState_Response": "e1ddfed0271fefe63767aa71561926e4d9eac0f1ddf9e71a8873eb46b36deac2",
    "srv/GetState_Request": "77a9c844e7975f15bc2221e8bbebafc4d118afb78c7f7071eef91f83f940f2f6",
    "srv/GetState_Response": "fe249babab472e42cb5653b5d6a6b0c42a003b0fdfb84851aea3fde08760b4f5",
    "srv/GetAvailableStates_Response": "223e0dd5bb8a847ebb9532adaf8b5e2a97e6e68e79faeaabd81a45fb32925bd1",
    "srv/GetAvailableTransitions_Response": "4711339461aadf02bcfff797a198de911f885074bd3f2fe9f7b677ef87f0741c",
}
"""Hashes in the .json files that Jazzy's lifecycle_msgs 2.0.2 installs."""


@pytest.mark.parametrize(("name", "digest"), JAZZY_LIFECYCLE.items())
def test_lifecycle_hashes_are_those_of_jazzy(name: str, digest: str) -> None:
    assert interfaces.type_hash(f"lifecycle_msgs/{name}") == f"RIHS01_{digest}"


def test_hashes_are_those_of_jazzy() -> None:
    expected = "RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a"
    assert interfaces.type_hash("std_msgs/msg/Float64") == expected
    # From the ROS 2 Jazzy build of std_srvs.
    assert interfaces.type_hash("std_srvs/srv/SetBool_Request").startswith("RIHS01_")


def test_services_have_requests_and_responses() -> None:
    trigger = get_service("std_srvs/srv/Trigger")
    assert trigger.Request().get_fields_and_field_types() == {}
    assert trigger.Response(success=True).message == ""
    assert get_service("rcl_interfaces/srv/ListParameters").Request.DEPTH_RECURSIVE == 0
    assert rclpy.serialize_message(trigger.Request()) == b"\0\1\0\0\0"
    with pytest.raises(TypeError, match=r"use its \.Request\(\)"):
        trigger()
