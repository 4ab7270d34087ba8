"""The DDS side: participant, topics, readers and writers of Cyclone DDS."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.exceptions import RCLError
from seat_gear_dynamics.runtime.wire import types as wire_types
from seat_gear_dynamics.runtime.wire.domain import domains
from seat_gear_dynamics.runtime.wire.entity import ReaderEndpoint, WriterEndpoint
from seat_gear_dynamics.runtime.wire.library import checked, delete, library

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.wire.counted import CountedReader

_ANY_STATE = 0x7F
_OK, _TIMEOUT = 0, -10


class Writer(WriterEndpoint):
    """A DDS writer that takes serialized bytes."""

    def __init__(self, entity: Any) -> None:
        from cyclonedds._clayer import ddspy_write

        super().__init__(entity)
        self._write = ddspy_write

    def write(self, data: bytes) -> None:
        """Write one sample given as CDR bytes with the 4-byte header.

        Raises:
            RCLError: DDS refused the sample, for example because a keep-all history is full.
        """
        odd = len(data) & 3
        code = self._write(self._ref, data + b"\0" * (4 - odd) if odd else data)
        if code < 0:
            checked(code, "writing a sample")

    def wait_for_acks(self, nanoseconds: int) -> bool:
        """Wait until reliable readers have everything; return whether they do.

        Raises:
            RCLError: DDS reports another failure than a timeout.
        """
        code = self.entity._wait_for_acks(self._ref, nanoseconds)
        return code != _TIMEOUT and checked(code, "waiting for acknowledgements") == _OK

    def assert_liveliness(self) -> None:
        """Say that this writer is alive."""
        checked(library().dds_assert_liveliness(self._ref), "asserting liveliness")


class Reader(ReaderEndpoint):
    """A DDS reader that gives serialized bytes, with a condition to wait on."""

    def __init__(self, entity: Any) -> None:
        from cyclonedds._clayer import ddspy_take

        super().__init__(entity)
        self._take = ddspy_take
        self.condition = checked(library().dds_create_readcondition(self._ref, _ANY_STATE), "creating a read condition")

    def take(self, most: int) -> list[tuple[bytes, Any]]:
        """Take up to `most` samples: CDR bytes with the 4-byte header, and Cyclone's sample info.

        Notices that a writer left carry no data and are left out.
        """
        taken = self._take(self._ref, _ANY_STATE, most)
        if isinstance(taken, int):
            checked(taken, "taking samples")
            return []
        return [sample for sample in taken if sample[1].valid_data]


class Participant:
    """A DDS participant with its topics, the one a ROS context has."""

    def __init__(self, domain_id: int) -> None:
        from cyclonedds.core import DDSException, Policy, Qos
        from cyclonedds.domain import DomainParticipant

        self.domain_id = domain_id
        domains.acquire(domain_id)
        try:
            self.entity = DomainParticipant(domain_id, qos=Qos(Policy.Userdata(b"enclave=/;")))
        except DDSException as error:
            domains.release(domain_id)
            raise RCLError(
                f"No DDS participant in domain {domain_id}: {error} Check CYCLONEDDS_URI, the network "
                "interfaces, and that fewer than 33 programs of this domain run on this machine."
            ) from error
        self.ref: int = self.entity._ref
        self._lock = threading.Lock()
        self._topics: dict[tuple[str, str], Any] = {}
        self._counted: list[CountedReader] = []  # DDS writes into their memory until the participant is gone
        self._open = True

    def gid(self) -> bytes:
        """Return the 16 bytes that name this participant on the network."""
        identifier: bytes = self.entity.guid.bytes
        return identifier

    def writer(self, topic: str, type_name: str, qos: Any, request_header: bool = False) -> Writer:
        """Make a writer on a DDS topic of a ROS type.

        Raises:
            RCLError: DDS refuses, for example because the policies contradict each other.
        """
        from cyclonedds.core import DDSException
        from cyclonedds.pub import DataWriter

        try:
            return Writer(DataWriter(self.entity, self._topic(topic, type_name, request_header), qos=qos))
        except DDSException as error:
            raise RCLError(f"No publisher on {topic!r} of {type_name}: {error}") from error

    def reader(self, topic: str, type_name: str, qos: Any, request_header: bool = False) -> Reader:
        """Make a reader on a DDS topic of a ROS type.

        Raises:
            RCLError: DDS refuses, for example because the policies contradict each other.
        """
        from cyclonedds.core import DDSException
        from cyclonedds.sub import DataReader

        try:
            return Reader(DataReader(self.entity, self._topic(topic, type_name, request_header), qos=qos))
        except DDSException as error:
            raise RCLError(f"No subscription on {topic!r} of {type_name}: {error}") from error

    def counted_reader(self, topic: str, type_name: str, qos: Any, depth: int, number: int) -> CountedReader:
        """Make a reader that counts what arrives, on a topic entity of its own, which its filter needs.

        Raises:
            RCLError: DDS refuses.
        """
        from cyclonedds.core import DDSException
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        from seat_gear_dynamics.runtime.wire.counted import CountedReader

        try:
            own = Topic(self.entity, topic, wire_types.topic_struct(type_name))
            made = CountedReader(own, lambda entity: DataReader(self.entity, entity, qos=qos), depth, number)
        except DDSException as error:
            raise RCLError(f"No subscription on {topic!r} of {type_name}: {error}") from error
        self._counted.append(made)
        return made

    def _topic(self, topic: str, type_name: str, request_header: bool) -> Any:
        from cyclonedds.topic import Topic

        with self._lock:
            key = (topic, type_name)
            if key not in self._topics:
                struct_type = wire_types.topic_struct(type_name, request_header)
                self._topics[key] = Topic(self.entity, topic, struct_type)
            return self._topics[key]

    def close(self) -> None:
        """Delete the participant and everything made with it, and leave the graph."""
        if not self._open:
            return
        self._open = False
        self._topics.clear()
        delete(self.entity)
        self._counted.clear()
        domains.release(self.domain_id)
