"""Build Python classes for ROS messages and services, with ROS's defaults, constants and names."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable
from functools import cache
from typing import Any, ClassVar

from seat_gear_dynamics.runtime import interfaces
from seat_gear_dynamics.runtime.cdr.blocks import CODES, HEADER, SIZES, fixed
from seat_gear_dynamics.runtime.cdr.read import Readers
from seat_gear_dynamics.runtime.cdr.write import Writers
from seat_gear_dynamics.runtime.interfaces import PLACEHOLDER, Kind
from seat_gear_dynamics.runtime.message_faults import find_fault


class Message:
    """Base of all message classes: keyword construction, equality, text, and the CDR functions."""

    __slots__ = ()
    FULL_NAME: ClassVar[str]
    """Full name, such as "std_msgs/msg/Float64"."""
    FIELDS: ClassVar[dict[str, Kind]]
    MAKERS: ClassVar[dict[str, Callable[[], Any]]]

    def __init__(self, **kwargs: Any) -> None:
        for field, make in self.MAKERS.items():
            setattr(self, field, kwargs.pop(field) if field in kwargs else make())
        if kwargs:
            raise TypeError(
                f"{self.FULL_NAME} has no field {next(iter(kwargs))!r}: "
                f"its fields are {', '.join(self.FIELDS) or 'none'}."
            )

    def __eq__(self, other: object) -> bool:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return all(_same(getattr(self, field), getattr(other, field)) for field in self.FIELDS)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        values = ", ".join(f"{field}={getattr(self, field)!r}" for field in self.FIELDS)
        return f"{self.FULL_NAME.replace('/', '.')}({values})"

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Return the field names and their ROS types, in order."""
        return {field: kind.spelled() for field, kind in cls.FIELDS.items()}


def _same(one: Any, other: Any) -> bool:
    if hasattr(one, "tolist") or hasattr(other, "tolist"):
        return list(one) == list(other)
    return bool(one == other)


@cache
def message_class(name: str) -> Any:
    """Return the class of a message, request or response type such as "std_msgs/msg/Float64".

    Raises:
        LookupError: the type is not known.
    """
    made = interfaces.interface(name)
    fields = {field: kind for field, kind in made.fields.items() if field != PLACEHOLDER}
    short = name.rpartition("/")[2]
    special = interfaces.defaults_of(name)
    namespace: dict[str, Any] = {
        **made.constants,
        "__slots__": tuple(fields),
        "__doc__": f"ROS message {name}.",
        "__module__": name.rpartition("/")[0].replace("/", "."),
        "FULL_NAME": name,
        "FIELDS": fields,
        "MAKERS": {field: _maker(kind, special.get(field)) for field, kind in fields.items()},
    }
    return type(short, (Message,), namespace)


_ZEROS: dict[str, Any] = {"bool": False, "byte": b"\x00", "string": "", "float32": 0.0, "float64": 0.0}


def _maker(kind: Kind, special: Any) -> Callable[[], Any]:
    """Return a function that makes the default value of a field."""
    if kind.shape == "one":
        if not kind.primitive:
            nested: Callable[[], Any] = message_class(kind.base)
            return nested
        value = _ZEROS.get(kind.base, 0) if special is None else special
        return lambda: value
    numeric = kind.primitive and kind.base not in ("bool", "byte", "string")
    if kind.shape == "sequence":
        return (lambda: array(CODES[kind.base])) if numeric else list
    if numeric:
        return lambda: fixed(array(CODES[kind.base], bytes(SIZES[kind.base] * kind.length)))
    element = _maker(kind._replace(shape="one"), None)
    return lambda: [element() for _ in range(kind.length)]


_writers = Writers(lambda name: interfaces.interface(name).fields)
_readers = Readers(lambda name: interfaces.interface(name).fields, message_class)


@cache
def encoder(cls: Any) -> Callable[[Any], bytes]:
    """Return a function from a message of class `cls` to CDR bytes with the 4-byte header.

    The function raises TypeError with a sentence when a field holds a value of the wrong type or range.
    """
    write = _writers.writer(cls.FULL_NAME)

    def encode(message: Any) -> bytes:
        buffer = bytearray(HEADER)
        try:
            write(buffer, message)
        except (struct.error, TypeError, ValueError, OverflowError, AttributeError) as error:
            raise TypeError(find_fault(message) or f"{cls.FULL_NAME} cannot be encoded: {error}.") from error
        return bytes(buffer)

    return encode


@cache
def decoder(cls: Any) -> Callable[[bytes], Any]:
    """Return a function from CDR bytes with the 4-byte header to a message of class `cls`.

    The function raises ValueError with a sentence when the bytes are not such a message.
    """
    read = _readers.reader(cls.FULL_NAME)

    def decode(data: bytes) -> Any:
        if data[:2] != b"\x00\x01":
            raise ValueError(
                f"{cls.FULL_NAME} cannot be decoded: the bytes start with {data[:4].hex(' ') or 'nothing'}, "
                "expected 00 01 (little-endian CDR); check who publishes on the topic."
            )
        try:
            message, end = read(data, 4)
        except (struct.error, ValueError) as error:
            raise ValueError(
                f"{len(data)} bytes are not a {cls.FULL_NAME}: {error}; check the publisher's type."
            ) from error
        if end > len(data):
            raise ValueError(
                f"{len(data)} bytes are not a {cls.FULL_NAME}, which needs {end}; check the publisher's type."
            )
        return message

    return decode


class _ServiceMeta(type):
    """Makes a service's request and response classes when they are first asked for."""

    FULL_NAME: str

    def __getattr__(cls, name: str) -> Any:
        if name in ("Request", "Response") and "FULL_NAME" in cls.__dict__:
            made = message_class(f"{cls.FULL_NAME}_{name}")
            setattr(cls, name, made)
            return made
        raise AttributeError(f"{cls.__name__} has no attribute {name!r}")


class Service(metaclass=_ServiceMeta):
    """Base of all service classes, which hold the classes `Request` and `Response`."""

    FULL_NAME: ClassVar[str]
    Request: ClassVar[Any]
    Response: ClassVar[Any]

    def __init__(self) -> None:
        raise TypeError(f"{type(self).__name__} is a service, not a message: use its .Request() or .Response().")


@cache
def service_class(name: str) -> Any:
    """Return the class of a service such as "std_srvs/srv/Trigger".

    Raises:
        LookupError: the service is not one this runtime knows.
    """
    known = interfaces.known_services()
    if name not in known:
        raise LookupError(
            f"{name!r} is not a service type of the bundled runtime, which has {', '.join(sorted(known))}; "
            "source a ROS 2 Jazzy installation to use others."
        )
    made: Any = _ServiceMeta(
        name.rpartition("/")[2], (Service,), {"FULL_NAME": name, "__doc__": f"ROS service {name}."}
    )
    return made


def get_message(identifier: str) -> Any:
    """Return the class of the message "pkg/msg/Name", or "pkg/Name" for short.

    Raises:
        AttributeError, ValueError: the text is not such a name, or the type is not known (as rosidl_runtime_py).
    """
    parts = identifier.split("/")
    if len(parts) == 2:
        parts.insert(1, "msg")
    if len(parts) != 3 or parts[1] != "msg" or not all(parts):
        raise ValueError(f"{identifier!r} does not name a message type: expected text such as 'std_msgs/msg/Float64'.")
    try:
        return message_class("/".join(parts))
    except LookupError as error:
        raise AttributeError(str(error.args[0])) from None


def get_service(identifier: str) -> Any:
    """Return the class of the service "pkg/srv/Name".

    Raises:
        ValueError, AttributeError: the text is not such a name, or the service is not known.
    """
    parts = identifier.split("/")
    if len(parts) == 2:
        parts.insert(1, "srv")
    if len(parts) != 3 or parts[1] != "srv" or not all(parts):
        raise ValueError(f"{identifier!r} does not name a service type: expected text such as 'std_srvs/srv/Trigger'.")
    try:
        return service_class("/".join(parts))
    except LookupError as error:
        raise AttributeError(str(error.args[0])) from None


def expose(module: str) -> Callable[[str], Any]:
    """Return the `__getattr__` of a module such as "std_msgs.msg" or "std_srvs.srv".

    The names of the module become message or service classes when first used, which keeps its import quick.
    An unknown name raises AttributeError with a sentence.
    """
    package, _, folder = module.partition(".")
    make: Callable[[str], Any] = message_class if folder == "msg" else service_class

    def getattr_type(name: str) -> Any:
        if not name.startswith("_"):
            try:
                return make(f"{package}/{folder}/{name}")
            except LookupError as error:
                raise AttributeError(str(error.args[0])) from None
        raise AttributeError(f"module {module!r} has no attribute {name!r}")

    return getattr_type


def is_message_class(candidate: object) -> bool:
    """Return whether something is a class made by this module."""
    return isinstance(candidate, type) and issubclass(candidate, Message) and candidate is not Message


def check_message_class(candidate: object) -> None:
    """Refuse anything but a message class.

    Raises:
        TypeError: with a sentence naming what was given.
    """
    if not is_message_class(candidate):
        raise TypeError(
            f"{candidate!r} is not a message class of the bundled runtime: "
            "give a class such as std_msgs.msg.Float64, imported after provide_rclpy()."
        )


def check_service_class(candidate: object) -> None:
    """Refuse anything but a service class.

    Raises:
        TypeError: with a sentence naming what was given.
    """
    if not (isinstance(candidate, type) and issubclass(candidate, Service) and candidate is not Service):
        raise TypeError(
            f"{candidate!r} is not a service class of the bundled runtime: "
            "give a class such as std_srvs.srv.Trigger, imported after provide_rclpy()."
        )
