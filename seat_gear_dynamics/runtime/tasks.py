"""Futures and tasks: results that come later, and callbacks or coroutines the executor runs."""

from __future__ import annotations

import inspect
import threading
import warnings
import weakref
from collections.abc import Callable, Generator
from typing import Any


class Future:
    """A result that comes later; with an executor its done callbacks run there."""

    def __init__(self, *, executor: Any = None) -> None:
        self._done = False
        self._cancelled = False
        self._result: Any = None
        self._exception: BaseException | None = None
        self._callbacks: list[Callable[[Any], Any]] = []
        self._lock = threading.Lock()
        self._executor: Callable[[], Any] = weakref.ref(executor) if executor is not None else lambda: None

    def __await__(self) -> Generator[None, None, Any]:
        while not self._done:
            yield
        return self.result()

    def cancel(self) -> None:
        """Request cancellation if the result has not come."""
        with self._lock:
            if not self._done:
                self._cancelled = True
        self._run_callbacks()

    def cancelled(self) -> bool:
        """Return whether it was cancelled."""
        return self._cancelled

    def done(self) -> bool:
        """Return whether the result, or an exception instead of it, has come."""
        return self._done

    def result(self) -> Any:
        """Return the result, None before it has come; raises the exception that came instead of it."""
        if self._exception is not None:
            raise self._exception
        return self._result

    def exception(self) -> BaseException | None:
        """Return the exception that came instead of a result."""
        return self._exception

    def set_result(self, result: Any) -> None:
        """Give the result."""
        self._finish(result, None)

    def set_exception(self, exception: BaseException) -> None:
        """Give an exception instead of a result."""
        self._finish(None, exception)

    def _finish(self, result: Any, exception: BaseException | None) -> None:
        with self._lock:
            self._result, self._exception = result, exception
            self._done, self._cancelled = True, False
        self._run_callbacks()

    def _run_callbacks(self) -> None:
        with self._lock:
            callbacks, self._callbacks = self._callbacks, []
        executor = self._executor()
        for callback in callbacks:
            if executor is not None:
                executor.create_task(callback, self)
                continue
            try:
                callback(self)
            except Exception as error:
                # The callbacks after this one must run too.
                warnings.warn(f"Unhandled exception in done callback: {error}", stacklevel=2)

    def add_done_callback(self, callback: Callable[[Any], Any]) -> None:
        """Have a function called with this future when the result comes, at once if it has."""
        with self._lock:
            if not self._done:
                self._callbacks.append(callback)
                return
        executor = self._executor()
        if executor is not None:
            executor.create_task(callback, self)
        else:
            callback(self)


class Task(Future):
    """A function or coroutine an executor runs; a coroutine continues whenever the executor has news."""

    def __init__(
        self,
        handler: Any,
        args: list[Any] | tuple[Any, ...] | None = None,
        kwargs: dict[str, Any] | None = None,
        executor: Any = None,
    ) -> None:
        super().__init__(executor=executor)
        if inspect.iscoroutinefunction(handler):
            handler = handler(*(args or ()), **(kwargs or {}))
        self._handler = handler
        self._args, self._kwargs = args or (), kwargs or {}
        self._executing = False

    def __call__(self) -> None:
        """Run the function, or the coroutine up to its next pause; errors become the task's exception."""
        if self._done or self._executing:
            return
        self._executing = True
        try:
            if inspect.iscoroutine(self._handler):
                self._resume()
            else:
                self.set_result(self._handler(*self._args, **self._kwargs))
        except Exception as error:
            self.set_exception(error)
        finally:
            self._executing = False

    def _resume(self) -> None:
        try:
            self._handler.send(None)
        except StopIteration as finished:
            self.set_result(finished.value)

    def executing(self) -> bool:
        """Return whether it runs at this moment."""
        return self._executing
