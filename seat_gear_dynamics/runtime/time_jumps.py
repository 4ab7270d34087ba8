"""Jumps of a clock: what they are, and who is told of them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from enum import IntEnum
from types import TracebackType
from typing import Protocol

from seat_gear_dynamics.runtime.time import Duration


class ClockChange(IntEnum):
    """Whether a clock changed its source when it jumped, numbered as in rcl."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


class JumpThreshold:
    """Which jumps are worth a call: forward or backward by so much or more, or a change of the source."""

    def __init__(
        self, *, min_forward: Duration | None, min_backward: Duration | None, on_clock_change: bool = True
    ) -> None:
        if min_forward is not None and min_forward.nanoseconds <= 0:
            raise ValueError(f"min_forward must be a positive non-zero duration, it is {min_forward}")
        if min_backward is not None and min_backward.nanoseconds >= 0:
            raise ValueError(f"min_backward must be a negative non-zero duration, it is {min_backward}")
        if min_forward is None and min_backward is None and not on_clock_change:
            raise ValueError("At least one jump threshold must be enabled")
        self.min_forward = min_forward
        self.min_backward = min_backward
        self.on_clock_change = on_clock_change

    def _exceeded(self, jump: TimeJump) -> bool:
        """Return whether a jump is worth a call."""
        if jump.clock_change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            return self.on_clock_change
        forward, backward = self.min_forward, self.min_backward
        return (forward is not None and jump.delta >= forward) or (backward is not None and jump.delta <= backward)


class TimeJump:
    """One jump: whether the source changed, and by how much the time did where it did not."""

    def __init__(self, clock_change: ClockChange, delta: Duration) -> None:
        if not isinstance(clock_change, ClockChange):
            raise TypeError(f"clock_change must be an instance of rclpy.clock.ClockChange, it is {clock_change!r}")
        self._clock_change = clock_change
        self._delta = delta

    def __repr__(self) -> str:
        return f"TimeJump({self._clock_change.name}, {self._delta!r})"

    @property
    def clock_change(self) -> ClockChange:
        """Whether the source changed."""
        return self._clock_change

    @property
    def delta(self) -> Duration:
        """New time less old time; zero where the source changed."""
        return self._delta


class JumpListener(Protocol):
    """Somebody a clock tells of its jumps."""

    _threshold: JumpThreshold

    def _before_jump(self, jump: TimeJump) -> None:
        """Be told before the clock shows the new time."""

    def _after_jump(self, jump: TimeJump) -> None:
        """Be told when the clock shows the new time."""


class JumpListeners:
    """Those a clock tells of its jumps, in the order they came."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._listeners: list[JumpListener] = []

    def add(self, listener: JumpListener) -> None:
        """Tell a listener from now on."""
        with self._lock:
            self._listeners.append(listener)

    def remove(self, listener: JumpListener) -> None:
        """Tell a listener no more; one that is not there is no fault."""
        with self._lock:
            self._listeners = [other for other in self._listeners if other is not listener]

    def announce(self, jump: TimeJump, make: Callable[[], None]) -> None:
        """Tell those concerned, make the jump, and tell them again.

        The jump is made even if a callback raises; those after it are not told, and its error comes when all is done,
        as in rclpy.
        """
        with self._lock:
            concerned = [listener for listener in self._listeners if listener._threshold._exceeded(jump)]
        error: Exception | None = None
        for listener in concerned:
            error = error or _error_of(listener._before_jump, jump)
        make()
        for listener in concerned:
            error = error or _error_of(listener._after_jump, jump)
        if error is not None:
            raise error


def _error_of(tell: Callable[[TimeJump], None], jump: TimeJump) -> Exception | None:
    try:
        tell(jump)
    except Exception as error:
        return error
    return None


class JumpHandle:
    """Two functions a clock calls at its jumps, until `unregister` or the end of a `with`."""

    def __init__(
        self,
        *,
        clock: _HasListeners,
        threshold: JumpThreshold,
        pre_callback: Callable[[], None] | None,
        post_callback: Callable[[TimeJump], None] | None,
    ) -> None:
        if pre_callback is None and post_callback is None:
            raise ValueError("One of pre_callback or post_callback must be callable")
        for name, callback in (("pre_callback", pre_callback), ("post_callback", post_callback)):
            if callback is not None and not callable(callback):
                raise ValueError(f"{name} must be callable if given, it is {callback!r}")
        self._clock: _HasListeners | None = clock
        self._threshold = threshold
        self._pre_callback = pre_callback
        self._post_callback = post_callback
        clock._listeners.add(self)

    def _before_jump(self, jump: TimeJump) -> None:
        if self._pre_callback is not None:
            self._pre_callback()

    def _after_jump(self, jump: TimeJump) -> None:
        if self._post_callback is not None:
            self._post_callback(jump)

    def unregister(self) -> None:
        """Make no more calls; doing it again does nothing."""
        if self._clock is not None:
            self._clock._listeners.remove(self)
            self._clock = None

    def __enter__(self) -> JumpHandle:
        return self

    def __exit__(
        self,
        t: type[BaseException] | None,
        v: BaseException | None,
        tb: TracebackType | None,
    ) -> None:
        self.unregister()


class _HasListeners(Protocol):
    _listeners: JumpListeners
