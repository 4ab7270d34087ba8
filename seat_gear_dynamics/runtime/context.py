"""The context between `init` and `shutdown`: arguments, domain, participant, and who is told of the end."""

from __future__ import annotations

import atexit
import os
import sys
import threading
import weakref
from collections.abc import Callable
from types import MethodType, TracebackType
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime import arguments, logging, security, signals
from seat_gear_dynamics.runtime.exceptions import NotInitializedException, RCLError
from seat_gear_dynamics.runtime.wire.domain import HIGHEST_DOMAIN, domain_id_from

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.graph import Graph
    from seat_gear_dynamics.runtime.wire.participant import Participant
    from seat_gear_dynamics.runtime.wire.wait import Guard

_alive: weakref.WeakSet[Context] = weakref.WeakSet()


class Context:
    """Lifecycle of one initialization; use each object once.

    Its DDS participant comes with the first node and leaves when the context is shut down and its last node
    is destroyed, or at the end of the program.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._callbacks: list[Any] = []
        self._state = "new"
        self._by_signal = False
        self._domain_id = 0
        self._nodes = 0
        self._graph: Graph | None = None
        self._guards: list[Guard] = []
        self._arguments = arguments.Arguments()

    def init(
        self,
        args: list[str] | None = None,
        *,
        initialize_logging: bool = True,
        domain_id: int | None = None,
    ) -> None:
        """Start the context with command line arguments (`sys.argv` without any) and a domain id.

        Raises:
            RuntimeError: it was started before, or an argument or the domain id is wrong.
        """
        with self._lock:
            if self._state != "new":
                raise RuntimeError("Context.init() must only be called once")
            if domain_id is not None and not 0 <= domain_id <= HIGHEST_DOMAIN:
                raise RuntimeError(
                    f"Domain id ({domain_id}) should not be lower than zero or higher than {HIGHEST_DOMAIN}."
                )
            self._domain_id = domain_id_from(os.environ) if domain_id is None else domain_id
            self._arguments = arguments.parse(sys.argv if args is None else args)
            if initialize_logging:
                logging.configure(self._arguments.log_levels, self._arguments.console)
            self._state = "running"
            _alive.add(self)

    def ok(self) -> bool:
        """Return whether the context is started and not shut down."""
        return self._state == "running"

    def _sends(self) -> bool:
        """Return whether messages still go out: a signal lets the callback it comes into finish its work."""
        return self._state == "running" or (self._by_signal and self._graph is not None)

    def get_domain_id(self) -> int:
        """Return the DDS domain id.

        Raises:
            RuntimeError: the context was not started.
        """
        if self._state == "new":
            raise RuntimeError("Context must be initialized before it can have a domain id")
        return self._domain_id

    def shutdown(self) -> None:
        """End the context: spinning stops, and `on_shutdown` callbacks run.

        Raises:
            RuntimeError: it was not started.
            RCLError: it was shut down before, by a signal too; `try_shutdown` accepts that.
        """
        if self._state == "new":
            raise RuntimeError("Context must be initialized before it can be shutdown")
        if self._state == "down":
            self._release()
            raise RCLError("failed to shutdown: rcl_shutdown already called on the given context")
        self._end()

    def try_shutdown(self) -> None:
        """End the context if it is running."""
        if self._state == "running":
            self._end()
        self._release()

    def _end(self) -> None:
        self._invalidate()
        with self._lock:
            callbacks, self._callbacks = self._callbacks, []
        for entry in callbacks:
            callback = entry() if isinstance(entry, weakref.WeakMethod) else entry
            if callback is not None:
                callback()
        self._release()

    def _invalidate(self, by_signal: bool = False) -> None:
        """Mark the context as ended and wake whoever waits; safe in a signal handler."""
        if self._state == "running":
            self._state = "down"
            self._by_signal = by_signal
            for guard in tuple(self._guards):
                guard.trigger()

    def on_shutdown(self, callback: Callable[[], None]) -> None:
        """Have a function called at shutdown, at once if that has happened; methods are held weakly.

        Raises:
            TypeError: it cannot be called.
        """
        if not callable(callback):
            raise TypeError(f"callback should be a callable, got {type(callback)}")
        if self._state == "down":
            callback()
            return
        with self._lock:
            held = weakref.WeakMethod(callback) if isinstance(callback, MethodType) else callback
            self._callbacks.append(held)

    @property
    def _graph_opened(self) -> Graph:
        """This context's view of the ROS graph, opened when first used.

        Raises:
            NotInitializedException: the context is not running.
            RCLError: security is enforced, which this runtime does not have, or DDS refuses.
        """
        from seat_gear_dynamics.runtime.graph import Graph
        from seat_gear_dynamics.runtime.wire.participant import Participant

        with self._lock:
            if self._graph is None:
                if not self.ok():
                    raise NotInitializedException("the context is not running")
                if (warning := security.insecurity(os.environ)) is not None:
                    logging.get_logger("rclpy").warning(warning)
                self._graph = Graph(Participant(self._domain_id))
            return self._graph

    @property
    def _graph_if_open(self) -> Graph | None:
        """This context's view of the graph unless it was not opened, or is closed."""
        return self._graph

    @property
    def _participant(self) -> Participant:
        """The DDS participant of this context."""
        return self._graph_opened.participant

    def _add_guard(self, guard: Guard) -> None:
        """Trigger a condition too when the context ends."""
        self._guards.append(guard)

    def _node_created(self) -> None:
        """Count a node."""
        with self._lock:
            self._nodes += 1

    def _node_destroyed(self) -> None:
        """Count a node down; after shutdown the last one takes the participant with it."""
        with self._lock:
            self._nodes -= 1
        self._release()

    def _release(self) -> None:
        with self._lock:
            if self._state == "down" and self._nodes <= 0:
                self.destroy()

    def destroy(self) -> None:
        """Leave the DDS domain."""
        with self._lock:
            graph, self._graph = self._graph, None
            self._guards.clear()
        if graph is not None:
            graph.close()

    def __enter__(self) -> Context:
        self.init()
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.try_shutdown()


_default: Context | None = None
_default_lock = threading.Lock()


def get_default_context(*, shutting_down: bool = False) -> Context:
    """Return the context used where none is given; `shutting_down` makes the next call return a new one."""
    global _default
    with _default_lock:
        context = _default or Context()
        _default = None if shutting_down else context
        return context


def ok(*, context: Context | None = None) -> bool:
    """Return whether a context (the default one) is started and not shut down."""
    return (context or get_default_context()).ok()


def shutdown_context(*, context: Context | None = None) -> None:
    """Shut a context (the default one) down; see `Context.shutdown`."""
    (context or get_default_context(shutting_down=True)).shutdown()


def try_shutdown(*, context: Context | None = None) -> None:
    """Shut a context (the default one) down if it is running."""
    global _default
    if context is not None:
        context.try_shutdown()
        return
    with _default_lock:
        old = _default
    if old is not None:
        old.try_shutdown()
        with _default_lock:
            if _default is old and not old.ok():
                _default = None


def _invalidate_all() -> None:
    for context in tuple(_alive):
        context._invalidate(by_signal=True)


def _leave_all() -> None:
    """Leave the graph at the end of the program, so that others see it at once."""
    for context in tuple(_alive):
        context._invalidate()
        context.destroy()


signals.on_signal(_invalidate_all)
atexit.register(_leave_all)
