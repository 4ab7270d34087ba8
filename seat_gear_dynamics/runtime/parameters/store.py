"""Declare, read and describe parameters: a part of the node."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

from seat_gear_dynamics.runtime.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.names import validate_parameter_name
from seat_gear_dynamics.runtime.parameters.parameter import PARAMETER_SEPARATOR_STRING, Parameter, ParameterType
from seat_gear_dynamics.runtime.parameters.setting import ParameterSetting, new_descriptor


class ParameterStore(ParameterSetting):
    """The part of a node that declares and reads its parameters."""

    # Declaring ---------------------------------------------------------------------------------------------

    def declare_parameter(
        self, name: str, value: Any = None, descriptor: Any = None, ignore_override: bool = False
    ) -> Parameter:
        """Declare a parameter with a default value (or a `Parameter.Type`) and return it as it then is.

        Raises:
            ParameterAlreadyDeclaredException: it is declared already.
            InvalidParameterException: the name is invalid.
            InvalidParameterTypeException, InvalidParameterValueException: the value, which may be an override
                from the command line, is refused.
        """
        if value is None and descriptor is None:
            return self.declare_parameters("", [(name,)], ignore_override)[0]
        given = new_descriptor() if descriptor is None else descriptor
        return self.declare_parameters("", [(name, value, given)], ignore_override)[0]

    def declare_parameters(
        self, namespace: str, parameters: Sequence[tuple[Any, ...]], ignore_override: bool = False
    ) -> list[Parameter]:
        """Declare parameters given as (name, value or type, descriptor), the last two optional.

        Raises:
            TypeError: a tuple has another form.
            ParameterAlreadyDeclaredException and the others of `declare_parameter`.
        """
        declared: list[Parameter] = []
        descriptors: dict[str, Any] = {}
        for index, entry in enumerate(parameters):
            name, value, descriptor = _unpack_declaration(index, entry, namespace)
            if not ignore_override and name in self._parameter_overrides:
                value = self._parameter_overrides[name].value
            declared.append(Parameter(name, value=value))
            descriptors[name] = descriptor
        twice = [parameter.name for parameter in declared if parameter.name in self._parameters]
        if twice:
            raise ParameterAlreadyDeclaredException(twice)
        for parameter in declared:
            self._rt_declare(parameter, descriptors)
        return [self._parameters[parameter.name] for parameter in declared]

    def _rt_declare(self, parameter: Parameter, descriptors: dict[str, Any]) -> None:
        result = self._rt_store([parameter], descriptors, keep_unset=True)
        if result.successful:
            return
        if result.reason.startswith("Wrong parameter type"):
            expected = ParameterType(descriptors[parameter.name].type).name
            raise InvalidParameterTypeException(parameter, expected)
        raise InvalidParameterValueException(parameter.name, parameter.value, result.reason)

    def undeclare_parameter(self, name: str) -> None:
        """Forget a parameter.

        Raises:
            ParameterNotDeclaredException: it was not declared.
            ParameterImmutableException: it is read-only.
        """
        if name not in self._parameters:
            raise ParameterNotDeclaredException(name)
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        del self._parameters[name], self._descriptors[name]

    # Reading -----------------------------------------------------------------------------------------------

    def has_parameter(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return name in self._parameters

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter.

        Raises:
            ParameterNotDeclaredException: it was not declared, and undeclared ones are not allowed.
            ParameterUninitializedException: it was declared with a type only and has no value yet.
        """
        parameter = self._parameters.get(name)
        if parameter is None:
            if self._allow_undeclared_parameters:
                return Parameter(name, ParameterType.NOT_SET, None)
            raise ParameterNotDeclaredException(name)
        if parameter.type_ is ParameterType.NOT_SET and not self._descriptors[name].dynamic_typing:
            raise ParameterUninitializedException(name)
        return parameter

    def get_parameters(self, names: list[str]) -> list[Parameter]:
        """Return parameters; see `get_parameter`."""
        if not all(isinstance(name, str) for name in names):
            raise TypeError("All names must be instances of type str")
        return [self.get_parameter(name) for name in names]

    def get_parameter_type(self, name: str) -> int:
        """Return the number of a parameter's type; see `get_parameter` for errors."""
        if name in self._parameters:
            number: int = self._parameters[name].type_.value
            return number
        if self._allow_undeclared_parameters:
            return ParameterType.NOT_SET.value
        raise ParameterNotDeclaredException(name)

    def get_parameter_types(self, names: list[str]) -> list[int]:
        """Return the numbers of parameters' types."""
        if not all(isinstance(name, str) for name in names):
            raise TypeError("All names must be instances of type str")
        return [self.get_parameter_type(name) for name in names]

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters below a prefix, by their names without it."""
        start = prefix + PARAMETER_SEPARATOR_STRING if prefix else ""
        return {name[len(start) :]: p for name, p in self._parameters.items() if name.startswith(start)}

    def list_parameters(self, prefixes: list[str], depth: int) -> Any:
        """Return an rcl_interfaces/ListParametersResult of names below prefixes, to a depth (0: any).

        Raises:
            TypeError, ValueError: an argument is of another type, or the depth is negative.
        """
        if not isinstance(prefixes, list):
            raise TypeError("The prefixes argument must be a list")
        if not all(isinstance(prefix, str) for prefix in prefixes):
            raise TypeError("All prefixes must be instances of type str")
        if not isinstance(depth, int):
            raise TypeError("The depth must be instance of type int")
        if depth < 0:
            raise ValueError("The depth must be greater than or equal to zero")
        result = get_message("rcl_interfaces/msg/ListParametersResult")()
        for name in self._parameters:
            if not _is_listed(name, prefixes, depth):
                continue
            result.names.append(name)
            parent = name.rpartition(PARAMETER_SEPARATOR_STRING)[0]
            if parent and parent not in result.prefixes:
                result.prefixes.append(parent)
        return result

    def describe_parameter(self, name: str) -> Any:
        """Return a parameter's rcl_interfaces/ParameterDescriptor.

        Raises:
            ParameterNotDeclaredException: it was not declared, and undeclared ones are not allowed.
        """
        if name in self._descriptors:
            return self._descriptors[name]
        if self._allow_undeclared_parameters:
            return new_descriptor()
        raise ParameterNotDeclaredException(name)

    def describe_parameters(self, names: list[str]) -> list[Any]:
        """Return parameters' descriptors; see `describe_parameter`."""
        return [self.describe_parameter(name) for name in names]

    def set_descriptor(self, name: str, descriptor: Any, alternative_value: Any = None) -> Any:
        """Give a parameter another descriptor, and the alternative value if it refuses the present one.

        Returns the value it then has. Raises ParameterNotDeclaredException, ParameterImmutableException, or
        InvalidParameterValueException where both values are refused.
        """
        if name not in self._parameters:
            if not self._allow_undeclared_parameters:
                raise ParameterNotDeclaredException(name)
            return self.get_parameter(name).get_parameter_value()
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        candidates = [self.get_parameter(name)]
        if alternative_value is not None:
            message = get_message("rcl_interfaces/msg/Parameter")(name=name, value=alternative_value)
            candidates.append(Parameter.from_parameter_msg(message))
        reason = ""
        for candidate in candidates:
            reason = self._rt_refusal(candidate, descriptor, check_read_only=False)
            if not reason:
                self._parameters[name] = candidate
                self._descriptors[name] = descriptor
                return candidate.get_parameter_value()
        raise InvalidParameterValueException(name, candidates[-1].value, reason)


def _unpack_declaration(index: int, entry: tuple[Any, ...], namespace: str) -> tuple[str, Any, Any]:
    """Return full name, value and descriptor, its type filled in, of one declaration."""
    if not 1 <= len(entry) <= 3:
        raise TypeError(
            f"Invalid parameter tuple length at index {index} in parameters list: {entry}; "
            "expecting length between 1 and 3"
        )
    name = entry[0]
    if not isinstance(name, str):
        raise TypeError(f"First element {name} at index {index} in parameters list is not a str.")
    name = f"{namespace}.{name}" if namespace else name
    validate_parameter_name(name)
    descriptor = entry[2] if len(entry) == 3 else new_descriptor()
    if not isinstance(descriptor, get_message("rcl_interfaces/msg/ParameterDescriptor")):
        raise TypeError(f"Third element {descriptor} at index {index} in parameters list is not a ParameterDescriptor.")
    if len(entry) == 1:
        warnings.warn(
            f"when declaring parameter named '{name}', declaring a parameter only providing its name is "
            "deprecated: pass a default value, a type, or a descriptor with `dynamic_typing=True`",
            stacklevel=4,
        )
        descriptor.dynamic_typing = True
    value = _typed_value(name, entry[1] if len(entry) > 1 else None, descriptor)
    return name, value, descriptor


def _typed_value(name: str, value: Any, descriptor: Any) -> Any:
    """Fill in the descriptor's type and return the default value, None where only a type was given."""
    if isinstance(value, ParameterType):
        if value is ParameterType.NOT_SET:
            raise ValueError(f"Cannot declare parameter {{{name}}} as statically typed of type NOT_SET")
        if descriptor.dynamic_typing:
            raise ValueError(
                f"When declaring parameter {{{name}}} passing a descriptor with `dynamic_typing=True` "
                "is not allowed when the parameter type is provided"
            )
        descriptor.type = value.value
        return None
    if not descriptor.dynamic_typing:
        descriptor.type = ParameterType.from_parameter_value(value).value
        if descriptor.type == 0:
            raise ValueError("Cannot declare a statically typed parameter with default value of type PARAMETER_NOT_SET")
    return value


def _is_listed(name: str, prefixes: list[str], depth: int) -> bool:
    """Return whether a name is below one of the prefixes (any, without prefixes), to a depth (0: any)."""

    def deep_enough(rest: str) -> bool:
        return depth == 0 or rest.count(PARAMETER_SEPARATOR_STRING) < depth

    if not prefixes:
        return deep_enough(name)
    return any(
        name == prefix
        or (name.startswith(prefix + PARAMETER_SEPARATOR_STRING) and deep_enough(name[len(prefix) + 1 :]))
        for prefix in prefixes
    )
