"""Run callbacks in one thread: wait for DDS data, timers, tasks and wake-ups, and execute what is ready."""

from __future__ import annotations

import inspect
import threading
import time
from collections import deque
from collections.abc import Callable, Coroutine
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol

from seat_gear_dynamics.runtime.absent import sentence
from seat_gear_dynamics.runtime.context import Context, get_default_context
from seat_gear_dynamics.runtime.exceptions import RCLError
from seat_gear_dynamics.runtime.tasks import Future, Task
from seat_gear_dynamics.runtime.wire.wait import Guard, WaitSet

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.node import Node
    from seat_gear_dynamics.runtime.timer import Timer

SIGNAL_LATENCY_NS = 50_000_000
"""Longest wait in one piece: Python runs signal handlers only between waits."""

_NEVER_NS = 2**62
_WAKE_TOKEN = 1


class ExternalShutdownException(Exception):  # noqa: N818
    """The context was shut down by somebody else, or by a signal, while spinning."""

    def __init__(self) -> None:
        super().__init__("Context has been shutdown externally")


class ShutdownException(Exception):  # noqa: N818
    """The executor was shut down."""


class TimeoutException(Exception):  # noqa: N818
    """A wait timed out."""


class Work(Protocol):
    """Something with a condition to wait on that gives callbacks when it is ready."""

    _condition: int

    def _take_work(self) -> Callable[[], Any] | None:
        """Return the next callback to run, or None."""

    def _has_backlog(self) -> bool:
        """Return whether more callbacks are there without any waiting."""


class Executor:
    """Base of the executors; use SingleThreadedExecutor."""

    def __init__(self, *, context: Context | None = None) -> None:
        self._context = get_default_context() if context is None else context
        self._nodes: dict[Node, None] = {}
        self._lock = threading.RLock()
        self._is_shutdown = False
        self._stale = True
        self._wait_set: WaitSet | None = None
        self._guard: Guard | None = None
        self._tokens: dict[int, Work] = {}
        self._conditions: dict[int, int] = {}
        self._next_token = _WAKE_TOKEN + 1
        self._timers: list[Timer] = []
        self._ready: deque[Any] = deque()
        self._tasks: list[Task] = []
        self._context.on_shutdown(self.wake)

    @property
    def context(self) -> Context:
        """The context whose end stops this executor."""
        return self._context

    def create_task(self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any) -> Task:
        """Have a function or coroutine run while spinning; return its future."""
        task = Task(callback, args, kwargs, executor=self)
        with self._lock:
            self._tasks.append(task)
        self.wake()
        return task

    def add_node(self, node: Node) -> bool:
        """Run a node's callbacks here; return whether that is new."""
        with self._lock:
            if node in self._nodes:
                return False
            self._nodes[node] = None
        node.executor = self
        self._entities_changed()
        return True

    def remove_node(self, node: Node) -> None:
        """Run a node's callbacks here no more."""
        with self._lock:
            if node not in self._nodes:
                return
            del self._nodes[node]
        self._entities_changed()

    def get_nodes(self) -> list[Node]:
        """Return the nodes whose callbacks run here."""
        with self._lock:
            return list(self._nodes)

    def wake(self) -> None:
        """Interrupt a wait, from any thread."""
        guard = self._guard
        if guard is not None:
            guard.trigger()

    def _entities_changed(self) -> None:
        """Note that a node, or something a node owns, came or went."""
        self._stale = True
        self.wake()

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop spinning and forget the nodes; return True."""
        self._is_shutdown = True
        self.wake()
        with self._lock:
            self._nodes.clear()
            self._ready.clear()
        return True

    def spin(self) -> None:
        """Run callbacks until shutdown.

        Raises:
            ExternalShutdownException: the context was shut down by somebody else, or by SIGTERM.
        """
        while self._context.ok() and not self._is_shutdown:
            self.spin_once()

    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run callbacks until a future has its result, or a time in seconds is over."""
        future.add_done_callback(lambda _: self.wake())
        end = None if timeout_sec is None or timeout_sec < 0 else time.monotonic() + timeout_sec
        while self._context.ok() and not future.done() and not self._is_shutdown:
            left = None if end is None else max(0.0, end - time.monotonic())
            self._run_one(left, future.done)
            if end is not None and time.monotonic() >= end:
                return

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback, waiting for it up to a time in seconds (for ever if None or negative).

        Raises:
            ExternalShutdownException: the context was shut down while waiting.
        """
        self._run_one(timeout_sec, None)

    def spin_once_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run one callback unless the future has its result before."""
        future.add_done_callback(lambda _: self.wake())
        self._run_one(timeout_sec, future.done)

    def _run_one(self, timeout_sec: float | None, stop: Callable[[], bool] | None) -> None:
        work = self._next_work(timeout_sec, stop)
        if work is not None:
            self._execute(work)

    def _execute(self, work: Callable[[], Any]) -> None:
        result = work()
        # A callback written as a coroutine gives one: run it to its first pause, go on when there is news.
        if result is not None and inspect.iscoroutine(result):
            task = Task(result, executor=self)
            self._tasks.append(task)
            self._step(task)

    def _step(self, task: Task) -> None:
        task()
        if task.done():
            if task in self._tasks:
                self._tasks.remove(task)
            task.result()

    def _next_work(self, timeout_sec: float | None, stop: Callable[[], bool] | None) -> Callable[[], Any] | None:
        """Return the next callback, or None after the timeout, at shutdown, after a task, or when `stop` says so."""
        forever = timeout_sec is None or timeout_sec < 0
        end_ns = _NEVER_NS if forever else time.monotonic_ns() + int((timeout_sec or 0.0) * 1e9)
        last_round = False
        while not self._is_shutdown and not (stop is not None and stop()):
            while self._ready:
                work = self._ready.popleft()._take_work()
                if work is not None:
                    return work  # type: ignore[no-any-return]
            if last_round:
                return None
            if not self._context.ok():
                raise ExternalShutdownException
            if self._step_tasks():
                return None
            if self._ready:
                continue
            left_ns = end_ns - time.monotonic_ns()
            # The last look is one round without waiting, so that a zero timeout still finds what is there.
            last_round = left_ns <= 0
            self._gather(max(0, left_ns))
        return None

    def _step_tasks(self) -> bool:
        """Let every task go on; return whether one came to its end, which counts as a callback that was run."""
        tasks = tuple(self._tasks)
        for task in tasks:
            self._step(task)
        return any(task.done() for task in tasks)

    def _gather(self, most_ns: int) -> None:
        """Fill the queue of ready work with one round: due timers, then data, waiting if there is neither."""
        if self._stale:
            self._refresh()
        ready = self._ready
        wait_ns = min(most_ns, SIGNAL_LATENCY_NS)
        for timer in self._timers:
            left = timer._wait_ns()
            if left <= 0:
                ready.append(timer)
            elif left < wait_ns:
                wait_ns = left
        backlog = [work for work in self._tokens.values() if work._has_backlog()]
        ready.extend(backlog)
        assert self._wait_set is not None
        try:
            tokens = self._wait_set.wait(0 if ready else wait_ns)
        except RCLError:
            if self._context.ok():
                raise
            raise ExternalShutdownException from None
        if not self._context.ok() and not self._is_shutdown:
            ready.clear()
            raise ExternalShutdownException
        for token in tokens:
            if token == _WAKE_TOKEN:
                assert self._guard is not None
                self._guard.clear()
                continue
            work = self._tokens.get(token)
            if work is not None and work not in backlog:
                ready.append(work)

    def _refresh(self) -> None:
        """Bring the wait set in line with what the nodes own now."""
        self._stale = False
        self._open()
        assert self._wait_set is not None
        wanted: dict[int, Work] = {}
        timers: list[Timer] = []
        for node in self.get_nodes():
            timers.extend(node.timers)
            wanted.update((work._condition, work) for work in node._rt_waitable_work())
        self._timers = timers
        gone = {c: t for c, t in self._conditions.items() if self._tokens[t] is not wanted.get(c)}
        for condition, token in gone.items():
            del self._conditions[condition], self._tokens[token]
            self._wait_set.detach(condition)
        for condition, work in wanted.items():
            if condition not in self._conditions:
                self._wait_set.attach(condition, self._next_token)
                self._conditions[condition] = self._next_token
                self._tokens[self._next_token] = work
                self._next_token += 1

    def _open(self) -> None:
        if self._wait_set is None:
            participant = self._context._participant
            self._wait_set, self._guard = WaitSet(participant), Guard(participant)
            self._wait_set.attach(self._guard.condition, _WAKE_TOKEN)
            self._context._add_guard(self._guard)

    def __enter__(self) -> Executor:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.shutdown()


class SingleThreadedExecutor(Executor):
    """Runs callbacks in the thread that spins."""

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__(context=context)


class MultiThreadedExecutor(Executor):
    """Named so that its absence is said in a sentence."""

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        raise NotImplementedError(
            sentence("rclpy.executors.MultiThreadedExecutor")[:-1] + ", or use SingleThreadedExecutor."
        )
