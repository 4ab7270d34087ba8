"""Node parameters from one schema: their declaration, descriptors, checks, changes at run time and the docs' tables."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, Literal

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node

from seat_gear_dynamics.nodes.process import StartError

Value = str | bool | int | float
Change = Literal["start", "setup", "run"]

_KINDS = {str: "a text", bool: "true or false", int: "a whole number", float: "a number with a point"}
CHANGES: dict[Change, str] = {
    "start": "only when the node is started",
    "setup": "only while the node is unconfigured",
    "run": "at any time",
}
"""When a parameter may be changed, in words."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node; its default gives its type. A number has bounds, and both may be taken."""

    name: str
    default: Value
    description: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    change: Change = "start"

    def __post_init__(self) -> None:
        if self.numeric == (self.low is None or self.high is None):
            raise ValueError(f"The parameter {self.name} needs both bounds if it is a number, and none if it is not.")
        refusal = self.refusal(self.default)
        if refusal is not None:
            raise ValueError(f"The default is none that may be set: {refusal}")

    @property
    def numeric(self) -> bool:
        """Whether it is a number."""
        return isinstance(self.default, int | float) and not isinstance(self.default, bool)

    @property
    def kind(self) -> str:
        """Its type in words."""
        return _KINDS[type(self.default)]

    @property
    def expected(self) -> str:
        """What the parameter takes, in words, with its default as the example where it has no choices."""
        if self.choices:
            *first, last = (repr(choice) for choice in self.choices)
            return f"{', '.join(first)} or {last}" if first else last
        bounds = "" if self.low is None or self.high is None else f" from {self.low:g} to {self.high:g}"
        return f"{self.kind}{bounds}, such as {self.default!r}"

    def refusal(self, value: object) -> str | None:
        """Return a sentence where `value` cannot be taken, else None."""
        if type(value) is type(self.default) and self._within(value):
            return None
        return f"The parameter {self.name} is {value!r}, expected {self.expected}."

    def _within(self, value: Any) -> bool:
        if self.choices:
            return value in self.choices
        if self.low is None or self.high is None:
            return True
        return isfinite(value) and self.low <= value <= self.high

    def descriptor(self) -> ParameterDescriptor:
        """Return the rclpy descriptor: text, range, and read-only where only a start takes it."""
        notes = [f"one of {self.expected}"] if self.choices else []
        notes.append(f"may be changed {CHANGES[self.change]}")
        descriptor = ParameterDescriptor(
            name=self.name,
            description=self.description,
            additional_constraints="; ".join(notes),
            read_only=self.change == "start",
        )
        if self.low is None or self.high is None:
            return descriptor
        if isinstance(self.default, float):
            descriptor.floating_point_range = [FloatingPointRange(from_value=self.low, to_value=self.high, step=0.0)]
        else:
            descriptor.integer_range = [IntegerRange(from_value=int(self.low), to_value=int(self.high), step=0)]
        return descriptor


class Parameters(Mapping[str, Any]):
    """A node's parameters by name, each as it was last accepted.

    ROS 2 lets a number lie a millionth beyond its descriptor's range; here the check that a set runs through is the
    schema's own, so that both bounds are exact. A set of several is taken whole or refused with the first reason.
    """

    def __init__(
        self,
        node: Node,
        schema: Sequence[Parameter],
        *,
        locked: Callable[[], str | None] = lambda: None,
        applied: Callable[[], None] = lambda: None,
    ) -> None:
        """Declare `schema` on `node`; raises StartError, one sentence, for a value that cannot be taken.

        `locked` returns why what changes by `setup` cannot change now, or None; `applied` is called after a change.
        """
        self._schema = {parameter.name: parameter for parameter in schema}
        self._values: dict[str, Any] = {}
        self._locked, self._applied = locked, applied
        node.add_on_set_parameters_callback(self._judge)
        for parameter in schema:
            self._values[parameter.name] = _declare(node, parameter)
        node.add_post_set_parameters_callback(self._take)

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def _judge(self, given: Sequence[Any]) -> SetParametersResult:
        reasons = (self._reason(each.name, each.value) for each in given if each.name in self._schema)
        reason = next((found for found in reasons if found is not None), "")
        return SetParametersResult(successful=not reason, reason=reason)

    def _reason(self, name: str, value: object) -> str | None:
        parameter = self._schema[name]
        unchanged = name not in self._values or self._values[name] == value
        locked = None if unchanged or parameter.change != "setup" else self._locked()
        if locked is not None:
            return f"The parameter {name} may be changed {CHANGES['setup']}; {locked}."
        return parameter.refusal(value)

    def _take(self, given: Sequence[Any]) -> None:
        news = {each.name: each.value for each in given if each.name in self._schema}
        if any(self._values[name] != value for name, value in news.items()):
            self._values.update(news)
            self._applied()


def declare(node: Node, schema: Sequence[Parameter]) -> Parameters:
    """Declare `schema` on `node` and return its values by name; raises StartError as `Parameters` does."""
    return Parameters(node, schema)


def _declare(node: Node, parameter: Parameter) -> Any:
    try:
        return node.declare_parameter(parameter.name, parameter.default, parameter.descriptor()).value
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise StartError(
            f"The parameter {parameter.name} cannot be used ({error}); expected {parameter.expected}."
        ) from error
