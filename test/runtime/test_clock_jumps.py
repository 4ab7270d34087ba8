"""Jumps of a clock: who is told, what timers and sleepers do, and simulated time that stands still or goes back."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from programs import PATIENCE, MakeNode, SpinUntil

from seat_gear_dynamics.runtime.clock import Clock, ROSClock
from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.parameters.parameter import Parameter
from seat_gear_dynamics.runtime.time import ClockType, Duration, Time
from seat_gear_dynamics.runtime.time_jumps import ClockChange, JumpThreshold, TimeJump
from seat_gear_dynamics.runtime.timer import Timer

SECOND = 10**9
ClockMessage = get_message("rosgraph_msgs/msg/Clock")


@pytest.fixture
def clock() -> ROSClock:
    """A clock that shows 10 s of simulated time."""
    made = ROSClock()
    made.set_ros_time_override(at(10.0))
    made._set_ros_time_is_active(True)
    return made


def unwanted(jump: TimeJump) -> None:
    pytest.fail(f"nobody should be told of {jump}")


def at(seconds: float) -> Time:
    return Time(nanoseconds=int(seconds * SECOND), clock_type=ClockType.ROS_TIME)


def threshold(forward: float | None = None, backward: float | None = None, change: bool = False) -> JumpThreshold:
    return JumpThreshold(
        min_forward=None if forward is None else Duration(seconds=forward),
        min_backward=None if backward is None else Duration(seconds=backward),
        on_clock_change=change,
    )


# Who is told ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("limits", "seconds", "told"),
    [
        (threshold(forward=2.0), 12.0, True),
        (threshold(forward=2.0), 11.9, False),
        (threshold(forward=2.0), 5.0, False),
        (threshold(backward=-2.0), 8.0, True),
        (threshold(backward=-2.0), 8.1, False),
        (threshold(backward=-2.0), 20.0, False),
        (threshold(change=True), 20.0, False),
        (threshold(forward=1e-9, backward=-1e-9), 10.0, False),
    ],
)
def test_thresholds(clock: ROSClock, limits: JumpThreshold, seconds: float, told: bool) -> None:
    jumps: list[TimeJump] = []
    clock.create_jump_callback(limits, post_callback=jumps.append)
    clock.set_ros_time_override(at(seconds))
    assert bool(jumps) is told
    if told:
        assert jumps[0].clock_change is ClockChange.ROS_TIME_NO_CHANGE
        assert jumps[0].delta == at(seconds) - at(10.0)


def test_before_and_after_the_new_time(clock: ROSClock) -> None:
    seen: list[tuple[str, float]] = []

    def tell(what: str) -> None:
        seen.append((what, clock.now().nanoseconds / SECOND))

    handle = clock.create_jump_callback(
        threshold(forward=1.0), pre_callback=lambda: tell("before"), post_callback=lambda _: tell("after")
    )
    clock.set_ros_time_override(at(12.0))
    handle.unregister()
    handle.unregister()
    clock.set_ros_time_override(at(20.0))
    assert seen == [("before", 10.0), ("after", 12.0)]


def test_switching_simulated_time(clock: ROSClock) -> None:
    jumps: list[TimeJump] = []
    with clock.create_jump_callback(threshold(change=True), post_callback=jumps.append):
        for enabled in (True, False, False, True):
            clock._set_ros_time_is_active(enabled)
    clock._set_ros_time_is_active(False)
    assert [jump.clock_change.name for jump in jumps] == ["ROS_TIME_DEACTIVATED", "ROS_TIME_ACTIVATED"]
    assert [jump.delta.nanoseconds for jump in jumps] == [0, 0]


def test_time_set_while_switched_off_is_no_jump(clock: ROSClock) -> None:
    clock._set_ros_time_is_active(False)
    clock.create_jump_callback(threshold(forward=1.0), post_callback=unwanted)
    clock.set_ros_time_override(at(1000.0))


def test_a_callback_that_raises_does_not_stop_the_clock(clock: ROSClock) -> None:
    def fail(_: TimeJump) -> None:
        raise ValueError("mine")

    clock.create_jump_callback(threshold(forward=1.0), post_callback=fail)
    clock.create_jump_callback(threshold(forward=1.0), post_callback=unwanted)
    with pytest.raises(ValueError, match="mine"):
        clock.set_ros_time_override(at(12.0))
    assert clock.now() == at(12.0)


def test_wrong_thresholds_and_callbacks_are_refused() -> None:
    for forward, backward in ((0.0, None), (-1.0, None), (None, 0.0), (None, 1.0), (None, None)):
        with pytest.raises(ValueError, match=r"non-zero duration|At least one"):
            threshold(forward, backward)
    with pytest.raises(ValueError, match="One of pre_callback or post_callback"):
        Clock().create_jump_callback(threshold(change=True))
    with pytest.raises(ValueError, match="post_callback must be callable"):
        Clock().create_jump_callback(threshold(change=True), post_callback="x")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="ClockChange"):
        TimeJump(2, Duration())  # type: ignore[arg-type]


# Timers ---------------------------------------------------------------------------------------------------------------


def timer_on(clock: Clock, context: Context, period: float = 1.0) -> Timer:
    return Timer(lambda: None, None, int(period * SECOND), clock, context=context)


def call(timer: Timer) -> bool:
    return timer._take_work() is not None


def test_a_timer_starts_afresh_after_a_jump_back(clock: ROSClock, context: Context) -> None:
    timer = timer_on(clock, context)
    clock.set_ros_time_override(at(11.0))
    assert call(timer)
    clock.set_ros_time_override(at(3.0))
    assert timer.time_until_next_call() == SECOND
    assert timer.time_since_last_call() == 0
    clock.set_ros_time_override(at(3.9))
    assert not timer.is_ready()
    clock.set_ros_time_override(at(4.0))
    assert call(timer)


def test_a_jump_back_and_forth_between_looks_is_seen(clock: ROSClock, context: Context) -> None:
    timer = timer_on(clock, context)
    clock.set_ros_time_override(at(3.0))
    clock.set_ros_time_override(at(10.5))
    # Started afresh at 3 s, it has been due since 4 s.
    assert call(timer)
    assert timer.time_until_next_call() == SECOND // 2


def test_a_small_jump_back_within_the_period_only_delays(clock: ROSClock, context: Context) -> None:
    timer = timer_on(clock, context)
    clock.set_ros_time_override(at(10.8))
    clock.set_ros_time_override(at(10.2))
    assert timer.time_until_next_call() == int(0.8 * SECOND)


def test_a_jump_forward_makes_one_call(clock: ROSClock, context: Context) -> None:
    timer = timer_on(clock, context)
    clock.set_ros_time_override(at(15.0))
    assert call(timer)
    assert not call(timer)
    # The call at 15 s, on the period, was the one for it: the next is a whole period away.
    assert timer.time_until_next_call() == SECOND


def test_a_timer_of_real_time_gets_a_period_once_simulated_time_begins(context: Context) -> None:
    clock = ROSClock()
    timer = timer_on(clock, context)
    clock._set_ros_time_is_active(True)
    assert not timer.is_ready()
    clock.set_ros_time_override(at(5.0))
    assert timer.time_until_next_call() == SECOND


def test_a_destroyed_timer_hears_no_more(clock: ROSClock, context: Context) -> None:
    timer = timer_on(clock, context)
    timer.destroy()
    assert clock._listeners._listeners == []
    clock.set_ros_time_override(at(100.0))
    assert not timer.is_ready()


# Simulated time over /clock -------------------------------------------------------------------------------------------


@pytest.fixture
def simulated(make_node: MakeNode, executor: Any) -> Node:
    node = make_node(parameter_overrides=[Parameter("use_sim_time", value=True)])
    executor.add_node(node)
    return node


def test_a_paused_simulation_holds_timers_and_its_restart_is_told(simulated: Node, spin_until: SpinUntil) -> None:
    publisher = simulated.create_publisher(ClockMessage, "/clock", 10)
    calls: list[float] = []
    steady: list[None] = []
    jumps: list[TimeJump] = []

    def show(seconds: float) -> None:
        publisher.publish(ClockMessage(clock=at(seconds).to_msg()))
        spin_until(lambda: simulated.get_clock().now() == at(seconds))

    show(5.0)
    simulated.create_timer(1.0, lambda: calls.append(simulated.get_clock().now().nanoseconds / SECOND))
    simulated.create_timer(0.01, lambda: steady.append(None), clock=Clock(clock_type=ClockType.STEADY_TIME))
    simulated.get_clock().create_jump_callback(threshold(backward=-1e-9), post_callback=jumps.append)
    show(6.0)
    spin_until(lambda: calls == [6.0])
    # Paused: the same time comes again and again while real time, here ten periods of a steady timer, goes on.
    begun = len(steady)
    spin_until(lambda: len(steady) >= begun + 10)
    show(6.0)
    assert calls == [6.0]
    assert jumps == []
    show(0.25)
    assert [jump.delta.nanoseconds for jump in jumps] == [int(-5.75 * SECOND)]
    show(1.25)
    spin_until(lambda: calls == [6.0, 1.25])


def test_a_timer_of_another_nodes_clock_is_woken(simulated: Node, make_node: MakeNode, spin_until: SpinUntil) -> None:
    other = make_node("other")
    fired = threading.Event()
    other.create_timer(1.0, fired.set, clock=simulated.get_clock())
    from seat_gear_dynamics.runtime.executor import SingleThreadedExecutor

    with SingleThreadedExecutor(context=other.context) as elsewhere:
        elsewhere.add_node(other)
        thread = threading.Thread(target=elsewhere.spin)
        thread.start()
        simulated.get_clock().set_ros_time_override(at(2.0))
        assert fired.wait(PATIENCE)
        elsewhere.shutdown()
        thread.join(PATIENCE)
        assert not thread.is_alive()


@pytest.mark.parametrize(("switch", "reached"), [(False, True), (True, False)])
def test_sleep_ends_at_its_time_or_when_the_source_changes(
    clock: ROSClock, context: Context, switch: bool, reached: bool
) -> None:
    results: list[bool] = []
    thread = threading.Thread(target=lambda: results.append(clock.sleep_until(at(11.0), context)))
    thread.start()
    while not clock._listeners._listeners:
        # The sleeper has not begun; it registers for jumps first.
        thread.join(0.001)
    if switch:
        clock._set_ros_time_is_active(False)
    else:
        clock.set_ros_time_override(at(11.0))
    thread.join(PATIENCE)
    assert results == [reached]
    assert clock._listeners._listeners == []
