"""The six services through which others read and set a node's parameters."""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.exceptions import ParameterNotDeclaredException, ParameterUninitializedException
from seat_gear_dynamics.runtime.messages import get_message, get_service
from seat_gear_dynamics.runtime.parameters.parameter import Parameter
from seat_gear_dynamics.runtime.qos import qos_profile_parameters

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.node import Node


class ParameterService:
    """Answers get, set, list and describe requests of `ros2 param` and of other nodes."""

    def __init__(self, node: Node) -> None:
        self._node_weak_ref = weakref.ref(node)
        for short, callback in (
            ("DescribeParameters", self._describe),
            ("GetParameters", self._get),
            ("GetParameterTypes", self._types),
            ("ListParameters", self._list),
            ("SetParameters", self._set),
            ("SetParametersAtomically", self._set_atomically),
        ):
            node.create_service(
                get_service(f"rcl_interfaces/srv/{short}"),
                f"~/{_snake(short)}",
                callback,
                qos_profile=qos_profile_parameters,
            )

    @property
    def _node(self) -> Node:
        node = self._node_weak_ref()
        if node is None:
            raise ReferenceError("Expected valid node weak reference")
        return node

    def _describe(self, request: Any, response: Any) -> Any:
        try:
            response.descriptors = self._node.describe_parameters(list(request.names))
        except ParameterNotDeclaredException:
            response.descriptors = []
        return response

    def _get(self, request: Any, response: Any) -> Any:
        try:
            response.values = [p.get_parameter_value() for p in self._node.get_parameters(list(request.names))]
        except (ParameterNotDeclaredException, ParameterUninitializedException):
            response.values = []
        return response

    def _types(self, request: Any, response: Any) -> Any:
        try:
            response.types = self._node.get_parameter_types(list(request.names))
        except ParameterNotDeclaredException:
            response.types = []
        return response

    def _list(self, request: Any, response: Any) -> Any:
        response.result = self._node.list_parameters(list(request.prefixes), request.depth)
        return response

    def _set(self, request: Any, response: Any) -> Any:
        response.results = [self._try_to_set([message]) for message in request.parameters]
        return response

    def _set_atomically(self, request: Any, response: Any) -> Any:
        response.result = self._try_to_set(request.parameters)
        return response

    def _try_to_set(self, messages: list[Any]) -> Any:
        refused = get_message("rcl_interfaces/msg/SetParametersResult")
        try:
            parameters = [Parameter.from_parameter_msg(message) for message in messages]
        except ValueError as error:
            return refused(successful=False, reason=str(error))
        # What a callback of the node raises is a fault of the node: it comes out of spin, as in rclpy.
        try:
            return self._node.set_parameters_atomically(parameters)
        except ParameterNotDeclaredException as error:
            return refused(successful=False, reason=str(error))


def _snake(name: str) -> str:
    """Return "GetParameterTypes" as "get_parameter_types"."""
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")
