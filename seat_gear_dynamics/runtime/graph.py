"""The ROS graph: announce this program's nodes, and see everybody's nodes, topics and endpoints."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from seat_gear_dynamics.runtime import names
from seat_gear_dynamics.runtime.messages import decoder, encoder, message_class
from seat_gear_dynamics.runtime.qos import DurabilityPolicy as Durability
from seat_gear_dynamics.runtime.qos import HistoryPolicy, QoSProfile
from seat_gear_dynamics.runtime.wire.participant import Participant
from seat_gear_dynamics.runtime.wire.qos import dds_qos, profile_of

_INFO = "rmw_dds_common/msg/ParticipantEntitiesInfo"
_INFO_HASH = "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"
"""Hash Jazzy gives its discovery type, whose gid it spells uint8 where the type store spells char."""

_ALIVE = 16
_MOST = 100_000


@dataclass
class NodeEntry:
    """One node of this program with the network names of what it owns."""

    name: str
    namespace: str
    readers: list[bytes] = field(default_factory=list)
    writers: list[bytes] = field(default_factory=list)


@dataclass(frozen=True)
class Endpoint:
    """A publisher or subscription somewhere on the network."""

    gid: bytes
    participant: bytes
    topic: str
    type_name: str
    type_hash: str
    profile: QoSProfile


class Graph:
    """What a context tells of its nodes, and what it knows of others."""

    def __init__(self, participant: Participant) -> None:
        self.participant = participant
        self._lock = threading.RLock()
        self._nodes: list[NodeEntry] = []
        self._held = 0
        self._others: dict[bytes, Any] = {}
        self._builtin: dict[str, Any] = {}
        late = QoSProfile(depth=1, durability=Durability.TRANSIENT_LOCAL)
        user_data = f"typehash={_INFO_HASH};"
        self._writer = participant.writer("ros_discovery_info", _INFO, dds_qos(late, user_data))
        late_all = QoSProfile(history=HistoryPolicy.KEEP_ALL, durability=Durability.TRANSIENT_LOCAL)
        self._reader = participant.reader("ros_discovery_info", _INFO, dds_qos(late_all, user_data))
        self._encode = encoder(message_class(_INFO))
        self._decode = decoder(message_class(_INFO))

    # What this program owns --------------------------------------------------------------------------------

    def add_node(self, name: str, namespace: str) -> NodeEntry:
        """Announce a node."""
        entry = NodeEntry(name, namespace)
        with self._lock:
            self._nodes.append(entry)
        self.announce()
        return entry

    def remove_node(self, entry: NodeEntry) -> None:
        """Announce that a node is gone."""
        with self._lock:
            if entry in self._nodes:
                self._nodes.remove(entry)
        self.announce()

    @contextmanager
    def one_announcement(self) -> Iterator[None]:
        """Announce all changes made inside in one go at the end."""
        with self._lock:
            self._held += 1
        try:
            yield
        finally:
            with self._lock:
                self._held -= 1
            self.announce()

    def announce(self) -> None:
        """Tell the network which nodes this program has and what they own."""
        with self._lock:
            if self._held:
                return
            info = message_class(_INFO)(gid=_gid(self.participant.gid()))
            info.node_entities_info_seq = [_entities(entry) for entry in self._nodes]
            self._writer.write(self._encode(info))
            self._hear()

    def close(self) -> None:
        """Leave the graph."""
        with self._lock:
            self._builtin.clear()
            self.participant.close()

    # What others own ---------------------------------------------------------------------------------------

    def nodes(self) -> list[tuple[str, str]]:
        """Return name and namespace of every node on the network."""
        return [(node.node_name, node.node_namespace) for _, node in self._all_nodes()]

    def _all_nodes(self) -> list[tuple[bytes, Any]]:
        """Return every node with its participant."""
        with self._lock:
            self._hear()
            there = {sample.key.bytes for sample in self._builtin_samples("participant")}
            for gone in self._others.keys() - there:
                del self._others[gone]
            return [(gid, node) for gid, info in self._others.items() for node in info.node_entities_info_seq]

    def _hear(self) -> None:
        """Read what other programs announced since the last time."""
        for data, _ in self._reader.take(_MOST):
            info = self._decode(data)
            self._others[bytes(info.gid.data)] = info

    def _builtin_samples(self, kind: str) -> list[Any]:
        """Return Cyclone's own records of the participants, writers or readers that are there now."""
        from cyclonedds import builtin

        with self._lock:
            if kind not in self._builtin:
                topic = {
                    "participant": builtin.BuiltinTopicDcpsParticipant,
                    "writer": builtin.BuiltinTopicDcpsPublication,
                    "reader": builtin.BuiltinTopicDcpsSubscription,
                }[kind]
                self._builtin[kind] = builtin.BuiltinDataReader(self.participant.entity, topic)
            samples = self._builtin[kind].read(_MOST)
        return [sample for sample in samples if sample.sample_info.instance_state == _ALIVE]

    def endpoints(self, kind: str) -> list[Endpoint]:
        """Return every DDS "writer" or "reader" on the network, this program's own too."""
        return [
            Endpoint(
                sample.key.bytes,
                sample.participant_key.bytes,
                sample.topic_name,
                names.ros_type(sample.type_name),
                _type_hash(sample.qos),
                profile_of(sample.qos),
            )
            for sample in self._builtin_samples(kind)
        ]

    def on_topic(self, kind: str, dds_topic: str) -> list[Endpoint]:
        """Return the endpoints of a kind on a DDS topic."""
        return [endpoint for endpoint in self.endpoints(kind) if endpoint.topic == dds_topic]

    def owner(self, gid: bytes) -> tuple[str, str]:
        """Return name and namespace of the node an endpoint belongs to, as the ROS tools name unknown ones."""
        for _, node in self._all_nodes():
            if any(bytes(g.data) == gid for g in (*node.reader_gid_seq, *node.writer_gid_seq)):
                return node.node_name, node.node_namespace
        return "_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_"

    def owned_by(self, kind: str, node_name: str, namespace: str) -> list[Endpoint] | None:
        """Return the endpoints of a kind a node owns, None if there is no such node."""
        found = [n for _, n in self._all_nodes() if (n.node_name, n.node_namespace) == (node_name, namespace)]
        if not found:
            return None
        sequences = (n.reader_gid_seq if kind == "reader" else n.writer_gid_seq for n in found)
        gids = {bytes(gid.data) for sequence in sequences for gid in sequence}
        return [endpoint for endpoint in self.endpoints(kind) if endpoint.gid in gids]


def _gid(identifier: bytes) -> Any:
    return message_class("rmw_dds_common/msg/Gid")(data=identifier)


def _entities(entry: NodeEntry) -> Any:
    return message_class("rmw_dds_common/msg/NodeEntitiesInfo")(
        node_namespace=entry.namespace,
        node_name=entry.name,
        reader_gid_seq=[_gid(gid) for gid in entry.readers],
        writer_gid_seq=[_gid(gid) for gid in entry.writers],
    )


def _type_hash(qos: Any) -> str:
    for policy in qos:
        if policy.__scope__ == "Userdata":
            found = re.search(rb"typehash=([^;]*);", policy.data)
            return found[1].decode(errors="replace") if found else ""
    return ""
