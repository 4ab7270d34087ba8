"""Timers that follow a clock, and rates that sleep with them."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable
from typing import Any

from seat_gear_dynamics.runtime.clock import Clock, ROSClock
from seat_gear_dynamics.runtime.context import Context, get_default_context
from seat_gear_dynamics.runtime.exceptions import InvalidHandle, ROSInterruptException
from seat_gear_dynamics.runtime.groups import CallbackGroup
from seat_gear_dynamics.runtime.time import Duration
from seat_gear_dynamics.runtime.time_jumps import ClockChange, JumpThreshold, TimeJump

_NEVER_NS = 2**62
_SOURCE_CHANGES = (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED)
_EVERY_JUMP = JumpThreshold(min_forward=Duration(nanoseconds=1), min_backward=Duration(nanoseconds=-1))


class Timer:
    """Calls a function every period of its clock; periods missed are left out, not made up for.

    Its clock may jump, or change its source; what the timer then does is what rcl's timers do (rcl/src/rcl/timer.c).
    """

    _threshold = _EVERY_JUMP

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
        self._credit_ns = 0
        self._waker: weakref.WeakMethod[Callable[[], None]] | None = None
        self._ros_clock = clock if isinstance(clock, ROSClock) else None
        if self._ros_clock is not None:
            clock._listeners.add(self)

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
        left = self._next_ns - self._clock._now_ns()
        simulated = self._ros_clock is not None and self._ros_clock._active
        return _NEVER_NS if left > 0 and simulated else left

    def _before_jump(self, jump: TimeJump) -> None:
        """Keep what is left of the period where the source of time changes."""
        now = self._clock._now_ns()
        if jump.clock_change in _SOURCE_CHANGES and now != 0:
            self._credit_ns = self._next_ns - now

    def _after_jump(self, jump: TimeJump) -> None:
        """Take the times of the next and the last call over into the new time."""
        now = self._clock._now_ns()
        if jump.clock_change in _SOURCE_CHANGES:
            # At zero the new source has not told the time yet: its first message is a jump of its own.
            if now != 0 and self._credit_ns:
                self._last_ns = now - self._credit_ns
                self._next_ns = self._last_ns + self._period_ns
                self._credit_ns = 0
        elif self._next_ns <= now:
            self._wake()
        elif now < self._last_ns:
            self._last_ns, self._next_ns = now, now + self._period_ns

    def _wake(self) -> None:
        """Wake whoever waits for this timer."""
        wake = self._waker() if self._waker is not None else None
        if wake is not None:
            wake()

    def _take_work(self) -> Callable[[], Any] | None:
        """Return the callback if its time has come, and count it as called."""
        if self._wait_ns() > 0 or self.callback is None:
            return None
        now = self._clock._now_ns()
        self._last_ns = now
        self._next_ns += self._period_ns
        if self._next_ns <= now:
            missed = 0 if self._period_ns == 0 else 1 + (now - self._next_ns) // self._period_ns
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
        self._next_ns = self._clock._now_ns() + self._period_ns
        self._canceled = False
        self._wake()

    def time_since_last_call(self) -> int:
        """Return the nanoseconds since the last call, or since the start."""
        return self._clock._now_ns() - self._last_ns

    def time_until_next_call(self) -> int | None:
        """Return the nanoseconds to the next call, negative if it is late, None for a cancelled timer."""
        return None if self._canceled else self._next_ns - self._clock._now_ns()

    def destroy(self) -> None:
        """Make no more calls; use `Node.destroy_timer`."""
        self._destroyed = True
        self._clock._listeners.remove(self)


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
