"""Several nodes in one program: one executor, names and parameters of each from one command line."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from programs import PREAMBLE, MakeNode, Run, SpinUntil

from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.lifecycle.node import LifecycleNode
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.parameters.parameter import Parameter

Float64 = get_message("std_msgs/msg/Float64")

# A tiny monitor: doubles what it hears, with a gain of its own, and can be reset by name.
MONITORS = (
    PREAMBLE
    + """
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from std_srvs.srv import Trigger

class Monitor(LifecycleNode):
    def __init__(self, name, **options):
        super().__init__(name, **options)
        self.gain = self.declare_parameter("gain", 2.0)
        self.output = self.create_lifecycle_publisher(Float64, "~/force", 10)
        self.create_subscription(Float64, "motor/speed", self.hear, 10)

    def hear(self, message):
        self.output.publish(Float64(data=message.data * self.get_parameter("gain").value))

rclpy.init()
monitors = [Monitor("gear_monitor", namespace="left"), Monitor("gear_monitor", namespace="right"), Monitor("third")]
executor = SingleThreadedExecutor()
for monitor in monitors:
    executor.add_node(monitor)
    monitor.trigger_configure()
    monitor.trigger_activate()
print("up", *[monitor.get_fully_qualified_name() for monitor in monitors])
try:
    executor.spin()
except (KeyboardInterrupt, ExternalShutdownException):
    pass
for monitor in monitors:
    monitor.destroy_node()
rclpy.try_shutdown()
print("clean")
"""
)


PARAMETERS = """
/bench/odd: {ros__parameters: {gain: 10.0}}
/*/gear_monitor: {ros__parameters: {gain: 3.0}}
/right/gear_monitor: {ros__parameters: {gain: 5.0}}
"""


def test_monitors_side_by_side(
    run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil, tmp_path: Path
) -> None:
    path = tmp_path / "parameters.yaml"
    path.write_text(PARAMETERS)
    bench = make_node("bench")
    executor.add_node(bench)
    got: dict[str, list[float]] = {"/left/gear_monitor": [], "/right/gear_monitor": [], "/bench/odd": []}
    for name, values in got.items():
        bench.create_subscription(Float64, f"{name}/force", lambda m, values=values: values.append(m.data), 10)
    publishers = {
        topic: bench.create_publisher(Float64, topic, 10)
        for topic in ("/left/motor/speed", "/right/motor/speed", "/spindle")
    }
    program = run(
        MONITORS,
        *("--ros-args", "-r", "third:__node:=odd", "-r", "odd:__ns:=/bench", "-r", "odd:motor/speed:=/spindle"),
        # On a command line NODE:NAME:=VALUE names a node without a namespace, in ROS as here; a file names any.
        *("-p", "odd:gain:=99.0", "--params-file", str(path)),
    )
    assert program.expect("up") == "up /left/gear_monitor /right/gear_monitor /bench/odd"
    spin_until(lambda: all(publisher.get_subscription_count() == 1 for publisher in publishers.values()))
    spin_until(lambda: all(subscription.get_publisher_count() == 1 for subscription in bench.subscriptions))
    for number, publisher in enumerate(publishers.values()):
        publisher.publish(Float64(data=float(number + 1)))
    spin_until(lambda: all(got.values()))
    assert got == {"/left/gear_monitor": [3.0], "/right/gear_monitor": [10.0], "/bench/odd": [30.0]}
    spin_until(lambda: set(got) <= set(bench.get_fully_qualified_node_names()))
    for name in got:
        namespace, _, short = name.rpartition("/")
        services = [service for service, _ in bench.get_service_names_and_types_by_node(short, namespace)]
        assert {f"{name}/get_state", f"{name}/set_parameters"} <= set(services)
        assert not any(service.startswith(tuple(got.keys() - {name})) for service in services)
    assert program.stop() == 0
    assert program.lines[-1] == "clean"


@pytest.fixture
def pair(context: Context) -> Iterator[list[LifecycleNode]]:
    nodes = [LifecycleNode("one", context=context), LifecycleNode("two", context=context)]
    yield nodes
    for node in nodes:
        node.destroy_node()


def test_one_node_leaves_and_the_others_go_on(pair: list[LifecycleNode], executor: Any, spin_until: SpinUntil) -> None:
    one, two = pair
    calls: list[str] = []
    for node in pair:
        assert executor.add_node(node)
        assert not executor.add_node(node)
        node.create_timer(0.01, partial(calls.append, node.get_name()))
    spin_until(lambda: {"one", "two"} <= set(calls))
    one.destroy_node()
    assert executor.get_nodes() == [two]
    calls.clear()
    spin_until(lambda: len(calls) > 3)
    assert set(calls) == {"two"}
    executor.remove_node(two)
    calls.clear()
    executor.spin_once(timeout_sec=0.0)
    assert calls == []


def test_states_parameters_and_clocks_are_each_nodes_own(pair: list[LifecycleNode]) -> None:
    one, two = pair
    one.trigger_configure()
    assert two._state_machine.current_state == (1, "unconfigured")
    for node in pair:
        node.declare_parameter("gain", 1.0)
    one.set_parameters([Parameter("gain", value=2.0), Parameter("use_sim_time", value=True)])
    assert two.get_parameter("gain").value == 1.0
    assert one.get_clock().ros_time_is_active
    assert not two.get_clock().ros_time_is_active


def test_a_node_calls_another_in_the_same_executor(
    pair: list[LifecycleNode], executor: Any, spin_until: SpinUntil
) -> None:
    from seat_gear_dynamics.runtime.messages import get_service

    one, two = pair
    for node in pair:
        executor.add_node(node)
    kind = get_service("lifecycle_msgs/srv/ChangeState")
    client = one.create_client(kind, "/two/change_state")
    spin_until(client.service_is_ready)
    request = kind.Request()
    request.transition.label = "configure"
    future = client.call_async(request)
    spin_until(future.done)
    assert future.result().success
    assert two._state_machine.current_state[1] == "inactive"
