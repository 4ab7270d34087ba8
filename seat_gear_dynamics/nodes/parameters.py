"""Node parameters from one schema: default, description, range and whether it may change at run time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node

from seat_gear_dynamics.nodes.process import StartError


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node; its default gives its type."""

    name: str
    default: str | bool | int | float
    description: str
    low: float | None = None
    high: float | None = None

    @property
    def expected(self) -> str:
        """What the parameter takes, in words, with its default as the example."""
        kind = {str: "a text", bool: "true or false", int: "a whole number", float: "a number with a point"}
        bounds = "" if self.low is None or self.high is None else f" from {self.low:g} to {self.high:g}"
        return f"{kind[type(self.default)]}{bounds}, such as {self.default!r}"

    def descriptor(self) -> ParameterDescriptor:
        """Return the rclpy descriptor; every parameter is read once, at start, and read-only from then on."""
        descriptor = ParameterDescriptor(name=self.name, description=self.description, read_only=True)
        if self.low is None or self.high is None:
            return descriptor
        if isinstance(self.default, float):
            descriptor.floating_point_range = [FloatingPointRange(from_value=self.low, to_value=self.high, step=0.0)]
        else:
            descriptor.integer_range = [IntegerRange(from_value=int(self.low), to_value=int(self.high), step=0)]
        return descriptor


def declare(node: Node, parameters: Sequence[Parameter]) -> dict[str, Any]:
    """Declare `parameters` on `node` and return their values by name.

    Raises StartError, one sentence, for a value of the wrong type or outside its range.
    """
    return {p.name: _declare(node, p) for p in parameters}


def _declare(node: Node, parameter: Parameter) -> Any:
    try:
        return node.declare_parameter(parameter.name, parameter.default, parameter.descriptor()).value
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise StartError(
            f"The parameter {parameter.name} cannot be used ({error}); expected {parameter.expected}."
        ) from error
