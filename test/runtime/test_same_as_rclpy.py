"""One program on both runtimes prints the same lines; runs where ROS 2 Jazzy is sourced."""

from __future__ import annotations

import os
from typing import Any

import pytest
from programs import Run
from ros import PATH, REAL_RCLPY

pytestmark = [
    pytest.mark.ros,
    pytest.mark.skipif(not REAL_RCLPY, reason="rclpy is not importable"),
]

START = """
from seat_gear_dynamics.runtime import provide_rclpy
provide_rclpy()
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

def said(*words):
    print("SAID", *words)
"""


def lines(run: Run, text: str, runtime: str) -> list[str]:
    """Return what a program says on a runtime."""
    path = [""] if runtime == "bundled" else ["", *PATH]
    environment = {"PYTHONPATH": os.pathsep.join([*path, os.environ.get("PYTHONPATH", "")])}
    program = run(START + text, SEAT_GEAR_RUNTIME=runtime, **environment)
    assert program.wait() == 0, "\n".join(program.lines)
    return [line for line in program.lines if line.startswith("SAID")]


LIFECYCLE = """
import itertools
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn as R
rclpy.init(args=[])

class Worker(LifecycleNode):
    plan = {}
    def answer(self, name, state, default):
        if name not in self.plan:
            return default(state)
        if self.plan[name] == "raise":
            raise ValueError
        return getattr(R, self.plan[name])

for name in ("configure", "cleanup", "activate", "deactivate", "shutdown", "error"):
    def callback(self, state, name=name):
        said("  ", name, "from", state.label, state.state_id)
        return self.answer(name, state, getattr(super(Worker, self), "on_" + name))
    setattr(Worker, "on_" + name, callback)

node = Worker("graph")
said(node._state_machine.available_states)
said(node._state_machine.transition_graph)
node.destroy_node()
walks = (
    ("configure", "activate", "deactivate", "cleanup", "configure", "shutdown"),
    ("activate", "configure", "configure", "activate", "activate", "shutdown", "shutdown"),
)
answers = ("SUCCESS", "FAILURE", "ERROR", "raise")
steps = ("configure", "activate", "deactivate", "cleanup", "shutdown")
plans = [{}] + [{step: how} for step in steps for how in answers]
plans += [{"activate": "raise", "error": how} for how in answers]
for number, (plan, walk) in enumerate(itertools.product(plans, walks)):
    node = Worker(f"worker_{number}")
    node.plan = plan
    said(plan)
    for step in walk:
        try:
            result = getattr(node, "trigger_" + step)().name
        except RuntimeError:
            result = "refused"
        said(step, result, node._state_machine.current_state, node._state_machine.available_transitions)
    node.destroy_node()
"""

REMAPPING = """
CASES = [
    [], ["-r", "__ns:=/bench"], ["-r", "__node:=other"], ["-r", "one:__node:=uno"], ["-r", "one:__ns:=/left"],
    ["-r", "one:__ns:=/left", "-r", "two:__ns:=/right"], ["-r", "one:__node:=uno", "-r", "one:__ns:=/left"],
    ["-r", "one:__node:=uno", "-r", "uno:__ns:=/left"], ["-r", "x:=y"], ["-r", "/x:=/y"], ["-r", "one:x:=y"],
    ["-r", "one:x:=~/y"], ["-r", "~/p:=q"], ["-r", "one:~/p:=q"], ["-r", "rostopic://x:=y"],
    ["-r", "rosservice://x:=y"], ["-r", "one:x:=a", "-r", "x:=b"], ["-r", "x:=b", "-r", "one:x:=a"],
    ["-r", "__ns:=/bench", "-r", "x:=/far", "-r", "/bench/s:=t"], ["-r", "a/b:=c", "-r", "one:a/b:=d"],
    ["-p", "k:=1"], ["-p", "one:k:=1", "-p", "two:k:=2"], ["-p", "one:k:=1", "-p", "k:=3"],
    ["-p", "k:=3", "-p", "one:k:=1"],
    ["-r", "one:__node:=uno", "-p", "one:k:=1", "-p", "uno:k:=2"], ["-r", "__ns:=/n", "-p", "one:k:=2"],
]
REFUSED = [["-p", "/n/one:k:=1"], ["-p", "/**:k:=1"], ["-r", "/n/one:x:=y"], ["-p", "one:two:k:=1"], ["-r", "x"]]
for words in CASES + REFUSED:
    context = Context()
    try:
        rclpy.init(args=["program", "--ros-args", *words], context=context)
    except RuntimeError:
        said(words, "refused")
        continue
    nodes = [Node("one", context=context), Node("two", context=context, namespace="inner"),
             Node("three", context=context, cli_args=["--ros-args", "-r", "x:=local"]),
             Node("four", context=context, use_global_arguments=False)]
    for node in nodes:
        topics = [node.resolve_topic_name(name) for name in ("x", "/x", "~/p", "a/b", "s")]
        services = [node.resolve_service_name(name) for name in ("x", "/x", "~/p", "s")]
        value = node.declare_parameter("k", 0).value
        said(words, node.get_fully_qualified_name(), topics, services, value)
    for node in nodes:
        node.destroy_node()
    context.try_shutdown()
"""

TIMERS = """
from rclpy.clock import ClockChange, ClockType, JumpThreshold, ROSClock
from rclpy.duration import Duration
from rclpy.time import Time
rclpy.init(args=[])
node = Node("timers")
executor = SingleThreadedExecutor()
executor.add_node(node)

def tenths(nanoseconds):
    return None if nanoseconds is None else round(nanoseconds / 1e8)

def walk(start, period, steps):
    clock = ROSClock()
    calls = []
    jumps = []
    clock.set_ros_time_override(Time(seconds=start or 0, clock_type=ClockType.ROS_TIME))
    if start is not None:
        clock._set_ros_time_is_active(True)
    threshold = JumpThreshold(min_forward=Duration(seconds=2), min_backward=Duration(seconds=-1), on_clock_change=True)
    handle = clock.create_jump_callback(threshold, pre_callback=lambda: jumps.append("pre"),
        post_callback=lambda jump: jumps.append((int(jump.clock_change), tenths(jump.delta.nanoseconds))))
    timer = node.create_timer(period, lambda: calls.append(None), clock=clock)
    for step in steps:
        if step == "on" or step == "off":
            clock._set_ros_time_is_active(step == "on")
        elif step == "reset" or step == "cancel":
            getattr(timer, step)()
        else:
            clock.set_ros_time_override(Time(seconds=step, clock_type=ClockType.ROS_TIME))
        for _ in range(3):
            executor.spin_once(timeout_sec=0.0)
        if clock.ros_time_is_active and clock.now().nanoseconds:
            try:
                until = timer.time_until_next_call()
            except RuntimeError:
                until = None
            said(start, step, len(calls), timer.is_ready(), tenths(until), tenths(timer.time_since_last_call()), jumps)
    handle.unregister()
    node.destroy_timer(timer)

walk(10, 1.0, [10.5, 11.0, 11.0, 12.5, 20.25, 20.5, 20.0, 20.25, 3.0, 3.5, 4.0, 10.0, 0.0, 0.5, 1.0])
walk(10, 1.0, [11.0, 11.5, "reset", 12.0, 12.5, "cancel", 20.0, "reset", 20.5, 21.0, 5.0, "cancel", 1.0, "reset", 2.0])
walk(None, 2.0, ["on", 5.0, 6.0, 7.0, 7.5, 9.0, "on", 9.5])
walk(None, 2.0, [50.0, "on", 50.5, 51.0, 52.0, 54.0, "off", 80.0, "on", 81.0, 83.0])
walk(0, 1.0, [0.5, 1000.25, 1000.5, 1001.0, "off", "on", 1001.5])
"""

PARAMETERS = """
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, ParameterEvent
from rcl_interfaces.msg import SetParametersResult
rclpy.init(args=[])
node = Node("parameters")
executor = SingleThreadedExecutor()
executor.add_node(node)
events = []

def heard(event):
    if event.node == "/parameters":
        events.append([[p.name for p in group] for group in
            (event.new_parameters, event.changed_parameters, event.deleted_parameters)])

real = FloatingPointRange(from_value=0.5, to_value=2.1, step=0.25)
whole = IntegerRange(from_value=-4, to_value=5, step=2)
backward = FloatingPointRange(from_value=3.0, to_value=-3.0, step=0.0)
node.declare_parameter("real", 1.0, ParameterDescriptor(floating_point_range=[real]))
node.declare_parameter("whole", 2, ParameterDescriptor(integer_range=[whole]))
node.declare_parameter("backward", 0.0, ParameterDescriptor(floating_point_range=[backward]))
node.declare_parameter("fixed", "a", ParameterDescriptor(read_only=True))
node.declare_parameter("any", 1, ParameterDescriptor(dynamic_typing=True))
node.declare_parameter("later", Parameter.Type.DOUBLE)
node.declare_parameter("list", [1.0, 2.0])
node.create_subscription(ParameterEvent, "/parameter_events", heard, 100)

def attempt(*pairs):
    wanted = [Parameter(name, value=value) for name, value in pairs]
    before = {name: p.value for name, p in node._parameters.items()}
    try:
        result = node.set_parameters_atomically(wanted)
        outcome = (result.successful, result.reason)
    except Exception as error:
        outcome = type(error).__name__
    after = {name: p.value for name, p in node._parameters.items()}
    changed = {name: after.get(name) for name in {**before, **after} if before.get(name) != after.get(name)}
    said(pairs, outcome, {name: list(v) if hasattr(v, "tolist") else v for name, v in sorted(changed.items())})

inf, nan = float("inf"), float("nan")
for value in (0.5, 0.75, 0.8, 2.0, 2.1, 2.0000001, 2.2, 0.49, 0.5 - 1e-7, inf, -inf, nan, 1, "1", None):
    attempt(("real", value))
for value in (-4, -2, -3, 4, 5, 6, -5, 1.0, True, None):
    attempt(("whole", value))
for value in (-3.0, 3.0, 3.1, 0.123):
    attempt(("backward", value))
attempt(("fixed", "b"))
attempt(("fixed", "a"))
for value in ("text", 2.5, [1, 2], None):
    attempt(("any", value))
attempt(("any", 1))
attempt(("later", 2.0))
attempt(("later", 2))
attempt(("list", [3.0]), ("real", 1.25))
attempt(("real", 1.5), ("whole", 3))
attempt(("real", 1.5), ("unknown", 3))
attempt(("real", 1.5), ("fixed", "b"))
attempt(("real", 1.5), ("real", 1.75))
attempt()

calls = []
node.add_pre_set_parameters_callback(lambda ps: (calls.append("pre"), [*ps, Parameter("whole", value=0)])[1])
def first(ps):
    calls.append(("first", [p.name for p in ps]))
    return SetParametersResult(successful=True)
def second(ps):
    calls.append(("second", [p.name for p in ps]))
    bad = any(p.name == "real" and p.value > 1.6 for p in ps)
    return SetParametersResult(successful=not bad, reason="too much" if bad else "")
node.add_on_set_parameters_callback(first)
node.add_on_set_parameters_callback(second)
node.add_post_set_parameters_callback(lambda ps: calls.append(("post", [p.name for p in ps])))
attempt(("real", 1.0))
attempt(("real", 1.75))
node.declare_parameter("new", 1)
node.undeclare_parameter("new")
node.remove_on_set_parameters_callback(second)
attempt(("real", 1.75))
said(calls)
attempt(("later", 9.0))
while not events or "later" not in events[-1][1]:
    executor.spin_once(timeout_sec=1.0)
said(events)
for name in ("real", "whole", "fixed", "later", "list"):
    d = node.describe_parameter(name)
    ranges = [(r.from_value, r.to_value, r.step) for r in (*d.floating_point_range, *d.integer_range)]
    said(d.name, d.type, d.read_only, d.dynamic_typing, ranges)
"""


@pytest.mark.parametrize(
    ("text", "least"),
    [
        pytest.param(LIFECYCLE, 500, id="lifecycle"),
        pytest.param(REMAPPING, 100, id="remapping"),
        pytest.param(TIMERS, 30, id="timers"),
        pytest.param(PARAMETERS, 50, id="parameters"),
    ],
)
def test_both_runtimes_say_the_same(run: Run, text: Any, least: int) -> None:
    bundled, real = (lines(run, text, runtime) for runtime in ("bundled", "rclpy"))
    assert bundled == real
    assert len(real) >= least
