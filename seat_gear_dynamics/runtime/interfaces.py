"""Field tables, defaults and type hashes of the ROS 2 Jazzy message and service types."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

PRIMITIVES = frozenset(
    (
        *("bool", "byte", "char", "string", "float32", "float64"),
        *("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"),
    )
)

PLACEHOLDER = "structure_needs_at_least_one_member"
"""Field a type without fields has on the wire."""


class Kind(NamedTuple):
    """Type of a field: a primitive or message name, alone or as an array or a sequence.

    `shape` is "one", "array" (fixed `length`) or "sequence" (`length` is the bound, 0 without one).
    """

    base: str
    shape: str = "one"
    length: int = 0
    string_bound: int = 0

    @property
    def primitive(self) -> bool:
        """Whether the element is a primitive or a string, not a message."""
        return self.base in PRIMITIVES

    def spelled(self) -> str:
        """Return the type as an .msg file and `get_fields_and_field_types` spell it."""
        base = {"float32": "float", "float64": "double", "byte": "octet", "char": "uint8"}.get(
            self.base, self.base.replace("/msg/", "/").replace("/srv/", "/")
        )
        if self.string_bound:
            base = f"{base}<{self.string_bound}>"
        if self.shape == "array":
            return f"{base}[{self.length}]"
        if self.shape == "sequence":
            return f"sequence<{base}, {self.length}>" if self.length else f"sequence<{base}>"
        return base


class Interface(NamedTuple):
    """A message type: full name, constants by name, field kinds by name."""

    name: str
    constants: dict[str, Any]
    fields: dict[str, Kind]


_DEFAULTS: dict[str, dict[str, Any]] = {
    "geometry_msgs/msg/Quaternion": {"w": 1.0},
}
"""Field defaults of the .msg files that are not zero: the type store does not keep them."""

_SERVICES: dict[str, tuple[str, str]] = {
    "std_srvs/srv/Empty": ("", ""),
    "std_srvs/srv/Trigger": ("", "bool success\nstring message"),
    "std_srvs/srv/SetBool": ("bool data", "bool success\nstring message"),
    "rcl_interfaces/srv/GetParameters": ("string[] names", "rcl_interfaces/ParameterValue[] values"),
    "rcl_interfaces/srv/GetParameterTypes": ("string[] names", "uint8[] types"),
    "rcl_interfaces/srv/SetParameters": (
        "rcl_interfaces/Parameter[] parameters",
        "rcl_interfaces/SetParametersResult[] results",
    ),
    "rcl_interfaces/srv/SetParametersAtomically": (
        "rcl_interfaces/Parameter[] parameters",
        "rcl_interfaces/SetParametersResult result",
    ),
    "rcl_interfaces/srv/ListParameters": (
        "uint64 DEPTH_RECURSIVE=0\nstring[] prefixes\nuint64 depth",
        "rcl_interfaces/ListParametersResult result",
    ),
    "rcl_interfaces/srv/DescribeParameters": (
        "string[] names",
        "rcl_interfaces/ParameterDescriptor[] descriptors",
    ),
    "lifecycle_msgs/srv/ChangeState": ("lifecycle_msgs/Transition transition", "bool success"),
    "lifecycle_msgs/srv/GetState": ("", "lifecycle_msgs/State current_state"),
    "lifecycle_msgs/srv/GetAvailableStates": ("", "lifecycle_msgs/State[] available_states"),
    "lifecycle_msgs/srv/GetAvailableTransitions": (
        "",
        "lifecycle_msgs/TransitionDescription[] available_transitions",
    ),
}
"""Request and response definitions of the known services: the type store has messages only."""


@cache
def _store() -> Any:
    """Return the type store, with the services' requests and responses added to it."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    for service, (request, response) in _SERVICES.items():
        for suffix, text in (("_Request", request), ("_Response", response)):
            (definition,) = get_types_from_msg(text or f"uint8 {PLACEHOLDER}", "a/msg/B").values()
            store.register({service + suffix: definition})
    return store


def known_services() -> tuple[str, ...]:
    """Return the full names of the services this runtime can offer and call."""
    return tuple(_SERVICES)


def exists(name: str) -> bool:
    """Return whether `name` ("pkg/msg/Name") is a known message, request or response type."""
    return name in _store().fielddefs


@cache
def interface(name: str) -> Interface:
    """Return constants and fields of a message type given as "pkg/msg/Name".

    Raises:
        LookupError: the name is not a type of the ROS 2 Jazzy type store.
    """
    if not exists(name):
        raise LookupError(
            f"{name!r} is not a message type of ROS 2 Jazzy's common interfaces: "
            "expected a name such as 'std_msgs/msg/Float64'."
        )
    constants, fields = _store().fielddefs[name]
    return Interface(
        name,
        {constant: _constant(base, value) for constant, base, value in constants},
        {field: _kind(description) for field, description in fields},
    )


def defaults_of(name: str) -> dict[str, Any]:
    """Return the field defaults of a type that differ from zero, empty or false."""
    return _DEFAULTS.get(name, {})


@cache
def type_hash(name: str) -> str:
    """Return the RIHS01 hash of a message, request or response type."""
    return str(_store().hash_rihs01(name))


def _constant(base: str, value: Any) -> Any:
    return bytes([value]) if base == "byte" else value


def _kind(description: Any) -> Kind:
    """Translate the type store's nested description of a field."""
    node, detail = description
    if node.name == "BASE":
        return Kind(detail[0], string_bound=detail[1] if detail[0] == "string" else 0)
    if node.name == "NAME":
        return Kind(detail)
    element, length = _kind(detail[0]), detail[1]
    shape = "array" if node.name == "ARRAY" else "sequence"
    return Kind(element.base, shape, length, element.string_bound)
