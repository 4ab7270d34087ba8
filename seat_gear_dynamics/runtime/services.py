"""Service servers and clients, as the Cyclone DDS middleware of ROS speaks them.

A request and its reply travel on two topics; both start with the client's number and a sequence number.
"""

from __future__ import annotations

import inspect
import itertools
import secrets
import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Generator
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.cdr.blocks import HEADER
from seat_gear_dynamics.runtime.exceptions import InvalidHandle, RCLError
from seat_gear_dynamics.runtime.logging import get_logger
from seat_gear_dynamics.runtime.messages import decoder, encoder
from seat_gear_dynamics.runtime.qos import QoSProfile
from seat_gear_dynamics.runtime.tasks import Future
from seat_gear_dynamics.runtime.wire.peers import hears

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.context import Context
    from seat_gear_dynamics.runtime.groups import CallbackGroup
    from seat_gear_dynamics.runtime.wire.participant import Reader, Writer

_IDENTITY = struct.Struct("<Qq")
_BODY = len(HEADER) + _IDENTITY.size
_MOST_AT_ONCE = 16
_LONGEST_DISCOVERY = 1.0
"""Seconds a reply waits for its client's reader to be found; ROS's own middleware waits a tenth, blocking."""
_MOST_KNOWN = 256
"""Clients remembered as heard; forgetting one costs a look."""


def wrap(identity: bytes, body: bytes) -> bytes:
    """Return a message's bytes with a request's identity (16 bytes) after the header."""
    return body[:4] + identity + body[4:]


def unwrap(data: bytes) -> tuple[bytes, bytes]:
    """Return the identity of a request and the message's bytes without it.

    Raises:
        ValueError: the bytes are too short.
    """
    if len(data) < _BODY:
        raise ValueError(f"{len(data)} bytes are too short for a service message: expected {_BODY} or more.")
    return data[4:_BODY], data[:4] + data[_BODY:]


class _NextRound:
    """Awaited, it lets the executor do its other work first."""

    def __await__(self) -> Generator[None, None, None]:
        yield


class Service:
    """Answers requests; made by `Node.create_service`."""

    def __init__(
        self,
        *,
        reader: Reader,
        writer: Writer,
        srv_type: Any,
        srv_name: str,
        name: str,
        callback: Callable[..., Any],
        callback_group: CallbackGroup | None,
        qos: QoSProfile,
        logger_name: str,
    ):
        self._reader, self._writer = reader, writer
        self._logger_name = logger_name
        self._decode = decoder(srv_type.Request)
        self._encode = encoder(srv_type.Response)
        self._name = name
        self._queue: deque[tuple[bytes, int]] = deque()
        self._known: set[int] = set()
        self._open = True
        self._condition = reader.condition
        self.srv_type = srv_type
        self.srv_name = srv_name
        self.callback = callback
        self.callback_group = callback_group
        self.qos_profile = qos

    def _take_work(self) -> Callable[[], Any] | None:
        """Return the answering of the next request."""
        if not self._queue and self._open:
            taken = self._reader.take(_MOST_AT_ONCE)
            self._queue.extend((data, info.publication_handle) for data, info in taken)
        if not self._queue:
            return None
        data, client = self._queue.popleft()
        try:
            identity, body = unwrap(data)
            request = self._decode(body)
        except ValueError as error:
            # One malformed client must not end a node that serves good ones too.
            get_logger(self._logger_name).error(f"A request to {self._name} is left out: {error}")
            return None
        return lambda: self._answer(identity, request, client)

    def _has_backlog(self) -> bool:
        """Return whether requests taken from DDS wait for their answer."""
        return bool(self._queue)

    def _answer(self, identity: bytes, request: Any, client: int) -> Any:
        response = self.callback(request, self.srv_type.Response())
        if not inspect.iscoroutine(response) and self._is_heard_by(client):
            self._send(identity, response)
            return None
        return self._answer_later(identity, response, client)

    async def _answer_later(self, identity: bytes, response: Any, client: int) -> None:
        if inspect.iscoroutine(response):
            response = await response
        end = time.monotonic() + _LONGEST_DISCOVERY
        while self._open and not self._is_heard_by(client) and time.monotonic() < end:
            await _NextRound()
        self._send(identity, response)

    def _is_heard_by(self, client: int) -> bool:
        if client not in self._known and hears(self._writer, self._reader, client):
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            self._known.add(client)
        return client in self._known

    def _send(self, identity: bytes, response: Any) -> None:
        if not isinstance(response, self.srv_type.Response):
            raise TypeError(
                f"The callback of service {self._name!r} returned {response!r}, "
                f"expected a {self.srv_type.Response.FULL_NAME}: return the response it is given."
            )
        if self._open:
            self._writer.write(wrap(identity, self._encode(response)))

    @property
    def service_name(self) -> str:
        """Absolute service name, remapping applied."""
        return self._name

    def _gids(self) -> tuple[bytes, bytes]:
        """Return the names of the reader and the writer on the network."""
        return self._reader.gid(), self._writer.gid()

    def destroy(self) -> None:
        """Stop answering; use `Node.destroy_service`."""
        self._open = False
        self._queue.clear()
        self._reader.close()
        self._writer.close()


class Client:
    """Calls a service; made by `Node.create_client`."""

    def __init__(
        self,
        *,
        context: Context,
        reader: Reader,
        writer: Writer,
        srv_type: Any,
        srv_name: str,
        name: str,
        callback_group: CallbackGroup | None,
        qos: QoSProfile,
    ):
        self.context = context
        self._reader, self._writer = reader, writer
        self._encode = encoder(srv_type.Request)
        self._decode = decoder(srv_type.Response)
        self._name = name
        self._guid = secrets.randbits(64)
        self._numbers = itertools.count(1)
        self._pending: dict[int, Future] = {}
        self._queue: deque[bytes] = deque()
        self._lock = threading.Lock()
        self._open = True
        self._condition = reader.condition
        self.srv_type = srv_type
        self.srv_name = srv_name
        self.callback_group = callback_group
        self.qos_profile = qos

    def call_async(self, request: Any) -> Future:
        """Send a request; return the future of its response, which comes while the node spins.

        Raises:
            TypeError: the request is of another type, or a field holds a wrong value.
            RCLError: the context was shut down.
            InvalidHandle: the client was destroyed.
        """
        if not isinstance(request, self.srv_type.Request):
            raise TypeError(f"Expected {self.srv_type.Request}, got {type(request)}")
        if not self._open:
            raise InvalidHandle(f"The client of {self._name!r} was destroyed: create another.")
        if not self.context._sends():
            raise RCLError("Failed to send request: client's context is invalid")
        data = self._encode(request)
        future = Future()
        with self._lock:
            number = next(self._numbers)
            self._pending[number] = future
        future.add_done_callback(self.remove_pending_request)
        self._writer.write(wrap(_IDENTITY.pack(self._guid, number), data))
        return future

    def call(self, request: Any, timeout_sec: float | None = None) -> Any:
        """Send a request and wait for its response while another thread spins; None after a timeout in s.

        In a callback of the thread that spins this waits for ever.
        """
        event = threading.Event()
        future = self.call_async(request)
        future.add_done_callback(lambda _: event.set())
        if not event.wait(timeout_sec):
            self.remove_pending_request(future)
        return future.result()

    def _take_work(self) -> Callable[[], Any] | None:
        """Return the completion of the next response to a request of this client."""
        if not self._queue and self._open:
            self._queue.extend(data for data, _ in self._reader.take(_MOST_AT_ONCE))
        while self._queue:
            identity, body = unwrap(self._queue.popleft())
            guid, number = _IDENTITY.unpack(identity)
            if guid != self._guid:
                continue
            with self._lock:
                future = self._pending.get(number)
            if future is not None:
                response = self._decode(body)
                return lambda: future.set_result(response)
        return None

    def _has_backlog(self) -> bool:
        """Return whether responses taken from DDS wait for their completion."""
        return bool(self._queue)

    def get_pending_request(self, sequence_number: int) -> Future:
        """Return the future of a request by its number.

        Raises:
            KeyError: no such request is pending.
        """
        with self._lock:
            return self._pending[sequence_number]

    def remove_pending_request(self, future: Future) -> None:
        """Forget a request; its response will be ignored."""
        with self._lock:
            self._pending = {n: pending for n, pending in self._pending.items() if pending is not future}

    def service_is_ready(self) -> bool:
        """Return whether a server is there for requests and replies."""
        return self._open and self._writer.matched() > 0 and self._reader.matched() > 0

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Wait up to a time in seconds until a server is there; return whether it is."""
        end = float("inf") if timeout_sec is None else time.monotonic() + timeout_sec
        while not self.service_is_ready():
            left = end - time.monotonic()
            if left <= 0 or not self.context.ok():
                return False
            time.sleep(min(0.01, left))
        return True

    @property
    def service_name(self) -> str:
        """Absolute service name, remapping applied."""
        return self._name

    def _gids(self) -> tuple[bytes, bytes]:
        """Return the names of the reader and the writer on the network."""
        return self._reader.gid(), self._writer.gid()

    def destroy(self) -> None:
        """Stop calling; use `Node.destroy_client`."""
        self._open = False
        self._queue.clear()
        self._reader.close()
        self._writer.close()
