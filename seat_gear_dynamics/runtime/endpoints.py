"""Publishers and subscriptions."""

from __future__ import annotations

import inspect
import time
from collections import deque
from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.exceptions import InvalidHandle, RCLError
from seat_gear_dynamics.runtime.logging import get_logger
from seat_gear_dynamics.runtime.messages import decoder, encoder
from seat_gear_dynamics.runtime.qos import HistoryPolicy, QoSProfile
from seat_gear_dynamics.runtime.time import Duration

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.context import Context
    from seat_gear_dynamics.runtime.events import EventHandler
    from seat_gear_dynamics.runtime.groups import CallbackGroup
    from seat_gear_dynamics.runtime.wire.participant import Reader, Writer

_MOST_AT_ONCE = 32
"""Samples taken from DDS in one go: more would let a keep-last subscription fall behind."""


class Publisher:
    """Publishes messages of one type on one topic; made by `Node.create_publisher`."""

    def __init__(self, *, writer: Writer, context: Context, msg_type: Any, topic: str, name: str, qos: QoSProfile):
        self._writer = writer
        self._context = context
        self._encode: Callable[[Any], bytes] = encoder(msg_type)
        self._write = writer.write
        self._name = name
        self._open = True
        self.msg_type = msg_type
        self.topic = topic
        self.qos_profile = qos
        self.event_handlers: list[EventHandler] = []

    def publish(self, msg: Any) -> None:
        """Send a message, or bytes of one that is serialized already (with the 4-byte header).

        Raises:
            TypeError: it is of another type, or a field holds a wrong value.
            RCLError: the context was shut down.
            InvalidHandle: the publisher was destroyed.
        """
        if not self._open:
            raise InvalidHandle(f"The publisher on {self._name!r} was destroyed: create another.")
        if not self._context._sends():
            raise RCLError("Failed to publish: publisher's context is invalid")
        if isinstance(msg, self.msg_type):
            self._write(self._encode(msg))
        elif isinstance(msg, bytes):
            self._write(msg)
        else:
            raise TypeError(f"Expected {self.msg_type}, got {type(msg)}")

    def get_subscription_count(self) -> int:
        """Return how many subscriptions are matched."""
        return self._writer.matched() if self._open else 0

    @property
    def topic_name(self) -> str:
        """Absolute topic name, remapping applied."""
        return self._name

    def wait_for_all_acked(self, timeout: Duration = Duration(seconds=-1)) -> bool:  # noqa: B008
        """Wait until every reliable subscription has every message; negative times mean for ever.

        Returns whether they do. A best-effort publisher returns True at once.
        """
        forever = 2**63 - 1
        return self._writer.wait_for_acks(timeout.nanoseconds if timeout.nanoseconds >= 0 else forever)

    def assert_liveliness(self) -> None:
        """Say that this publisher is alive (liveliness MANUAL_BY_TOPIC)."""
        self._writer.assert_liveliness()

    @property
    def _gid(self) -> bytes:
        """The 16 bytes that name this publisher on the network."""
        return self._writer.gid()

    def destroy(self) -> None:
        """Leave the topic; use `Node.destroy_publisher`."""
        self._open = False
        for handler in self.event_handlers:
            handler.destroy()
        self._writer.close()


class Subscription:
    """Receives messages of one type on one topic; made by `Node.create_subscription`."""

    class CallbackType(Enum):
        """What the callback takes."""

        MessageOnly = 0
        WithMessageInfo = 1

    def __init__(
        self,
        *,
        reader: Reader,
        msg_type: Any,
        topic: str,
        name: str,
        callback: Callable[..., Any],
        callback_group: CallbackGroup | None,
        qos: QoSProfile,
        raw: bool,
        logger_name: str,
    ):
        self._reader = reader
        self._decode: Callable[[bytes], Any] | None = None if raw else decoder(msg_type)
        self._name = name
        self._queue: deque[tuple[bytes, Any]] = deque()
        keep_all = qos.history is HistoryPolicy.KEEP_ALL
        self._batch = _MOST_AT_ONCE if keep_all else max(1, min(qos.depth, _MOST_AT_ONCE))
        self._open = True
        self._logger_name = logger_name
        self._condition = reader.condition
        self.msg_type = msg_type
        self.topic = topic
        self.callback = callback
        self.callback_group = callback_group
        self.qos_profile = qos
        self.raw = raw
        self.event_handlers: list[EventHandler] = []

    @property
    def callback(self) -> Callable[..., Any]:
        """Function called with a message, or with a message and its info."""
        return self._callback

    @callback.setter
    def callback(self, value: Callable[..., Any]) -> None:
        self._callback = value
        self._callback_type = _callback_type(value)

    def _take_work(self) -> Callable[[], Any] | None:
        """Return a call of the callback with the next message."""
        queue = self._queue
        if not queue:
            if not self._open:
                return None
            queue.extend(self._reader.take(self._batch))
            if not queue:
                return None
        data, info = queue.popleft()
        message: Any = data
        if self._decode is not None:
            try:
                message = self._decode(data)
            except ValueError as error:
                # One malformed publisher must not end a node that listens to good ones too.
                get_logger(self._logger_name).error(f"A message on {self._name} is left out: {error}")
                return None
        if self._callback_type is Subscription.CallbackType.MessageOnly:
            return partial(self._callback, message)
        return partial(self._callback, message, _message_info(info))

    def _has_backlog(self) -> bool:
        """Return whether messages taken from DDS wait for their callback."""
        return bool(self._queue)

    def get_publisher_count(self) -> int:
        """Return how many publishers are matched."""
        return self._reader.matched() if self._open else 0

    @property
    def topic_name(self) -> str:
        """Absolute topic name, remapping applied."""
        return self._name

    @property
    def _gid(self) -> bytes:
        """The 16 bytes that name this subscription on the network."""
        return self._reader.gid()

    def destroy(self) -> None:
        """Leave the topic; use `Node.destroy_subscription`."""
        self._open = False
        for handler in self.event_handlers:
            handler.destroy()
        self._queue.clear()
        self._reader.close()


def _message_info(info: Any) -> dict[str, int | None]:
    """Return the info a two-argument callback gets: times in ns since 1970, numbers DDS does not tell as None."""
    return {
        "source_timestamp": info.source_timestamp,
        "received_timestamp": time.time_ns(),
        "publication_sequence_number": None,
        "reception_sequence_number": None,
    }


def _callback_type(callback: Callable[..., Any]) -> Subscription.CallbackType:
    signature = inspect.signature(callback)
    for kind, arguments in ((Subscription.CallbackType.MessageOnly, 1), (Subscription.CallbackType.WithMessageInfo, 2)):
        try:
            signature.bind(*[None] * arguments)
        except TypeError:
            continue
        return kind
    raise RuntimeError(
        "Subscription.__init__(): callback should be either be callable with one argument"
        "(to get only the message) or two (to get message and message info)"
    )
