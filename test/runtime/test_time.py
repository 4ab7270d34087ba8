"""Times, durations, clocks, timers and simulated time."""

from __future__ import annotations

import threading
import time as wall
from typing import Any

import pytest
from programs import MakeNode, SpinUntil

from seat_gear_dynamics.runtime.clock import Clock, ROSClock
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.parameters.parameter import Parameter
from seat_gear_dynamics.runtime.time import ClockType, Duration, Infinite, Time


def test_arithmetic() -> None:
    start, span = Time(seconds=10, nanoseconds=5), Duration(seconds=1.5)
    assert (start + span).nanoseconds == 11_500_000_005
    assert (start + span) - start == span
    assert (start - span).seconds_nanoseconds() == (8, 500_000_005)
    assert start < start + span
    assert start <= start
    assert Duration(seconds=-1) < Duration()
    assert str(Infinite) == "Infinite"
    with pytest.raises(TypeError, match="different clock types"):
        assert start < Time(clock_type=ClockType.ROS_TIME)
    with pytest.raises(ValueError, match="negative time"):
        _ = Time() - span
    with pytest.raises(OverflowError):
        Time(nanoseconds=2**63)


def test_messages_there_and_back() -> None:
    instant = Time(seconds=3, nanoseconds=7, clock_type=ClockType.ROS_TIME)
    assert Time.from_msg(instant.to_msg()) == instant
    span = Duration(nanoseconds=-1)
    assert (span.to_msg().sec, span.to_msg().nanosec) == (-1, 999_999_999)
    assert Duration.from_msg(span.to_msg()) == span
    with pytest.raises(TypeError, match="Must pass"):
        Time.from_msg(3)


def test_clocks() -> None:
    assert isinstance(Clock(clock_type=ClockType.ROS_TIME), ROSClock)
    assert abs(Clock().now().nanoseconds - wall.time_ns()) < 10**9
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    assert steady.now() <= steady.now()


def test_timer_keeps_its_rate(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node()
    executor.add_node(node)
    calls: list[int] = []
    timer = node.create_timer(0.01, lambda: calls.append(wall.monotonic_ns()))
    begun = wall.monotonic_ns()
    spin_until(lambda: len(calls) >= 20)
    assert wall.monotonic_ns() - begun >= 0.19e9
    timer.cancel()
    assert timer.is_canceled()
    assert timer.time_until_next_call() is None
    count = len(calls)
    executor.spin_once(timeout_sec=0.03)
    assert len(calls) == count
    timer.reset()
    spin_until(lambda: len(calls) > count)
    assert node.destroy_timer(timer)


def test_timer_skips_what_it_missed(make_node: MakeNode) -> None:
    node = make_node()
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    timer = node.create_timer(1.0, lambda: None, clock=clock)
    clock.set_ros_time_override(Time(seconds=5.5, clock_type=ClockType.ROS_TIME))
    assert timer.is_ready()
    assert timer._take_work() is not None
    assert not timer.is_ready()
    assert timer.time_until_next_call() == 500_000_000


def test_timer_without_autostart(make_node: MakeNode) -> None:
    timer = make_node().create_timer(0.0, lambda: None, autostart=False)
    assert not timer.is_ready()
    timer.reset()
    assert timer.is_ready()


def test_simulated_time(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node(parameter_overrides=[Parameter("use_sim_time", value=True)])
    executor.add_node(node)
    clock_message = get_message("rosgraph_msgs/msg/Clock")
    publisher = node.create_publisher(clock_message, "/clock", 10)
    calls: list[int] = []
    node.create_timer(1.0, lambda: calls.append(node.get_clock().now().nanoseconds))

    def set_clock(seconds: float) -> None:
        publisher.publish(clock_message(clock=Time(seconds=seconds).to_msg()))
        spin_until(lambda: node.get_clock().now().nanoseconds == int(seconds * 1e9))

    assert node.get_clock().now().nanoseconds == 0
    for seconds in (0.5, 1.25, 1.5, 2.25):
        set_clock(seconds)
    spin_until(lambda: len(calls) == 2)
    assert calls == [1_250_000_000, 2_250_000_000]
    set_clock(0.5)
    set_clock(1.75)
    spin_until(lambda: len(calls) == 3)
    node.set_parameters([Parameter("use_sim_time", value=False)])
    assert abs(node.get_clock().now().nanoseconds - wall.time_ns()) < 10**9


def test_rate_sleeps_while_another_thread_spins(make_node: MakeNode, executor: Any) -> None:
    node = make_node()
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin)
    rate = node.create_rate(50.0)
    thread.start()
    begun = wall.monotonic()
    for _ in range(3):
        rate.sleep()
    assert wall.monotonic() - begun >= 0.03
    executor.shutdown()
    thread.join(5.0)
    assert not thread.is_alive()


def test_another_thread_wakes_the_executor(make_node: MakeNode, executor: Any) -> None:
    executor.add_node(make_node())
    done = threading.Event()
    thread = threading.Thread(target=lambda: executor.create_task(done.set))
    thread.start()
    while not done.is_set():
        executor.spin_once(timeout_sec=5.0)
    thread.join()


def test_spin_ends_with_the_executor(make_node: MakeNode, executor: Any) -> None:
    node = make_node()
    executor.add_node(node)
    node.create_timer(0.01, executor.shutdown)
    executor.spin()
