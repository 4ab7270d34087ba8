"""Declaring, checking and setting parameters, in one program and through their services."""

from __future__ import annotations

from typing import Any

import pytest
from programs import MakeNode, SpinUntil

from seat_gear_dynamics.runtime import exceptions
from seat_gear_dynamics.runtime.messages import get_message, get_service
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.parameters.parameter import Parameter

Descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
FloatRange = get_message("rcl_interfaces/msg/FloatingPointRange")
IntegerRange = get_message("rcl_interfaces/msg/IntegerRange")
Result = get_message("rcl_interfaces/msg/SetParametersResult")


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node()


def accepted(node: Node, name: str, value: Any) -> bool:
    return bool(node.set_parameters([Parameter(name, value=value)])[0].successful)


@pytest.mark.parametrize("value", [True, 3, 1.5, "text", [True], [1, 2], [1.0], ["a", "b"], [b"\1"]])
def test_values_of_every_type(node: Node, value: Any) -> None:
    declared = node.declare_parameter("p", value)
    assert node.get_parameter("p").value == value
    again = Parameter.from_parameter_msg(declared.to_parameter_msg())
    assert (again.type_, list(again.value) if isinstance(value, list) else again.value) == (declared.type_, value)


def test_types_do_not_change(node: Node) -> None:
    node.declare_parameter("p", 1.0)
    result = node.set_parameters([Parameter("p", value=2)])[0]
    assert result.reason == "Wrong parameter type, expected 'Type.DOUBLE' got 'Type.INTEGER'"
    assert node.get_parameter("p").value == 1.0


def test_dynamic_typing_lets_them(node: Node) -> None:
    node.declare_parameter("p", 1.0, Descriptor(dynamic_typing=True))
    assert accepted(node, "p", "text")
    assert node.describe_parameter("p").type == Parameter.Type.STRING.value


@pytest.mark.parametrize(
    ("value", "good"), [(0.0, True), (0.25, True), (1.0, True), (0.3, False), (-0.1, False), (1.1, False)]
)
def test_float_range_with_step(node: Node, value: float, good: bool) -> None:
    bounds = [FloatRange(from_value=0.0, to_value=1.0, step=0.25)]
    node.declare_parameter("p", 0.5, Descriptor(floating_point_range=bounds))
    assert accepted(node, "p", value) is good
    assert node.get_parameter("p").value == (value if good else 0.5)


@pytest.mark.parametrize(("value", "good"), [(0, True), (4, True), (9, True), (5, False), (-2, False), (10, False)])
def test_integer_range_with_step(node: Node, value: int, good: bool) -> None:
    bounds = [IntegerRange(from_value=0, to_value=9, step=2)]
    node.declare_parameter("p", 2, Descriptor(integer_range=bounds))
    assert accepted(node, "p", value) is good


def test_read_only(node: Node) -> None:
    node.declare_parameter("p", 1, Descriptor(read_only=True))
    assert node.set_parameters([Parameter("p", value=2)])[0].reason.startswith("Trying to set a read-only")
    with pytest.raises(exceptions.ParameterImmutableException):
        node.undeclare_parameter("p")


def test_errors_have_their_names(node: Node) -> None:
    with pytest.raises(exceptions.ParameterNotDeclaredException):
        node.get_parameter("p")
    with pytest.raises(exceptions.ParameterNotDeclaredException):
        node.set_parameters([Parameter("p", value=1)])
    node.declare_parameter("p", Parameter.Type.INTEGER)
    with pytest.raises(exceptions.ParameterUninitializedException):
        node.get_parameter("p")
    with pytest.raises(exceptions.ParameterAlreadyDeclaredException):
        node.declare_parameter("p", 1)
    with pytest.raises(exceptions.InvalidParameterException):
        node.declare_parameter("", 1)
    bounds = Descriptor(integer_range=[IntegerRange(from_value=0, to_value=1)])
    with pytest.raises(exceptions.InvalidParameterValueException):
        node.declare_parameter("q", 5, bounds)
    with pytest.warns(UserWarning, match="only providing its name is deprecated"):
        node.declare_parameter("r")


def test_overrides_win_and_are_checked(make_node: MakeNode) -> None:
    overrides = [Parameter("a", value=2), Parameter("b", value="text")]
    node = make_node(parameter_overrides=overrides)
    assert node.declare_parameter("a", 1).value == 2
    with pytest.raises(exceptions.InvalidParameterTypeException, match="expecting type 'DOUBLE'"):
        node.declare_parameter("b", 1.0)
    automatic = make_node("auto", parameter_overrides=overrides, automatically_declare_parameters_from_overrides=True)
    assert automatic.get_parameter("b").value == "text"


def test_undeclared_parameters_where_allowed(make_node: MakeNode) -> None:
    node = make_node(allow_undeclared_parameters=True)
    assert node.get_parameter("p").value is None
    assert accepted(node, "p", 3)
    assert node.get_parameter("p").value == 3
    assert accepted(node, "p", None)
    assert not node.has_parameter("p")


def test_atomic_sets_are_all_or_nothing(node: Node) -> None:
    node.declare_parameter("a", 1)
    node.declare_parameter("b", 1, Descriptor(integer_range=[IntegerRange(from_value=0, to_value=5)]))
    result = node.set_parameters_atomically([Parameter("a", value=2), Parameter("b", value=9)])
    assert not result.successful
    assert [node.get_parameter(name).value for name in "ab"] == [1, 1]
    assert node.set_parameters_atomically([Parameter("a", value=2), Parameter("b", value=3)]).successful
    assert [node.get_parameter(name).value for name in "ab"] == [2, 3]


def test_callbacks_before_at_and_after(node: Node) -> None:
    node.declare_parameters("", [("a", 1), ("b", 1)])
    seen: list[Any] = []

    def before(parameters: list[Parameter]) -> list[Parameter]:
        return [*parameters, Parameter("b", value=7)]

    def judge(parameters: list[Parameter]) -> Any:
        good = all(parameter.value < 10 for parameter in parameters)
        return Result(successful=good, reason="" if good else "too much")

    node.add_pre_set_parameters_callback(before)
    node.add_on_set_parameters_callback(judge)
    node.add_post_set_parameters_callback(lambda parameters: seen.extend(p.name for p in parameters))
    assert node.set_parameters([Parameter("a", value=11)])[0].reason == "too much"
    assert accepted(node, "a", 2)
    assert (node.get_parameter("b").value, seen) == (7, ["a", "b"])
    node.remove_pre_set_parameters_callback(before)
    node.remove_on_set_parameters_callback(judge)
    assert accepted(node, "a", 12)


def test_lists_prefixes_and_alternatives(node: Node) -> None:
    node.declare_parameters("limits", [("low", 1.0), ("high.hard", 2.0)])
    assert set(node.get_parameters_by_prefix("limits")) == {"low", "high.hard"}
    assert node.list_parameters(["limits"], 1).names == ["limits.low"]
    everything = node.list_parameters([], 0)
    assert everything.names == ["use_sim_time", "limits.low", "limits.high.hard"]
    assert everything.prefixes == ["limits", "limits.high"]
    assert node.get_parameter_or("none", Parameter("none", value=5)).value == 5


def test_new_descriptor_takes_the_alternative(node: Node) -> None:
    node.declare_parameter("p", 50)
    bounds = Descriptor(type=Parameter.Type.INTEGER.value, integer_range=[IntegerRange(from_value=0, to_value=9)])
    with pytest.raises(exceptions.InvalidParameterValueException):
        node.set_descriptor("p", bounds)
    assert node.set_descriptor("p", bounds, Parameter("p", value=5).get_parameter_value()).integer_value == 5


def test_events_and_services(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    owner = make_node("owner", start_parameter_services=True)
    owner.declare_parameter("speed", 1.0, Descriptor(description="rad/s"))
    other = make_node("other")
    events: list[Any] = []
    other.create_subscription(get_message("rcl_interfaces/msg/ParameterEvent"), "/parameter_events", events.append, 10)
    for node in (owner, other):
        executor.add_node(node)

    def call(short: str, service: str, **fields: Any) -> Any:
        kind = get_service(f"rcl_interfaces/srv/{short}")
        client = other.create_client(kind, f"/owner/{service}")
        spin_until(client.service_is_ready)
        future = client.call_async(kind.Request(**fields))
        spin_until(future.done)
        other.destroy_client(client)
        return future.result()

    assert call("ListParameters", "list_parameters").result.names == ["use_sim_time", "speed"]
    assert call("GetParameters", "get_parameters", names=["speed"]).values[0].double_value == 1.0
    assert list(call("GetParameterTypes", "get_parameter_types", names=["speed"]).types) == [3]
    assert call("DescribeParameters", "describe_parameters", names=["speed"]).descriptors[0].description == "rad/s"
    wanted = [Parameter("speed", value=2.0).to_parameter_msg(), Parameter("none", value=1).to_parameter_msg()]
    results = call("SetParameters", "set_parameters", parameters=wanted).results
    assert [result.successful for result in results] == [True, False]
    assert not call("SetParametersAtomically", "set_parameters_atomically", parameters=wanted).result.successful
    assert call("GetParameters", "get_parameters", names=["none"]).values == []
    spin_until(lambda: any(event.changed_parameters for event in events))
    changed = next(event for event in events if event.changed_parameters)
    assert (changed.node, changed.changed_parameters[0].value.double_value) == ("/owner", 2.0)


def test_what_a_callback_raises_comes_out_of_spin(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node(start_parameter_services=True)
    node.declare_parameter("speed", 1.0)
    executor.add_node(node)
    kind = get_service("rcl_interfaces/srv/SetParameters")
    client = node.create_client(kind, "~/set_parameters")
    spin_until(client.service_is_ready)

    def judge(parameters: list[Parameter]) -> Any:
        raise ValueError("a fault of the node")

    node.add_on_set_parameters_callback(judge)
    client.call_async(kind.Request(parameters=[Parameter("speed", value=2.0).to_parameter_msg()]))
    with pytest.raises(ValueError, match="a fault of the node"):
        spin_until(lambda: False)
    assert node.get_parameter("speed").value == 1.0


def test_a_malformed_parameter_is_refused(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node(start_parameter_services=True)
    executor.add_node(node)
    kind = get_service("rcl_interfaces/srv/SetParameters")
    client = node.create_client(kind, "~/set_parameters")
    spin_until(client.service_is_ready)
    message = Parameter("speed", value=2.0).to_parameter_msg()
    message.value.type = 77
    future = client.call_async(kind.Request(parameters=[message]))
    spin_until(future.done)
    assert not future.result().results[0].successful
