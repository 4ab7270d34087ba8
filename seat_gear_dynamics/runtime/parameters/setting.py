"""Set parameters: checks, callbacks, all or nothing, and the events others hear of: a part of the node."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.exceptions import ParameterNotDeclaredException
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.parameters.parameter import REL_TOL, Parameter, ParameterType, refusal

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.clock import ROSClock
    from seat_gear_dynamics.runtime.endpoints import Publisher

_PreCallback = Callable[[list[Parameter]], list[Parameter]]
_OnCallback = Callable[[list[Parameter]], Any]
_PostCallback = Callable[[list[Parameter]], None]


def result_message(reason: str = "") -> Any:
    """Return a SetParametersResult, unsuccessful where a reason is given."""
    return get_message("rcl_interfaces/msg/SetParametersResult")(successful=not reason, reason=reason)


def new_descriptor() -> Any:
    """Return a ParameterDescriptor with its defaults."""
    return get_message("rcl_interfaces/msg/ParameterDescriptor")()


class ParameterSetting:
    """The part of a node that holds and sets its parameters."""

    PARAM_REL_TOL = REL_TOL
    _clock: ROSClock
    _parameter_event_publisher: Publisher | None

    def _rt_init_parameters(self, overrides: dict[str, Parameter], allow_undeclared: bool) -> None:
        self._parameters: dict[str, Parameter] = {}
        self._descriptors: dict[str, Any] = {}
        self._parameter_overrides = overrides
        self._allow_undeclared_parameters = allow_undeclared
        self._pre_set_parameters_callbacks: list[_PreCallback] = []
        self._on_set_parameters_callbacks: list[_OnCallback] = []
        self._post_set_parameters_callbacks: list[_PostCallback] = []

    def get_fully_qualified_name(self) -> str:
        """Return namespace and name of the node."""
        raise NotImplementedError

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Return a parameter, or the alternative if it is not declared or has no value."""
        parameter = self._parameters.get(name)
        if parameter is not None and parameter.type_ is not ParameterType.NOT_SET:
            return parameter
        return Parameter(name, ParameterType.NOT_SET) if alternative_value is None else alternative_value

    # Setting -----------------------------------------------------------------------------------------------

    def set_parameters(self, parameter_list: list[Parameter]) -> list[Any]:
        """Set parameters one after the other; return an rcl_interfaces/SetParametersResult for each.

        Raises:
            ParameterNotDeclaredException: one was not declared; those before it stay set.
        """
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> Any:
        """Set all parameters or none; return one rcl_interfaces/SetParametersResult.

        Raises:
            ParameterNotDeclaredException: one was not declared, and undeclared ones are not allowed.
        """
        if self._pre_set_parameters_callbacks:
            changed: list[Parameter] = []
            for callback in self._pre_set_parameters_callbacks:
                changed.extend(callback(parameter_list))
            if not changed:
                return result_message(
                    "parameter list cannot be empty, this might be due to pre_set_parameters_callback "
                    "modifying the original parameters list."
                )
            parameter_list = changed
        self._rt_require_declared(parameter_list)
        return self._rt_store(parameter_list, None, keep_unset=False)

    def _rt_require_declared(self, parameter_list: list[Parameter]) -> None:
        if not all(isinstance(parameter, Parameter) for parameter in parameter_list):
            raise TypeError(f"parameter must be instance of type '{Parameter!r}'")
        unknown = [p.name for p in parameter_list if p.name not in self._parameters]
        if unknown and not self._allow_undeclared_parameters:
            raise ParameterNotDeclaredException(unknown)

    def _rt_refusal(self, parameter: Parameter, descriptor: Any, check_read_only: bool) -> str:
        descriptor.name = parameter.name
        reason = refusal(parameter, descriptor, parameter.name in self._parameters, check_read_only)
        if descriptor.dynamic_typing and not reason:
            descriptor.type = parameter.type_.value
        return reason

    def _rt_store(self, parameters: list[Parameter], descriptors: dict[str, Any] | None, keep_unset: bool) -> Any:
        """Check and set all parameters or none; new `descriptors` come with a declaration."""
        known = self._descriptors if descriptors is None else descriptors
        for parameter in parameters:
            if parameter.name in known:
                reason = self._rt_refusal(parameter, known[parameter.name], descriptors is None)
                if reason:
                    return result_message(reason)
        for callback in self._on_set_parameters_callbacks:
            result = callback(parameters)
            if not result.successful:
                return result
        event = get_message("rcl_interfaces/msg/ParameterEvent")(node=self.get_fully_qualified_name())
        for parameter in parameters:
            self._rt_put(parameter, descriptors, keep_unset, event)
        event.stamp = self._clock.now().to_msg()
        if self._parameter_event_publisher is not None:
            self._parameter_event_publisher.publish(event)
        for after in self._post_set_parameters_callbacks:
            after(parameters)
        return result_message()

    def _rt_put(self, parameter: Parameter, descriptors: dict[str, Any] | None, keep_unset: bool, event: Any) -> None:
        name, message = parameter.name, parameter.to_parameter_msg()
        if not keep_unset and parameter.type_ is ParameterType.NOT_SET:
            event.deleted_parameters.append(message)
            self._parameters.pop(name, None)
            self._descriptors.pop(name, None)
            return
        if descriptors is not None:
            self._descriptors[name] = descriptors[name]
        elif name not in self._descriptors:
            self._descriptors[name] = new_descriptor()
            self._descriptors[name].name = name
            self._descriptors[name].dynamic_typing = True
        is_new = self.get_parameter_or(name).type_ is ParameterType.NOT_SET
        (event.new_parameters if is_new else event.changed_parameters).append(message)
        self._parameters[name] = parameter

    # Callbacks ---------------------------------------------------------------------------------------------

    def add_pre_set_parameters_callback(self, callback: _PreCallback) -> None:
        """Have a function change the list of parameters before it is checked."""
        self._pre_set_parameters_callbacks.insert(0, callback)

    def add_on_set_parameters_callback(self, callback: _OnCallback) -> None:
        """Have a function accept or refuse values with a SetParametersResult."""
        self._on_set_parameters_callbacks.insert(0, callback)

    def add_post_set_parameters_callback(self, callback: _PostCallback) -> None:
        """Have a function called after values were set."""
        self._post_set_parameters_callbacks.insert(0, callback)

    def remove_pre_set_parameters_callback(self, callback: _PreCallback) -> None:
        """Undo `add_pre_set_parameters_callback`; ValueError if it was not added."""
        self._pre_set_parameters_callbacks.remove(callback)

    def remove_on_set_parameters_callback(self, callback: _OnCallback) -> None:
        """Undo `add_on_set_parameters_callback`; ValueError if it was not added."""
        self._on_set_parameters_callbacks.remove(callback)

    def remove_post_set_parameters_callback(self, callback: _PostCallback) -> None:
        """Undo `add_post_set_parameters_callback`; ValueError if it was not added."""
        self._post_set_parameters_callbacks.remove(callback)
