"""Parameter values, their types, and the checks a descriptor asks for."""

from __future__ import annotations

import array
import math
from enum import Enum
from typing import Any

from seat_gear_dynamics.runtime.messages import get_message

PARAMETER_SEPARATOR_STRING = "."

REL_TOL = 1e-6
"""Relative tolerance of comparisons with a floating-point range, as rclpy's."""

_FIELDS = {
    1: "bool_value",
    2: "integer_value",
    3: "double_value",
    4: "string_value",
    5: "byte_array_value",
    6: "bool_array_value",
    7: "integer_array_value",
    8: "double_array_value",
    9: "string_array_value",
}
"""Field of rcl_interfaces/ParameterValue that holds a value, by type."""

_ELEMENTS: dict[int, type] = {5: bytes, 6: bool, 7: int, 8: float, 9: str}
_SINGLES: dict[int, type] = {1: bool, 2: int, 3: float, 4: str}


class ParameterType(Enum):
    """Types of parameters, numbered as in rcl_interfaces/ParameterType."""

    NOT_SET = 0
    BOOL = 1
    INTEGER = 2
    DOUBLE = 3
    STRING = 4
    BYTE_ARRAY = 5
    BOOL_ARRAY = 6
    INTEGER_ARRAY = 7
    DOUBLE_ARRAY = 8
    STRING_ARRAY = 9

    @classmethod
    def from_parameter_value(cls, parameter_value: Any) -> ParameterType:
        """Return the type of a Python value; an empty list counts as bytes, as in rclpy.

        Raises:
            TypeError: a parameter cannot hold such a value.
        """
        if parameter_value is None:
            return cls.NOT_SET
        for number, kind in _SINGLES.items():
            if isinstance(parameter_value, kind):
                return cls(number)
        if isinstance(parameter_value, (list, tuple, array.array)):
            for number, kind in _ELEMENTS.items():
                if all(isinstance(value, kind) for value in parameter_value):
                    return cls(number)
            raise TypeError(f"The given value is not a list of one of the allowed types '{parameter_value}'.")
        raise TypeError(f"The given value is not one of the allowed types '{parameter_value}'.")

    def check(self, parameter_value: Any) -> bool:
        """Return whether a Python value is of this type."""
        if self is ParameterType.NOT_SET:
            return parameter_value is None
        if self.value in _SINGLES:
            return isinstance(parameter_value, _SINGLES[self.value])
        if not isinstance(parameter_value, (list, tuple, array.array)):
            return False
        kind = _ELEMENTS[self.value]
        if kind is bytes:
            return all(isinstance(value, bytes) and len(value) == 1 for value in parameter_value)
        return all(isinstance(value, kind) for value in parameter_value)


class Parameter:
    """A named value of one of the parameter types."""

    Type = ParameterType

    def __init__(self, name: str, type_: ParameterType | None = None, value: Any = None) -> None:
        if type_ is None:
            type_ = ParameterType.from_parameter_value(value)
        if not isinstance(type_, ParameterType):
            raise TypeError(f"type must be an instance of '{ParameterType!r}'")
        if not type_.check(value):
            raise ValueError(f"Type '{type_}' and value '{value}' do not agree")
        self._type_ = type_
        self._name = name
        self._value = value

    def __repr__(self) -> str:
        return f"Parameter({self._name!r}, {self._type_}, {self._value!r})"

    @property
    def name(self) -> str:
        """Name, with dots between namespaces."""
        return self._name

    @property
    def type_(self) -> ParameterType:
        """Type of the value."""
        return self._type_

    @property
    def value(self) -> Any:
        """The value, None if not set."""
        return self._value

    @classmethod
    def from_parameter_msg(cls, param_msg: Any) -> Parameter:
        """Return the parameter of an rcl_interfaces/Parameter."""
        type_ = ParameterType(param_msg.value.type)
        field = _FIELDS.get(type_.value)
        value = getattr(param_msg.value, field) if field else None
        return cls(param_msg.name, type_, value)

    def get_parameter_value(self) -> Any:
        """Return the value as rcl_interfaces/ParameterValue."""
        message = get_message("rcl_interfaces/msg/ParameterValue")(type=self._type_.value)
        if self._type_ is not ParameterType.NOT_SET:
            setattr(message, _FIELDS[self._type_.value], self._value)
        return message

    def to_parameter_msg(self) -> Any:
        """Return this as rcl_interfaces/Parameter."""
        return get_message("rcl_interfaces/msg/Parameter")(name=self._name, value=self.get_parameter_value())


def parameter_value_to_python(parameter_value: Any) -> Any:
    """Return the Python value of an rcl_interfaces/ParameterValue, None if not set.

    Raises:
        RuntimeError: its type is not one of the parameter types.
    """
    if parameter_value.type == 0:
        return None
    if parameter_value.type not in _FIELDS:
        raise RuntimeError(f"unexpected parameter type {parameter_value.type}")
    value = getattr(parameter_value, _FIELDS[parameter_value.type])
    return list(value) if parameter_value.type in _ELEMENTS else value


def refusal(parameter: Parameter, descriptor: Any, declared: bool, check_read_only: bool) -> str:
    """Return why a descriptor refuses a value, "" if it does not; the texts are rclpy's."""
    if check_read_only and descriptor.read_only:
        return f"Trying to set a read-only parameter: {parameter.name}."
    if not descriptor.dynamic_typing:
        if declared and parameter.type_ is ParameterType.NOT_SET:
            return "Static parameter cannot be undeclared"
        if parameter.type_ is not ParameterType.NOT_SET and parameter.type_.value != descriptor.type:
            expected = ParameterType(descriptor.type)
            return f"Wrong parameter type, expected 'Type.{expected.name}' got 'Type.{parameter.type_.name}'"
    if parameter.type_ is ParameterType.INTEGER and descriptor.integer_range:
        return _integer_refusal(parameter, descriptor.integer_range[0])
    if parameter.type_ is ParameterType.DOUBLE and descriptor.floating_point_range:
        return _double_refusal(parameter, descriptor.floating_point_range[0])
    return ""


def _integer_refusal(parameter: Parameter, bounds: Any) -> str:
    low, high = sorted((bounds.from_value, bounds.to_value))
    value = parameter.value
    # The edges are valid even where they are not a whole number of steps apart.
    if value in (low, high):
        return ""
    if not low < value < high:
        return f"Parameter {parameter.name} out of range. Min: {low}, Max: {high}, value: {value}"
    if bounds.step and (value - low) % bounds.step:
        return (
            f"The parameter value for {parameter.name} is not a valid step. "
            f"Min: {low}, max: {high}, value: {value}, step: {bounds.step}"
        )
    return ""


def _double_refusal(parameter: Parameter, bounds: Any) -> str:
    low, high = sorted((bounds.from_value, bounds.to_value))
    value = parameter.value
    if any(math.isclose(value, edge, rel_tol=REL_TOL) for edge in (low, high)):
        return ""
    if not low < value < high:
        return f"Parameter {parameter.name} out of range Min: {low}, Max: {high}, value: {value}"
    if bounds.step:
        nearest = low + round((value - low) / bounds.step) * bounds.step
        if not math.isclose(nearest, value, rel_tol=REL_TOL):
            return (
                f"The parameter value for {parameter.name} is not close enough to a valid step. "
                f"Min: {low}, max: {high}, value: {value}, step: {bounds.step}"
            )
    return ""
