"""Managed nodes: work is set up, started, stopped and taken down by transitions that others may ask for."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Any, cast

from seat_gear_dynamics.runtime.exceptions import RCLError
from seat_gear_dynamics.runtime.groups import CallbackGroup
from seat_gear_dynamics.runtime.lifecycle.communication import LifecycleServices, TransitionEvents
from seat_gear_dynamics.runtime.lifecycle.managed_entity import ManagedEntity
from seat_gear_dynamics.runtime.lifecycle.publisher import LifecyclePublisher
from seat_gear_dynamics.runtime.lifecycle.state_machine import (
    SHUTDOWN,
    LifecycleState,
    StateMachine,
    TransitionCallbackReturn,
)
from seat_gear_dynamics.runtime.node import Node

_Callback = Callable[[LifecycleState], TransitionCallbackReturn]

_CONFIGURE, _CLEANUP, _ACTIVATE, _DEACTIVATE = 1, 2, 3, 4
_ACTIVE = "active"


class LifecycleNodeMixin(ManagedEntity):
    """What makes a `Node` a managed one; of use only in a class that is a `Node` too.

    Its transition callbacks pass the transition on to every managed entity, publishers among them. A class that
    overrides one calls `super()` in it, or its publishers stay as they are.
    """

    def __init__(
        self, *, enable_communication_interface: bool = True, callback_group: CallbackGroup | None = None
    ) -> None:
        self._callbacks: dict[str, _Callback] = {
            "configuring": self.on_configure,
            "cleaningup": self.on_cleanup,
            "shuttingdown": self.on_shutdown,
            "activating": self.on_activate,
            "deactivating": self.on_deactivate,
            "errorprocessing": self.on_error,
        }
        # A dict for its order: entities hear of a transition in the order they came.
        self._managed_entities: dict[ManagedEntity, None] = {}
        node: Any = self
        with node._context._graph_opened.one_announcement():
            self._state_machine = StateMachine(TransitionEvents(node).publish)
            if enable_communication_interface:
                LifecycleServices(node, self._state_machine, callback_group or node.default_callback_group)

    # Transitions -------------------------------------------------------------------------------------------

    def trigger_configure(self) -> TransitionCallbackReturn:
        """Configure the node; return what its callback said.

        Raises:
            RCLError: the transition is not possible in the present state.
            TypeError: the callback returned something else; the node then stays in the transition state.
        """
        return self._rt_change_state(_CONFIGURE)

    def trigger_cleanup(self) -> TransitionCallbackReturn:
        """Clean the node up; see `trigger_configure`."""
        return self._rt_change_state(_CLEANUP)

    def trigger_activate(self) -> TransitionCallbackReturn:
        """Activate the node; see `trigger_configure`."""
        return self._rt_change_state(_ACTIVATE)

    def trigger_deactivate(self) -> TransitionCallbackReturn:
        """Deactivate the node; see `trigger_configure`."""
        return self._rt_change_state(_DEACTIVATE)

    def trigger_shutdown(self) -> TransitionCallbackReturn:
        """Shut the node down from whatever primary state it is in; see `trigger_configure`."""
        machine = self._state_machine
        if SHUTDOWN not in (way[1] for way in machine.available_transitions):
            raise RCLError(f"Shutdown transition not possible in state {machine.state.label!r}.")
        return self._rt_change_state(machine.get_transition_by_label(SHUTDOWN))

    def _rt_change_state(self, transition_id: int) -> TransitionCallbackReturn:
        machine, before = self._state_machine, self._state_machine.state
        machine.trigger_transition_by_id(transition_id)
        said = self._rt_run(before)
        machine.trigger_transition_by_label(said.to_label())
        if said is TransitionCallbackReturn.ERROR:
            machine.trigger_transition_by_label(self._rt_run(before).to_label())
        if machine.state.label != _ACTIVE:
            self._rt_silence()
        return said

    def _rt_run(self, before: LifecycleState) -> TransitionCallbackReturn:
        """Run the callback of the transition state the node is in."""
        label = self._state_machine.state.label
        callback = self._callbacks[label]
        node: Any = self
        try:
            said = callback(before)
        except Exception:
            node.get_logger().error(f"The callback of state {label!r} raised:\n{traceback.format_exc()}")
            return TransitionCallbackReturn.ERROR
        if not isinstance(said, TransitionCallbackReturn):
            raise TypeError(
                f"{getattr(callback, '__qualname__', callback)} returned {said!r}, expected a TransitionCallbackReturn:"
                " return SUCCESS, FAILURE or ERROR, for instance what super() returns."
            )
        return said

    def _rt_silence(self) -> None:
        """Switch every publisher off, whatever the callbacks did on their way."""
        for entity in self._managed_entities:
            if isinstance(entity, LifecyclePublisher):
                entity._enabled = False

    # What happens in them ----------------------------------------------------------------------------------

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle configuring; `state` is the one before. This passes it on to the managed entities."""
        return self._rt_pass_on("on_configure", state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle cleaning up; see `on_configure`."""
        return self._rt_pass_on("on_cleanup", state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle shutting down; see `on_configure`."""
        return self._rt_pass_on("on_shutdown", state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle activating; see `on_configure`."""
        return self._rt_pass_on("on_activate", state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle deactivating; see `on_configure`."""
        return self._rt_pass_on("on_deactivate", state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle an error in another callback: success leads to unconfigured, all else to finalized."""
        return self._rt_pass_on("on_error", state)

    def _rt_pass_on(self, name: str, state: LifecycleState) -> TransitionCallbackReturn:
        """Tell the managed entities of a transition, up to the first that does not succeed."""
        for entity in tuple(self._managed_entities):
            said = getattr(entity, name)(state)
            if not isinstance(said, TransitionCallbackReturn):
                raise TypeError(
                    f"{name}() return value of class {type(entity)} should be `TransitionCallbackReturn`, "
                    f"it was {said!r}; the instance is {entity}."
                )
            if said is not TransitionCallbackReturn.SUCCESS:
                return said
        return TransitionCallbackReturn.SUCCESS

    # What follows them -------------------------------------------------------------------------------------

    def add_managed_entity(self, entity: ManagedEntity) -> None:
        """Tell an entity of every transition from now on.

        Raises:
            TypeError: it is not a ManagedEntity.
        """
        if not isinstance(entity, ManagedEntity):
            raise TypeError("Expected a rclpy.lifecycle.ManagedEntity instance.")
        self._managed_entities[entity] = None

    def create_lifecycle_publisher(self, *args: Any, **kwargs: Any) -> LifecyclePublisher:
        """Make a publisher that is silent unless the node is active; arguments as in `Node.create_publisher`.

        One made while the node is active is silent until the next activation, as in rclpy.

        Raises:
            TypeError: `publisher_class` is given.
        """
        if "publisher_class" in kwargs:
            raise TypeError("create_publisher() got an unexpected keyword argument 'publisher_class'")
        node: Any = self
        made = Node.create_publisher(node, *args, **kwargs, publisher_class=LifecyclePublisher)
        publisher = cast(LifecyclePublisher, made)
        self._managed_entities[publisher] = None
        return publisher

    def destroy_lifecycle_publisher(self, publisher: LifecyclePublisher) -> bool:
        """Destroy a publisher of this node; return whether it was one."""
        self._managed_entities.pop(publisher, None)
        node: Any = self
        return Node.destroy_publisher(node, publisher)


class LifecycleNode(LifecycleNodeMixin, Node):
    """A managed node: unconfigured at first, and silent until it is configured and activated."""

    def __init__(self, node_name: str, *, enable_communication_interface: bool = True, **kwargs: Any) -> None:
        Node.__init__(self, node_name, **kwargs)
        LifecycleNodeMixin.__init__(self, enable_communication_interface=enable_communication_interface)
