"""What a managed node shows the network: five services and a topic of its transitions."""

from __future__ import annotations

import weakref
from collections.abc import Iterable
from typing import Any

from seat_gear_dynamics.runtime.exceptions import RCLError
from seat_gear_dynamics.runtime.groups import CallbackGroup
from seat_gear_dynamics.runtime.lifecycle.state_machine import (
    LifecycleState,
    Row,
    StateMachine,
    Transition,
    TransitionCallbackReturn,
)
from seat_gear_dynamics.runtime.messages import get_message, get_service
from seat_gear_dynamics.runtime.qos import QoSProfile

_EVENT_DEPTH = 10


class TransitionEvents:
    """Publishes `~/transition_event`: every transition, those into and out of the transition states too.

    Unlike rcl_lifecycle, which leaves them empty, this fills in the transition and the time (ns of the node's clock).
    """

    def __init__(self, node: Any) -> None:
        self._clock = node.get_clock()
        self._message = get_message("lifecycle_msgs/msg/TransitionEvent")
        self._publisher = node.create_publisher(self._message, "~/transition_event", QoSProfile(depth=_EVENT_DEPTH))

    def publish(self, transition: Transition) -> None:
        """Tell everybody of a transition."""
        message = self._message(timestamp=self._clock.now().nanoseconds)
        message.transition.id, message.transition.label = transition.transition_id, transition.label
        _fill(message.start_state, transition.start)
        _fill(message.goal_state, transition.goal)
        self._publisher.publish(message)


def _fill(message: Any, state: LifecycleState) -> None:
    message.id, message.label = state.state_id, state.label


class LifecycleServices:
    """Answers `ros2 lifecycle` and launch files: what state, what next, and please change."""

    def __init__(self, node: Any, machine: StateMachine, callback_group: CallbackGroup) -> None:
        self._node_weak_ref = weakref.ref(node)
        self._machine = machine
        for short, name, callback in (
            ("ChangeState", "change_state", self._change_state),
            ("GetState", "get_state", self._get_state),
            ("GetAvailableStates", "get_available_states", self._get_available_states),
            ("GetAvailableTransitions", "get_available_transitions", self._get_available_transitions),
            ("GetAvailableTransitions", "get_transition_graph", self._get_transition_graph),
        ):
            kind: Any = get_service(f"lifecycle_msgs/srv/{short}")
            service = node.create_service(kind, f"~/{name}", callback, callback_group=callback_group)
            setattr(node, f"_service_{name}", service)

    def _change_state(self, request: Any, response: Any) -> Any:
        node = self._node_weak_ref()
        if node is None:
            raise ReferenceError("Expected valid node weak reference")
        response.success = False
        try:
            wanted = request.transition.id
            if request.transition.label:
                wanted = self._machine.get_transition_by_label(request.transition.label)
            self._machine.require(wanted)
        except RCLError as error:
            # Anybody may ask for the impossible; a node that works must not end for it.
            node.get_logger().warning(str(error))
            return response
        response.success = node._rt_change_state(wanted) is TransitionCallbackReturn.SUCCESS
        return response

    def _get_state(self, request: Any, response: Any) -> Any:
        _fill(response.current_state, self._machine.state)
        return response

    def _get_available_states(self, request: Any, response: Any) -> Any:
        state = get_message("lifecycle_msgs/msg/State")
        response.available_states = [state(id=i, label=label) for i, label in self._machine.available_states]
        return response

    def _get_available_transitions(self, request: Any, response: Any) -> Any:
        response.available_transitions = _descriptions(self._machine.available_transitions)
        return response

    def _get_transition_graph(self, request: Any, response: Any) -> Any:
        response.available_transitions = _descriptions(self._machine.transition_graph)
        return response


def _descriptions(rows: Iterable[Row]) -> list[Any]:
    """Return lifecycle_msgs/TransitionDescription for each transition."""
    kind = get_message("lifecycle_msgs/msg/TransitionDescription")
    found = []
    for transition_id, label, start_id, start_label, goal_id, goal_label in rows:
        message = kind()
        message.transition.id, message.transition.label = transition_id, label
        message.start_state.id, message.start_state.label = start_id, start_label
        message.goal_state.id, message.goal_state.label = goal_id, goal_label
        found.append(message)
    return found
