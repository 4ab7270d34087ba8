"""Make and own service servers and clients: a part of the node."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterator
from typing import Any

from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from seat_gear_dynamics.runtime.interfaces import type_hash
from seat_gear_dynamics.runtime.logging import RcutilsLogger
from seat_gear_dynamics.runtime.messages import check_service_class
from seat_gear_dynamics.runtime.names import dds_topic
from seat_gear_dynamics.runtime.qos import QoSProfile, qos_profile_services_default
from seat_gear_dynamics.runtime.services import Client, Service
from seat_gear_dynamics.runtime.wire.qos import dds_qos


class ServiceOwner:
    """The part of a node that makes and owns its services and clients."""

    _context: Context
    _logger: RcutilsLogger

    def _rt_init_services(self) -> None:
        self._services: list[Service] = []
        self._clients: list[Client] = []
        self._default_callback_group: CallbackGroup = MutuallyExclusiveCallbackGroup()

    def _rt_changed(self) -> None:
        raise NotImplementedError

    def _rt_announce(self, readers: list[bytes] | None = None, writers: list[bytes] | None = None) -> None:
        raise NotImplementedError

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a service, remapped unless `only_expand`."""
        raise NotImplementedError

    @property
    def default_callback_group(self) -> CallbackGroup:
        """Group of entities made without one."""
        return self._default_callback_group

    @property
    def services(self) -> Iterator[Service]:
        """The node's services."""
        yield from tuple(self._services)

    @property
    def clients(self) -> Iterator[Client]:
        """The node's clients."""
        yield from tuple(self._clients)

    def create_service(
        self,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Service:
        """Offer a service; the callback takes request and response and returns the response.

        Raises:
            TypeError: the type is not a service class.
            InvalidServiceNameException: the name is invalid.
        """
        check_service_class(srv_type)
        name = self.resolve_service_name(srv_name)
        reader, writer = self._rt_service_endpoints("serviceid", srv_type, name, qos_profile)
        group = callback_group or self._default_callback_group
        service = Service(
            reader=reader,
            writer=writer,
            srv_type=srv_type,
            srv_name=srv_name,
            name=name,
            callback=callback,
            callback_group=group,
            qos=qos_profile,
            logger_name=self._logger.name,
        )
        group.add_entity(service)
        self._services.append(service)
        self._rt_announce(readers=[reader.gid()], writers=[writer.gid()])
        return service

    def create_client(
        self,
        srv_type: Any,
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client:
        """Make a client of a service; errors as in `create_service`."""
        check_service_class(srv_type)
        name = self.resolve_service_name(srv_name)
        reader, writer = self._rt_service_endpoints("clientid", srv_type, name, qos_profile)
        group = callback_group or self._default_callback_group
        client = Client(
            context=self._context,
            reader=reader,
            writer=writer,
            srv_type=srv_type,
            srv_name=srv_name,
            name=name,
            callback_group=group,
            qos=qos_profile,
        )
        group.add_entity(client)
        self._clients.append(client)
        self._rt_announce(readers=[reader.gid()], writers=[writer.gid()])
        return client

    def _rt_service_endpoints(self, role: str, srv_type: Any, name: str, qos: QoSProfile) -> tuple[Any, Any]:
        """Return the reader and writer of a server or client, which tell their peers that they belong together."""
        request, response = srv_type.Request.FULL_NAME, srv_type.Response.FULL_NAME
        ends = [(dds_topic(name, "rq", "Request"), request), (dds_topic(name, "rr", "Reply"), response)]
        if role == "clientid":
            ends.reverse()
        identity = f"{role}={secrets.token_hex(12)};"
        participant = self._context._participant
        made = []
        for make, (topic, type_name) in zip((participant.reader, participant.writer), ends, strict=True):
            policies = dds_qos(qos, f"{identity}typehash={type_hash(type_name)};")
            made.append(make(topic, type_name, policies, request_header=True))
        return made[0], made[1]
