"""Describe ROS types to Cyclone DDS: the structs its topics are made of."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from seat_gear_dynamics.runtime import interfaces
from seat_gear_dynamics.runtime.interfaces import PLACEHOLDER, Kind


@cache
def topic_struct(name: str, request_header: bool = False) -> Any:
    """Return the IdlStruct of a ROS type, with the client's identity before it where it travels in a service.

    Only its description is used: the bytes are written and read by `messages`.
    """
    from cyclonedds.idl import make_idl_struct, types

    fields: dict[str, Any] = {"guid": types.uint64, "seq": types.int64} if request_header else {}
    for field, kind in (interfaces.interface(name).fields or {PLACEHOLDER: Kind("uint8")}).items():
        fields[field] = _field_type(kind)
    package, folder, short = name.split("/")
    # A class name with underscores inside stays as it is; Cyclone takes the DDS name from `typename`.
    return make_idl_struct(re.sub(r"\W", "_", f"{package}_{short}"), f"{package}.{folder}.dds_.{short}_", fields)


def _field_type(kind: Kind) -> Any:
    from cyclonedds.idl import types as idl_types

    # The package's own annotations do not know that these take arguments in brackets.
    types: Any = idl_types
    if kind.base == "string":
        element: Any = types.bounded_str[kind.string_bound] if kind.string_bound else str
    elif kind.base == "bool":
        element = bool
    elif kind.primitive:
        element = getattr(types, {"char": "uint8"}.get(kind.base, kind.base))
    else:
        element = topic_struct(kind.base)
    if kind.shape == "array":
        return types.array[element, kind.length]
    if kind.shape == "sequence":
        return types.sequence[element, kind.length] if kind.length else types.sequence[element]
    return element
