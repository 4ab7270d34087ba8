"""The node: its names, its start and end, its logger, clock and parameters; it owns its entities."""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime import arguments, logging
from seat_gear_dynamics.runtime.absent import sentence, unsupported
from seat_gear_dynamics.runtime.clock import ROSClock
from seat_gear_dynamics.runtime.context import Context, get_default_context
from seat_gear_dynamics.runtime.endpoints import Publisher
from seat_gear_dynamics.runtime.exceptions import NotInitializedException
from seat_gear_dynamics.runtime.graph_queries import GraphQueries
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.names import (
    expand_topic_name,
    validate_namespace,
    validate_node_name,
    validate_topic_name,
)
from seat_gear_dynamics.runtime.node_entities import EntityOwner
from seat_gear_dynamics.runtime.parameters.parameter import Parameter
from seat_gear_dynamics.runtime.parameters.services import ParameterService
from seat_gear_dynamics.runtime.parameters.store import ParameterStore
from seat_gear_dynamics.runtime.qos import (
    qos_profile_parameter_events,
    qos_profile_rosout,
)
from seat_gear_dynamics.runtime.time import S_TO_NS
from seat_gear_dynamics.runtime.time_source import TimeSource

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.executor import Executor

_ABSENT = frozenset(
    (
        "add_waitable",
        "create_guard_condition",
        "destroy_guard_condition",
        "get_node_names_and_namespaces_with_enclaves",
        "guards",
        "handle",
        "remove_waitable",
        "waitables",
    )
)
"""Names a real rclpy node has and this one lacks."""


class Node(EntityOwner, ParameterStore, GraphQueries):
    """A node of the ROS graph."""

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: list[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        start_parameter_services: bool = True,
        parameter_overrides: list[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        if enable_logger_service:
            raise unsupported("enable_logger_service", True, False)
        self._context = get_default_context() if context is None else context
        if not self._context.ok():
            raise NotInitializedException("cannot create node")
        self._rt_arguments = self._rt_merge_arguments(cli_args, use_global_arguments)
        self._rt_take_names(node_name, namespace or "")
        self._rt_init_entities()
        self._rt_executor: weakref.ReferenceType[Executor] | None = None
        self._rt_destroyed = False
        self._clock = ROSClock()
        self._logger = logging.get_logger(self.get_fully_qualified_name().lstrip("/").replace("/", "."))
        self._parameter_event_publisher: Publisher | None = None
        overrides = self._rt_overrides(parameter_overrides)
        self._rt_init_parameters(overrides, allow_undeclared_parameters)
        graph = self._context._graph_opened
        with graph.one_announcement():
            self._rt_entry = graph.add_node(self._rt_name, self._rt_namespace)
            self._context._node_created()
            self._rt_start(enable_rosout, start_parameter_services)
            if automatically_declare_parameters_from_overrides:
                self._rt_declare_overrides(overrides)
            self._time_source = TimeSource(self, self._clock)

    def _rt_merge_arguments(self, cli_args: list[str] | None, use_global: bool) -> arguments.Arguments:
        """Return the node's own arguments, those of the command line after them."""
        local = arguments.parse(["--ros-args", *cli_args] if cli_args else [])
        if not use_global:
            return local
        everywhere = self._context._arguments
        return arguments.Arguments(
            rules=[*local.rules, *everywhere.rules],
            overrides=[*everywhere.overrides, *local.overrides],
            rosout=everywhere.rosout and local.rosout,
        )

    def _rt_take_names(self, node_name: str, namespace: str) -> None:
        validate_node_name(node_name)
        absolute = namespace if namespace.startswith("/") else f"/{namespace}"
        validate_namespace(absolute)
        self._rt_name = self._rt_arguments.remap_node(node_name)
        self._rt_namespace = self._rt_arguments.remap_namespace(self._rt_name, absolute)
        validate_node_name(self._rt_name)
        validate_namespace(self._rt_namespace)

    def _rt_overrides(self, given: list[Parameter] | None) -> dict[str, Parameter]:
        values = self._rt_arguments.parameters_for(self.get_fully_qualified_name())
        found = {name: Parameter(name, value=value) for name, value in values.items()}
        found.update({parameter.name: parameter for parameter in given or ()})
        return found

    def _rt_start(self, enable_rosout: bool, start_parameter_services: bool) -> None:
        event = get_message("rcl_interfaces/msg/ParameterEvent")
        self._parameter_event_publisher = self.create_publisher(
            event, "/parameter_events", qos_profile_parameter_events
        )
        if enable_rosout and self._rt_arguments.rosout:
            self._rt_start_rosout()
        self._parameter_service = ParameterService(self) if start_parameter_services else None

    def _rt_start_rosout(self) -> None:
        message_class = get_message("rcl_interfaces/msg/Log")
        stamp_class = get_message("builtin_interfaces/msg/Time")
        publisher = self.create_publisher(message_class, "/rosout", qos_profile_rosout)

        def publish(record: dict[str, Any]) -> None:
            if not self._context._sends() or self._rt_destroyed:
                return
            seconds, nanoseconds = divmod(record.pop("now_ns"), S_TO_NS)
            stamp = stamp_class(sec=seconds, nanosec=nanoseconds)
            publisher.publish(message_class(stamp=stamp, **record))

        logging.add_sink(self._logger.name, publish)

    def _rt_declare_overrides(self, overrides: dict[str, Parameter]) -> None:
        descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
        entries = [(name, parameter.value, descriptor()) for name, parameter in overrides.items()]
        self.declare_parameters("", entries, ignore_override=True)

    def __getattr__(self, name: str) -> Any:
        if name in _ABSENT:
            raise AttributeError(sentence(f"rclpy.node.Node.{name}"))
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    # What the node is and has ------------------------------------------------------------------------------

    def get_name(self) -> str:
        """Return the node's name, remapping applied."""
        return self._rt_name

    def get_namespace(self) -> str:
        """Return the node's namespace, "/" at the root."""
        return self._rt_namespace

    def get_fully_qualified_name(self) -> str:
        """Return namespace and name, such as "/bench/gear_monitor"."""
        return f"{self._rt_namespace.rstrip('/')}/{self._rt_name}"

    def get_clock(self) -> ROSClock:
        """Return the node's clock, which follows /clock while `use_sim_time` is true."""
        return self._clock

    def get_logger(self) -> logging.RcutilsLogger:
        """Return the node's logger."""
        return self._logger

    @property
    def context(self) -> Context:
        """Context of the node."""
        return self._context

    @property
    def executor(self) -> Executor | None:
        """Executor that runs the node's callbacks, if any."""
        return self._rt_executor() if self._rt_executor is not None else None

    @executor.setter
    def executor(self, new_executor: Executor | None) -> None:
        current = self.executor
        if current is new_executor:
            return
        if current is not None:
            current.remove_node(self)
        self._rt_executor = None if new_executor is None else weakref.ref(new_executor)
        if new_executor is not None:
            new_executor.add_node(self)

    def _rt_changed(self) -> None:
        executor = self.executor
        if executor is not None:
            executor._entities_changed()

    def _rt_wake(self) -> None:
        executor = self.executor
        if executor is not None:
            executor.wake()

    # Names -------------------------------------------------------------------------------------------------

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a topic, remapped unless `only_expand`.

        Raises:
            InvalidTopicNameException: the name is invalid.
        """
        return self._rt_resolve(topic, "topic", only_expand)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a service, remapped unless `only_expand`.

        Raises:
            InvalidServiceNameException: the name is invalid.
        """
        return self._rt_resolve(service, "service", only_expand)

    def _rt_resolve(self, name: str, kind: str, only_expand: bool) -> str:
        validate_topic_name(name, is_service=kind == "service")
        full = expand_topic_name(name, self._rt_name, self._rt_namespace)
        return full if only_expand else self._rt_arguments.remap(full, self._rt_name, self._rt_namespace, kind)

    def destroy_node(self) -> None:
        """Destroy the node and everything it owns; doing it again does nothing."""
        if self._rt_destroyed:
            return
        self._rt_destroyed = True
        logging.remove_sink(self._logger.name)
        self._parameter_event_publisher = None
        graph = self._context._graph_if_open
        self._rt_destroy_entities(leave=graph is not None)
        if graph is not None:
            graph.remove_node(self._rt_entry)
        executor = self.executor
        if executor is not None:
            executor.remove_node(self)
        self._context._node_destroyed()

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *exception: object) -> None:
        self.destroy_node()
