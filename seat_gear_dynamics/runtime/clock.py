"""Clocks: system, steady, and ROS time, which follows /clock when simulated time is on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from seat_gear_dynamics.runtime.absent import sentence
from seat_gear_dynamics.runtime.context import Context, get_default_context
from seat_gear_dynamics.runtime.exceptions import NotInitializedException
from seat_gear_dynamics.runtime.time import ClockType, Duration, Time
from seat_gear_dynamics.runtime.time_jumps import ClockChange, JumpHandle, JumpListeners, JumpThreshold, TimeJump


class Clock:
    """A source of time of one kind; `Clock(clock_type=ClockType.ROS_TIME)` is a ROSClock."""

    _clock_type: ClockType
    _listeners: JumpListeners

    def __new__(cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> Clock:
        """Make a clock of a kind."""
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        made = super().__new__(ROSClock if clock_type is ClockType.ROS_TIME else cls)
        made._clock_type = clock_type
        made._listeners = JumpListeners()
        if isinstance(made, ROSClock):
            made._override_ns = 0
            made._active = False
            made._changed = threading.Condition()
        return made

    @property
    def clock_type(self) -> ClockType:
        """Kind of this clock."""
        return self._clock_type

    def __repr__(self) -> str:
        return f"Clock(clock_type={self._clock_type.name})"

    def now(self) -> Time:
        """Return the time now."""
        return Time(nanoseconds=self._now_ns(), clock_type=self._clock_type)

    def _now_ns(self) -> int:
        """Return the time now in nanoseconds."""
        return time.monotonic_ns() if self._clock_type is ClockType.STEADY_TIME else time.time_ns()

    def create_jump_callback(
        self,
        threshold: JumpThreshold,
        *,
        pre_callback: Callable[[], None] | None = None,
        post_callback: Callable[[TimeJump], None] | None = None,
    ) -> JumpHandle:
        """Have functions called before and after this clock jumps by more than a threshold; keep the handle.

        Only ROS time jumps: when `use_sim_time` is switched, and with every message on /clock while it is on. The
        functions run in the thread that sets the clock and should be quick.

        Raises:
            ValueError: neither function is given, or one cannot be called.
        """
        return JumpHandle(clock=self, threshold=threshold, pre_callback=pre_callback, post_callback=post_callback)

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Sleep until a time of this clock; return whether it was reached.

        It is not where the context is shut down, or where simulated time is switched on or off meanwhile.

        Raises:
            ValueError: `until` is of another kind of clock.
            NotInitializedException: the context is not initialized, or shut down.
        """
        context = get_default_context() if context is None else context
        if not context.ok():
            raise NotInitializedException
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        changes: list[TimeJump] = []
        threshold = JumpThreshold(min_forward=None, min_backward=None, on_clock_change=True)
        with self.create_jump_callback(threshold, post_callback=changes.append):
            while context.ok() and not changes:
                left = until.nanoseconds - self._now_ns()
                if left <= 0:
                    return True
                self._pause(min(left / 1e9, 0.05))
        return False

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Sleep for a duration of this clock; see `sleep_until`."""
        return self.sleep_until(self.now() + rel_time, context)

    def _pause(self, seconds: float) -> None:
        time.sleep(seconds)

    def __getattr__(self, name: str) -> Any:
        if name == "handle":
            raise AttributeError(sentence(f"rclpy.clock.Clock.{name}"))
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")


class ROSClock(Clock):
    """ROS time: system time, or the time of /clock while `ros_time_is_active`."""

    _override_ns: int
    _active: bool
    _changed: threading.Condition

    def __new__(cls) -> ROSClock:
        """Make a ROS clock that follows system time."""
        made = Clock.__new__(cls, clock_type=ClockType.ROS_TIME)
        assert isinstance(made, ROSClock)
        return made

    @property
    def ros_time_is_active(self) -> bool:
        """Whether this clock follows /clock."""
        return self._active

    def _set_ros_time_is_active(self, enabled: bool) -> None:
        def switch() -> None:
            with self._changed:
                self._active = enabled
                self._changed.notify_all()

        if enabled != self._active:
            change = ClockChange.ROS_TIME_ACTIVATED if enabled else ClockChange.ROS_TIME_DEACTIVATED
            self._listeners.announce(TimeJump(change, Duration()), switch)

    def set_ros_time_override(self, time: Time) -> None:
        """Set the time this clock shows while ROS time is active.

        Raises:
            TypeError: `time` is not a time of ROS_TIME.
        """
        if not isinstance(time, Time) or time.clock_type is not ClockType.ROS_TIME:
            raise TypeError("Time must be specified as rclpy.time.Time of clock type ROS_TIME")

        def put() -> None:
            with self._changed:
                self._override_ns = time.nanoseconds
                self._changed.notify_all()

        if self._active:
            delta = Duration(nanoseconds=time.nanoseconds - self._override_ns)
            self._listeners.announce(TimeJump(ClockChange.ROS_TIME_NO_CHANGE, delta), put)
        else:
            put()

    def _now_ns(self) -> int:
        """Return the time now in nanoseconds; 0 while simulated time is on and no /clock came yet."""
        return self._override_ns if self._active else time.time_ns()

    def _pause(self, seconds: float) -> None:
        with self._changed:
            self._changed.wait(seconds if not self._active else 0.05)
