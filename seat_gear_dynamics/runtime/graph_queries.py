"""What a node can ask about the ROS graph: names, types, counts and endpoints."""

from __future__ import annotations

import time
from collections.abc import Iterable
from enum import IntEnum
from typing import Any

from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.graph import Endpoint, Graph
from seat_gear_dynamics.runtime.names import dds_topic, expand_topic_name, ros_service, ros_topic, validate_topic_name
from seat_gear_dynamics.runtime.qos import QoSProfile

NamesAndTypes = list[tuple[str, list[str]]]


class NodeNameNonExistentError(RuntimeError):
    """The node asked about is not on the network."""


class TopicEndpointTypeEnum(IntEnum):
    """Kinds of endpoint."""

    INVALID = 0
    PUBLISHER = 1
    SUBSCRIPTION = 2


class TopicEndpointInfo:
    """A publisher or subscription on a topic: its node, type, gid and QoS."""

    def __init__(self, **kwargs: Any) -> None:
        self.node_name: str = kwargs.get("node_name", "")
        self.node_namespace: str = kwargs.get("node_namespace", "")
        self.topic_type: str = kwargs.get("topic_type", "")
        self.topic_type_hash: str = kwargs.get("topic_type_hash", "")
        self.endpoint_type: TopicEndpointTypeEnum = kwargs.get("endpoint_type", TopicEndpointTypeEnum.INVALID)
        self.endpoint_gid: list[int] = kwargs.get("endpoint_gid", [])
        self.qos_profile: QoSProfile = kwargs.get("qos_profile") or QoSProfile(depth=0)

    def __repr__(self) -> str:
        return f"TopicEndpointInfo({', '.join(f'{k}={v!r}' for k, v in vars(self).items())})"


class GraphQueries:
    """The part of a node that looks at the graph."""

    _context: Context

    def get_name(self) -> str:
        """Return the node's name."""
        raise NotImplementedError

    def get_namespace(self) -> str:
        """Return the node's namespace, "/" at the root."""
        raise NotImplementedError

    @property
    def _rt_graph(self) -> Graph:
        return self._context._graph_opened

    def _rt_expand(self, name: str, is_service: bool = False) -> str:
        validate_topic_name(name, is_service=is_service)
        return expand_topic_name(name, self.get_name(), self.get_namespace())

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic has anywhere; the name is not remapped."""
        return len(self._rt_graph.on_topic("writer", dds_topic(self._rt_expand(topic_name))))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic has anywhere; the name is not remapped."""
        return len(self._rt_graph.on_topic("reader", dds_topic(self._rt_expand(topic_name))))

    def count_clients(self, service_name: str) -> int:
        """Return how many clients a service has anywhere."""
        topic = dds_topic(self._rt_expand(service_name, True), "rq", "Request")
        return len(self._rt_graph.on_topic("writer", topic))

    def count_services(self, service_name: str) -> int:
        """Return how many servers a service has anywhere."""
        topic = dds_topic(self._rt_expand(service_name, True), "rq", "Request")
        return len(self._rt_graph.on_topic("reader", topic))

    def get_topic_names_and_types(self, no_demangle: bool = False) -> NamesAndTypes:
        """Return every topic on the network with its types; `no_demangle` gives DDS's own names."""
        endpoints = (*self._rt_graph.endpoints("writer"), *self._rt_graph.endpoints("reader"))
        return _topics(endpoints, no_demangle)

    def get_service_names_and_types(self) -> NamesAndTypes:
        """Return every service on the network with its types."""
        return _services(self._rt_graph.endpoints("reader"), "Request")

    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """Return the topics a node publishes; NodeNameNonExistentError if there is no such node."""
        return _topics(self._rt_owned("writer", node_name, node_namespace), no_demangle)

    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """Return the topics a node subscribes to; NodeNameNonExistentError if there is no such node."""
        return _topics(self._rt_owned("reader", node_name, node_namespace), no_demangle)

    def get_service_names_and_types_by_node(self, node_name: str, node_namespace: str) -> NamesAndTypes:
        """Return the services a node offers; NodeNameNonExistentError if there is no such node."""
        return _services(self._rt_owned("reader", node_name, node_namespace), "Request")

    def get_client_names_and_types_by_node(self, node_name: str, node_namespace: str) -> NamesAndTypes:
        """Return the services a node calls; NodeNameNonExistentError if there is no such node."""
        return _services(self._rt_owned("reader", node_name, node_namespace), "Reply")

    def _rt_owned(self, kind: str, node_name: str, namespace: str) -> list[Endpoint]:
        found = self._rt_graph.owned_by(kind, node_name, namespace)
        if found is None:
            full = f"{namespace.rstrip('/')}/{node_name}"
            raise NodeNameNonExistentError(f"There is no node {full!r} on the network: check its name.")
        return found

    def get_node_names(self) -> list[str]:
        """Return the names of all nodes on the network."""
        return [name for name, _ in self._rt_graph.nodes()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return name and namespace of all nodes on the network."""
        return self._rt_graph.nodes()

    def get_fully_qualified_node_names(self) -> list[str]:
        """Return the full names of all nodes on the network."""
        return [f"{namespace.rstrip('/')}/{name}" for name, namespace in self._rt_graph.nodes()]

    def get_publishers_info_by_topic(self, topic_name: str, no_mangle: bool = False) -> list[TopicEndpointInfo]:
        """Return what is known of the publishers on a topic."""
        return self._rt_endpoint_info("writer", topic_name, no_mangle)

    def get_subscriptions_info_by_topic(self, topic_name: str, no_mangle: bool = False) -> list[TopicEndpointInfo]:
        """Return what is known of the subscriptions on a topic."""
        return self._rt_endpoint_info("reader", topic_name, no_mangle)

    def _rt_endpoint_info(self, kind: str, topic_name: str, no_mangle: bool) -> list[TopicEndpointInfo]:
        topic = topic_name if no_mangle else dds_topic(self._rt_expand(topic_name))
        role = TopicEndpointTypeEnum.PUBLISHER if kind == "writer" else TopicEndpointTypeEnum.SUBSCRIPTION
        found = []
        for endpoint in self._rt_graph.on_topic(kind, topic):
            name, namespace = self._rt_graph.owner(endpoint.gid)
            found.append(
                TopicEndpointInfo(
                    node_name=name,
                    node_namespace=namespace,
                    topic_type=endpoint.type_name,
                    topic_type_hash=endpoint.type_hash,
                    endpoint_type=role,
                    endpoint_gid=list(endpoint.gid),
                    qos_profile=endpoint.profile,
                )
            )
        return found

    def wait_for_node(self, fully_qualified_node_name: str, timeout: float) -> bool:
        """Wait up to a time in seconds until a node is on the network; return whether it is."""
        wanted = f"/{fully_qualified_node_name.lstrip('/')}"
        end = time.monotonic() + timeout
        while wanted not in self.get_fully_qualified_node_names():
            if time.monotonic() >= end:
                return False
            time.sleep(0.02)
        return True


def _topics(endpoints: Iterable[Endpoint], no_demangle: bool) -> NamesAndTypes:
    found: dict[str, set[str]] = {}
    for endpoint in endpoints:
        name = endpoint.topic if no_demangle else ros_topic(endpoint.topic)
        if name is not None:
            found.setdefault(name, set()).add(endpoint.type_name)
    return [(name, sorted(types)) for name, types in sorted(found.items())]


def _services(endpoints: Iterable[Endpoint], suffix: str) -> NamesAndTypes:
    """Return services by the readers of their requests (servers) or replies (clients)."""
    found: dict[str, set[str]] = {}
    for endpoint in endpoints:
        name = ros_service(endpoint.topic)
        if name is not None and endpoint.topic.endswith(suffix):
            service_type = endpoint.type_name.removesuffix("_Request").removesuffix("_Response")
            found.setdefault(name, set()).add(service_type)
    return [(name, sorted(types)) for name, types in sorted(found.items())]
