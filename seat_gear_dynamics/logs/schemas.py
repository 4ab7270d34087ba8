"""Message definitions, type hashes and CDR decoding, from rosbags' ROS 2 Jazzy type store."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from seat_gear_dynamics.logs.errors import LogError


class Schema(NamedTuple):
    """A message type as a log describes it: full name, `ros2msg` text, RIHS01 type hash."""

    name: str
    text: str
    hash: str


@lru_cache(maxsize=1)
def _jazzy() -> Typestore:
    """Build the type store once: it parses every Jazzy definition."""
    return get_typestore(Stores.ROS2_JAZZY)


@lru_cache(maxsize=256)
def schema(name: str) -> Schema:
    """Return the definition and hash of the ROS 2 Jazzy type `name`, for example `std_msgs/msg/Float64`.

    Raises `LogError` for a name that Jazzy's common interfaces do not hold.
    """
    try:
        text, _ = _jazzy().generate_msgdef(name, ros_version=2)
        return Schema(name, text, _jazzy().hash_rihs01(name))
    except (TypesysError, KeyError) as cause:
        raise LogError(
            f"The message type {name!r} is not among ROS 2 Jazzy's common interfaces; expected a full name "
            f"such as 'std_msgs/msg/Float64'. Correct the name, or leave the topic out of the log."
        ) from cause


class Decoder:
    """Turns CDR bytes into message objects with the attributes of the ROS type.

    `definitions` maps a type name to the `ros2msg` text found in a log; it is used for types that Jazzy does
    not know, so that logs with foreign message packages can be read too.
    """

    def __init__(self, definitions: Mapping[str, str]) -> None:
        self._store = _jazzy()
        unknown = {name: text for name, text in definitions.items() if name not in self._store.fielddefs}
        if unknown:
            # A store of its own, so that one log's types never leak into the next log's.
            self._store = get_typestore(Stores.ROS2_JAZZY)
            for name, text in unknown.items():
                self._register(name, text)

    def _register(self, name: str, text: str) -> None:
        try:
            types = get_types_from_msg(text, name)
            self._store.register({key: t for key, t in types.items() if key not in self._store.fielddefs})
        except (TypesysError, ValueError):
            # Only this type is lost; decode() says so if anybody asks for it.
            return

    def decode(self, data: bytes, name: str) -> Any:
        """Return the message of type `name` in `data` (CDR with its 4-byte header).

        Raises `LogError` for an unknown type and for bytes that do not hold such a message.
        """
        if name not in self._store.fielddefs:
            raise LogError(
                f"Messages of type {name!r} cannot be decoded: neither ROS 2 Jazzy nor the log defines the "
                f"type as ros2msg text. Read them as bytes with messages()."
            )
        try:
            return self._store.deserialize_cdr(data, name)
        except Exception as cause:  # the generated decoders meet senseless bytes with errors of many kinds
            raise LogError(
                f"{len(data)} bytes do not hold a message of type {name!r} ({cause}); the message is damaged "
                f"or its type is declared wrongly."
            ) from cause
