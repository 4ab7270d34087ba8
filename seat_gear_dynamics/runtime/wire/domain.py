"""DDS domains: which one, how it is configured, and how long it stays."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from typing import Any

from seat_gear_dynamics.runtime.exceptions import RCLError
from seat_gear_dynamics.runtime.wire.library import delete

HIGHEST_DOMAIN = 232
"""Largest ROS_DOMAIN_ID whose UDP ports exist."""


CONFIGURATION = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface autodetermine="true"/>
<NetworkInterface name="lo" multicast="false"/></Interfaces></General><Discovery>
<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery>
<Internal><SocketReceiveBufferSize max="4MB"/></Internal></Domain></CycloneDDS>"""
"""Found by, and finding, ROS 2 nodes whatever their discovery range; used unless CYCLONEDDS_URI is set.

The system gives as much of the buffer as net.core.rmem_max allows; datagrams that find no room in it are dropped.
"""


LOOPBACK_ONLY = CONFIGURATION.replace('<NetworkInterface autodetermine="true"/>', "")
"""The same on a machine that has no network but loopback."""


def domain_id_from(environment: Mapping[str, str]) -> int:
    """Return the domain id ROS_DOMAIN_ID gives, 0 without one.

    Raises:
        RuntimeError: it is not a whole number from 0 to 232.
    """
    text = environment.get("ROS_DOMAIN_ID", "").strip()
    if not text:
        return 0
    if not text.isdecimal() or int(text) > HIGHEST_DOMAIN:
        raise RuntimeError(
            f"ROS_DOMAIN_ID is {text!r}, expected a whole number from 0 to {HIGHEST_DOMAIN}: "
            "set such a number or unset it."
        )
    return int(text)


class _Domains:
    """Keeps each domain's configuration alive as long as a participant of this process uses it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._used: dict[int, tuple[Any, int]] = {}

    def acquire(self, domain_id: int) -> None:
        """Configure a domain when its first participant comes."""
        with self._lock:
            entity, users = self._used.get(domain_id, (None, 0))
            if users == 0 and "CYCLONEDDS_URI" not in os.environ:
                entity = self._create(domain_id)
            self._used[domain_id] = (entity, users + 1)

    def release(self, domain_id: int) -> None:
        """Drop a domain when its last participant goes."""
        with self._lock:
            entity, users = self._used.pop(domain_id)
            if users > 1:
                self._used[domain_id] = (entity, users - 1)
            elif entity is not None:
                delete(entity)

    @staticmethod
    def _create(domain_id: int) -> Any:
        from cyclonedds.core import DDSException
        from cyclonedds.domain import Domain

        configuration = CONFIGURATION if has_network() else LOOPBACK_ONLY
        try:
            return Domain(domain_id, configuration)
        except DDSException as error:
            if error.code == DDSException.DDS_RETCODE_PRECONDITION_NOT_MET:
                # Somebody else in this process made the domain: their configuration stays.
                return None
            raise RCLError(f"DDS domain {domain_id} cannot be opened: {error}") from error


def has_network() -> bool:
    """Return whether an interface other than loopback is up and has an IPv4 address."""
    import fcntl
    import socket
    import struct

    is_up, is_loopback = 0x1, 0x8
    get_flags, get_address = 0x8913, 0x8915
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, name in socket.if_nameindex():
            request = struct.pack("256s", name.encode()[:15])
            try:
                flags = struct.unpack_from("16sh", fcntl.ioctl(probe, get_flags, request))[1]
                fcntl.ioctl(probe, get_address, request)
            except OSError:
                continue
            if flags & is_up and not flags & is_loopback:
                return True
    return False


domains = _Domains()
