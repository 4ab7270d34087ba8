"""Managed nodes as others see them: their services, their topic of transitions, and what comes and goes with them."""

from __future__ import annotations

from typing import Any

from programs import PREAMBLE, Run, SpinUntil

from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.lifecycle.node import LifecycleNode
from seat_gear_dynamics.runtime.lifecycle.state_machine import (
    STATES,
    TRANSITIONS,
    LifecycleState,
    TransitionCallbackReturn,
)
from seat_gear_dynamics.runtime.messages import get_message, get_service
from seat_gear_dynamics.runtime.node import Node

Float64 = get_message("std_msgs/msg/Float64")

MANAGED = (
    PREAMBLE
    + """
from rclpy.lifecycle import LifecycleNode
rclpy.init()
node = LifecycleNode("managed")
publisher = node.create_lifecycle_publisher(Float64, "value", 10)
node.create_timer(0.01, lambda: publisher.publish(Float64(data=float(node._state_machine.current_state[0]))))
print("up")
rclpy.spin(node)
"""
)


def test_another_program_drives_the_node(run: Run, context: Context, executor: Any, spin_until: SpinUntil) -> None:
    run(MANAGED, "--ros-args", "-r", "__ns:=/bench").expect("up")
    node = Node("driver", context=context)
    executor.add_node(node)
    events: list[Any] = []
    states: list[float] = []
    event = get_message("lifecycle_msgs/msg/TransitionEvent")
    node.create_subscription(event, "/bench/managed/transition_event", events.append, 10)
    node.create_subscription(Float64, "/bench/value", lambda message: states.append(message.data), 10)

    def call(short: str, service: str, **fields: Any) -> Any:
        kind = get_service(f"lifecycle_msgs/srv/{short}")
        client = node.create_client(kind, f"/bench/managed/{service}")
        spin_until(client.service_is_ready)
        future = client.call_async(kind.Request(**fields))
        spin_until(future.done)
        node.destroy_client(client)
        return future.result()

    def change(**fields: Any) -> bool:
        transition = get_message("lifecycle_msgs/msg/Transition")(**fields)
        return bool(call("ChangeState", "change_state", transition=transition).success)

    def state() -> str:
        return str(call("GetState", "get_state").current_state.label)

    spin_until(lambda: node.count_publishers("/bench/managed/transition_event") == 1)
    assert state() == "unconfigured"
    assert [s.id for s in call("GetAvailableStates", "get_available_states").available_states] == [
        known.state_id for known in STATES
    ]
    possible = call("GetAvailableTransitions", "get_available_transitions").available_transitions
    assert [way.transition.label for way in possible] == ["configure", "shutdown"]
    graph = call("GetAvailableTransitions", "get_transition_graph").available_transitions
    assert [(w.transition.id, w.start_state.label, w.goal_state.label) for w in graph] == [
        (way.transition_id, way.start.label, way.goal.label) for way in TRANSITIONS
    ]
    assert change(id=1)
    assert not change(id=1)
    assert not change(label="no such thing")
    assert state() == "inactive"
    assert change(label="activate")
    spin_until(lambda: len(states) > 2)
    assert change(label="deactivate")
    assert state() == "inactive"
    assert change(label="shutdown")
    assert state() == "finalized"
    # Its timer never stopped; each message tells the state it was published in.
    assert set(states) == {3.0}
    spin_until(lambda: events and events[-1].goal_state.label == "finalized")
    assert [e.start_state.label for e in events[-8:]] == [
        *("unconfigured", "configuring", "inactive", "activating"),
        *("active", "deactivating", "inactive", "shuttingdown"),
    ]
    assert [e.transition.id for e in events[-8:]] == [1, 10, 3, 30, 4, 40, 6, 50]
    assert all(e.timestamp > 0 for e in events)


def test_without_services_the_topic_remains(context: Context) -> None:
    node = LifecycleNode(
        "worker", context=context, start_parameter_services=False, enable_communication_interface=False
    )
    assert list(node.services) == []
    assert "/worker/transition_event" in [publisher.topic_name for publisher in node.publishers]
    assert node.trigger_configure() is TransitionCallbackReturn.SUCCESS
    node.destroy_node()


class Cycling(LifecycleNode):
    """Makes what it needs when it is configured, and takes it down when it is cleaned up."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.heard: list[float] = []
        self.output = self.create_lifecycle_publisher(Float64, "out", 10)
        self.input = self.create_subscription(Float64, "out", lambda m: self.heard.append(m.data), 10)
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.timer = self.create_timer(0.01, lambda: self.output.publish(Float64(data=1.0)))
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.destroy_timer(self.timer)
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.destroy_lifecycle_publisher(self.output)
        self.destroy_subscription(self.input)
        return super().on_cleanup(state)


def test_what_is_made_and_taken_down_again_and_again(context: Context, executor: Any, spin_until: SpinUntil) -> None:
    node = Cycling("cycling", context=context)
    executor.add_node(node)
    kind = get_service("lifecycle_msgs/srv/ChangeState")
    client = node.create_client(kind, "~/change_state")
    spin_until(client.service_is_ready)

    def change(label: str) -> None:
        # Over the service, so that the executor runs the callback that takes its work away.
        future = client.call_async(kind.Request(transition=get_message("lifecycle_msgs/msg/Transition")(label=label)))
        spin_until(future.done)
        assert future.result().success

    for _ in range(3):
        change("configure")
        change("activate")
        spin_until(lambda: len(node.heard) > 2)
        change("deactivate")
        change("cleanup")
        assert (node.count_publishers("out"), node.count_subscribers("out")) == (0, 0)
        assert list(node.timers) == []
        assert node._managed_entities == {}
    node.destroy_node()
