"""The schema of parameters: descriptor and check agree at the bounds, sets are whole, the docs hold the same tables."""

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from seat_gear_dynamics.nodes import monitor_parameters, recorder, simulator
from seat_gear_dynamics.nodes.parameter_table import DOCS, TABLES, embedded, table
from seat_gear_dynamics.nodes.parameters import Parameter, Parameters
from seat_gear_dynamics.nodes.process import StartError

ALL = [
    pytest.param(parameter, id=f"{node}-{parameter.name}")
    for node, schema in (
        ("monitor", monitor_parameters.PARAMETERS),
        ("recorder", recorder.PARAMETERS),
        ("simulator", simulator.PARAMETERS),
    )
    for parameter in schema
]
NUMBERS = [case for case in ALL if case.values[0].numeric]  # type: ignore[union-attr]
WRONG: dict[type, list[object]] = {
    str: [1, 1.5, True, [1]],
    bool: [1, 0.0, "true"],
    int: [1.0, "1", True, [1]],
    float: [1, "1.0", False, [1.0]],
}


@pytest.fixture
def node(domain_id: int) -> Iterator[Any]:
    """A plain node on the test's domain."""
    import rclpy

    rclpy.init(args=[], domain_id=domain_id)
    made = rclpy.create_node("holder", start_parameter_services=False)
    yield made
    made.destroy_node()
    rclpy.try_shutdown()


def set_to(node: Any, **values: object) -> Any:
    from rclpy.parameter import Parameter as Given

    return node.set_parameters_atomically([Given(name, value=value) for name, value in values.items()])


def beyond(parameter: Parameter) -> list[float]:
    """The nearest values outside both bounds."""
    assert parameter.low is not None
    assert parameter.high is not None
    if isinstance(parameter.default, int):
        return [int(parameter.low) - 1, int(parameter.high) + 1]
    return [math.nextafter(parameter.low, -math.inf), math.nextafter(parameter.high, math.inf)]


@pytest.mark.parametrize("parameter", NUMBERS)
def test_descriptor_and_check_agree_at_the_bounds(node: Any, parameter: Parameter) -> None:
    values = Parameters(node, [replace(parameter, change="run")])
    kind = type(parameter.default)
    described = node.describe_parameter(parameter.name)
    (span,) = described.floating_point_range if kind is float else described.integer_range
    assert (span.from_value, span.to_value, span.step) == (parameter.low, parameter.high, 0)
    for bound in (span.from_value, span.to_value):
        assert set_to(node, **{parameter.name: kind(bound)}).successful
        assert values[parameter.name] == bound
    refused = [*beyond(parameter), *([math.nan, math.inf, -math.inf] if kind is float else [])]
    for value in refused:
        result = set_to(node, **{parameter.name: value})
        assert not result.successful, value
        assert parameter.name in result.reason
    assert values[parameter.name] == parameter.high, "what was refused changed nothing"


@pytest.mark.parametrize("parameter", ALL)
def test_a_wrong_type_is_refused_by_both(node: Any, parameter: Parameter) -> None:
    values = Parameters(node, [replace(parameter, change="run")])
    for wrong in WRONG[type(parameter.default)]:
        assert parameter.refusal(wrong) is not None
        result = set_to(node, **{parameter.name: wrong})
        assert not result.successful, wrong
        assert "type" in result.reason.lower()
    assert values[parameter.name] == parameter.default


@pytest.mark.parametrize("parameter", ALL)
def test_a_parameter_says_what_it_is_and_when_it_may_change(node: Any, parameter: Parameter) -> None:
    Parameters(node, [parameter])
    described = node.describe_parameter(parameter.name)
    assert described.description == parameter.description
    assert described.read_only == (parameter.change == "start")
    assert "may be changed" in described.additional_constraints
    if parameter.change == "start":
        assert not set_to(node, **{parameter.name: parameter.default}).successful


def test_several_are_taken_together_or_not_at_all(node: Any) -> None:
    told: list[dict[str, Any]] = []
    values = Parameters(node, monitor_parameters.PARAMETERS, applied=lambda: told.append(dict(values)))
    result = set_to(node, margin_rpm=60.0, horizon=-1.0)
    assert not result.successful
    assert result.reason.count("horizon") >= 1
    assert (values["margin_rpm"], values["horizon"], told) == (40.0, 1.0, [])
    assert set_to(node, margin_rpm=60.0, horizon=2.0).successful
    assert [(each["margin_rpm"], each["horizon"]) for each in told] == [(60.0, 2.0)], "applied once, with both"


def test_what_needs_a_new_model_waits_until_the_node_is_unconfigured(node: Any) -> None:
    reason: list[str] = ["clean it up first"]
    values = Parameters(node, monitor_parameters.PARAMETERS, locked=lambda: reason[0] if reason else None)
    result = set_to(node, margin_rpm=60.0, system="other.yaml")
    assert not result.successful
    assert result.reason == (
        "The parameter system may be changed only while the node is unconfigured; clean it up first."
    )
    assert values["margin_rpm"] == 40.0
    assert set_to(node, system="", margin_rpm=60.0).successful, "a value that stays is no change"
    reason.clear()
    assert set_to(node, system="other.yaml").successful
    assert values["system"] == "other.yaml"


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"default": 1.0}, "needs both bounds"),
        ({"default": "a", "low": 0.0, "high": 1.0}, "none if it is not"),
        ({"default": 2.0, "low": 0.0, "high": 1.0}, "expected a number with a point from 0 to 1"),
        ({"default": "c", "choices": ("a", "b")}, "expected 'a' or 'b'"),
    ],
)
def test_a_schema_that_contradicts_itself_is_refused(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Parameter("p", description="a parameter", **fields)


def test_a_value_given_at_start_goes_through_the_same_check(domain_id: int) -> None:
    import rclpy
    from rclpy.parameter import Parameter as Given

    rclpy.init(args=[], domain_id=domain_id)
    # 1e-9 beyond: ROS 2's own check of ranges lets a millionth pass.
    node = rclpy.create_node("holder", parameter_overrides=[Given("horizon", value=60.0 * (1 + 1e-9))])
    try:
        with pytest.raises(StartError, match=r"from 0 to 60, such as 1\.0"):
            Parameters(node, monitor_parameters.PARAMETERS)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


@pytest.mark.parametrize("name", TABLES)
def test_the_docs_hold_the_schemas_table(name: str) -> None:
    document, schema = TABLES[name]
    text = (DOCS / document).read_text(encoding="utf-8")
    assert embedded(text, name, schema) == text, "run: python -m seat_gear_dynamics.nodes.parameter_table"
    for parameter in schema:
        (row,) = re.findall(rf"^\| `{parameter.name}` \|.*$", table(schema), re.MULTILINE)
        assert row.endswith(f"{parameter.description} |")
