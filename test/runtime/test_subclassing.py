"""A node class of a user's own must not collide with the bundled node's private names."""

import pytest

from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.lifecycle.node import LifecycleNode
from seat_gear_dynamics.runtime.node import Node

# rclpy's own private names, which a subclass has to leave alone there as well.
RCLPY = {
    "_allow_undeclared_parameters",
    "_clients",
    "_clock",
    "_context",
    "_default_callback_group",
    "_descriptors",
    "_logger",
    "_on_set_parameters_callbacks",
    "_parameter_event_publisher",
    "_parameter_overrides",
    "_parameter_service",
    "_parameters",
    "_post_set_parameters_callbacks",
    "_pre_set_parameters_callbacks",
    "_publishers",
    "_rate_group",
    "_services",
    "_subscriptions",
    "_time_source",
    "_timers",
}


# What rclpy's managed nodes have besides.
RCLPY_LIFECYCLE = {
    "_callbacks",
    "_managed_entities",
    "_service_change_state",
    "_service_get_available_states",
    "_service_get_available_transitions",
    "_service_get_state",
    "_service_get_transition_graph",
    "_state_machine",
}


@pytest.mark.parametrize(("kind", "known"), [(Node, RCLPY), (LifecycleNode, RCLPY | RCLPY_LIFECYCLE)])
def test_every_private_name_is_rclpys_or_carries_the_runtimes_prefix(
    context: Context, kind: type[Node], known: set[str]
) -> None:
    node = kind("names", context=context)
    names = {name for name in {*dir(kind), *vars(node)} if name.startswith("_") and not name.startswith("__")}
    strange = {name for name in names if not name.startswith(("_rt_", "_Node__"))} - known
    node.destroy_node()
    assert not strange, "a subclass may use these names for itself"


@pytest.mark.parametrize("name", ["_start", "_name", "_store", "_destroy", "_executor"])
def test_a_subclass_may_use_common_names(context: Context, name: str) -> None:
    own = type("Own", (Node,), {name: lambda self: "mine"})
    node = own("own", context=context)
    assert getattr(node, name)() == "mine"
    node.destroy_node()
