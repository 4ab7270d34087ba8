"""Timers that follow a clock, and rates that sleep with them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from seat_gear_dynamics.runtime.clock import Clock, ROSClock
from seat_gear_dynamics.runtime.context import Context, get_default_context
from seat_gear_dynamics.runtime.exceptions import InvalidHandle, ROSInterruptException
from seat_gear_dynamics.runtime.groups import CallbackGroup
from seat_gear_dynamics.runtime.time import ClockType

_NEVER_NS = 2**62


class Timer:
    """Calls a function every period of its clock; periods missed are left out, not made up for."""

    def __init__(
        self,
        callback: Callable[[], Any] | None,
        callback_group: CallbackGroup | None,
        timer_period_ns: int,
        clock: Clock,
        *,
        context: Context | None = None,
        autostart: bool = True,
    ) -> None:
        if timer_period_ns < 0:
            raise ValueError(f"The timer period is {timer_period_ns} ns, expected 0 or more.")
        self._context = get_default_context() if context is None else context
        self._clock = clock
        self._period_ns = int(timer_period_ns)
        self.callback = callback
        self.callback_group = callback_group
        self._last_ns = clock._now_ns()
        self._next_ns = self._last_ns + self._period_ns
        self._canceled = not autostart
        self._destroyed = False
        self._was_active = isinstance(clock, ROSClock) and clock.ros_time_is_active

    @property
    def clock(self) -> Clock:
        """Clock this timer follows."""
        return self._clock

    @property
    def timer_period_ns(self) -> int:
        """Period in nanoseconds; a new one counts from the next call on."""
        return self._period_ns

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        self._period_ns = int(value)

    def _wait_ns(self) -> int:
        """Return how long to wait for the next call in nanoseconds; very long where only /clock can tell."""
        if self._canceled or self._destroyed:
            return _NEVER_NS
        self._follow_clock_source()
        left = self._next_ns - self._clock._now_ns()
        return _NEVER_NS if left > 0 and self._was_active else left

    def _follow_clock_source(self) -> None:
        """Start afresh when simulated time is switched on or off, or jumps back: old times mean nothing."""
        clock = self._clock
        if clock.clock_type is not ClockType.ROS_TIME:
            return
        assert isinstance(clock, ROSClock)
        jumped_back = self._was_active and clock._now_ns() < self._last_ns
        if clock.ros_time_is_active != self._was_active or jumped_back:
            self._was_active = clock.ros_time_is_active
            self._restart()

    def _take_work(self) -> Callable[[], Any] | None:
        """Return the callback if its time has come, and count it as called."""
        if self._wait_ns() > 0 or self.callback is None:
            return None
        now = self._clock._now_ns()
        self._last_ns = now
        self._next_ns += self._period_ns
        if self._next_ns < now:
            missed = 0 if self._period_ns == 0 else 1 + (now - self._next_ns - 1) // self._period_ns
            self._next_ns = now if self._period_ns == 0 else self._next_ns + missed * self._period_ns
        return self.callback

    def is_ready(self) -> bool:
        """Return whether the next call is due."""
        return self._wait_ns() <= 0

    def is_canceled(self) -> bool:
        """Return whether the timer stands still."""
        return self._canceled

    def cancel(self) -> None:
        """Make no more calls until `reset`."""
        self._canceled = True

    def reset(self) -> None:
        """Count a whole period from now; a cancelled timer runs again."""
        self._restart()
        self._canceled = False

    def _restart(self) -> None:
        self._last_ns = self._clock._now_ns()
        self._next_ns = self._last_ns + self._period_ns

    def time_since_last_call(self) -> int:
        """Return the nanoseconds since the last call, or since the start."""
        return self._clock._now_ns() - self._last_ns

    def time_until_next_call(self) -> int | None:
        """Return the nanoseconds to the next call, negative if it is late, None for a cancelled timer."""
        return None if self._canceled else self._next_ns - self._clock._now_ns()

    def destroy(self) -> None:
        """Make no more calls; use `Node.destroy_timer`."""
        self._destroyed = True


class Rate:
    """Sleeps to a fixed rate; another thread must spin."""

    def __init__(self, timer: Timer, *, context: Context) -> None:
        self._timer = timer
        self._event = threading.Event()
        self._ended = ""
        timer.callback = self._event.set
        context.on_shutdown(self._on_shutdown)

    def _on_shutdown(self) -> None:
        self._ended = "shutdown"
        self._event.set()

    def destroy(self) -> None:
        """Wake sleepers; use `Node.destroy_rate`."""
        self._ended = self._ended or "destroyed"
        self._event.set()

    def sleep(self) -> None:
        """Block until the timer's next call.

        Raises:
            ROSInterruptException: the context was shut down.
            RuntimeError, InvalidHandle: the rate or its timer was destroyed.
        """
        if self._timer._destroyed and not self._ended:
            raise InvalidHandle("Rate cannot sleep because the timer has been destroyed")
        if self._ended == "destroyed":
            raise RuntimeError("Rate cannot sleep because it has been destroyed")
        self._event.wait()
        if self._ended == "shutdown":
            raise ROSInterruptException
        self._event.clear()
