"""The one extension of the bundled runtime beyond rclpy: messages and publishers asked for many at a time.

rclpy calls a function for each message. A recorder at ten thousand messages a second spends nearly all of its time on
that; here one call takes whatever has arrived on all of its topics since the last one. And rclpy tells the publishers
of one topic in one call, where reading what discovery knows costs the same for all topics.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.graph import Endpoint
from seat_gear_dynamics.runtime.graph_queries import TopicEndpointInfo, TopicEndpointTypeEnum
from seat_gear_dynamics.runtime.interfaces import type_hash
from seat_gear_dynamics.runtime.messages import check_message_class
from seat_gear_dynamics.runtime.names import dds_topic, ros_topic
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.qos import HistoryPolicy, QoSProfile
from seat_gear_dynamics.runtime.wire.qos import dds_qos

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.wire.counted import CountedReader, Taken

__all__ = ["BatchSubscriptions", "Publishers", "offers_batches"]

_UNKNOWN = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")


def offers_batches(node: object) -> bool:
    """Return whether `node` is one of the bundled runtime, for which `BatchSubscriptions` can be made."""
    return isinstance(node, Node)


class Publishers:
    """Follows the publishers of all topics; asking again costs a microsecond while none has come or gone."""

    def __init__(self, node: Node) -> None:
        from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
        from cyclonedds.core import DDSStatus

        self._graph = node._context._graph_opened
        self._news = BuiltinDataReader(self._graph.participant.entity, BuiltinTopicDcpsPublication)
        self._bit = DDSStatus.DataAvailable
        self._known: dict[str, list[TopicEndpointInfo]] | None = None

    def by_topic(self) -> dict[str, list[TopicEndpointInfo]]:
        """Return what `get_publishers_info_by_topic` tells, for each topic that has a publisher, by absolute name."""
        if self._news.take_status(self._bit) or self._known is None:
            self._known = self._look()
        found = self._known
        if any(info.node_name == _UNKNOWN[0] for infos in found.values() for info in infos):
            self._known = None  # the name of a publisher's node may come after the publisher
        return found

    def _look(self) -> dict[str, list[TopicEndpointInfo]]:
        owners = {
            bytes(gid.data): (entry.node_name, entry.node_namespace)
            for _, entry in self._graph._all_nodes()
            for gid in entry.writer_gid_seq
        }
        found: dict[str, list[TopicEndpointInfo]] = {}
        for endpoint in self._graph.endpoints("writer"):
            name = ros_topic(endpoint.topic)
            if name is not None:
                found.setdefault(name, []).append(_info(endpoint, *owners.get(endpoint.gid, _UNKNOWN)))
        return found


def _info(endpoint: Endpoint, node_name: str, namespace: str) -> TopicEndpointInfo:
    return TopicEndpointInfo(
        node_name=node_name,
        node_namespace=namespace,
        topic_type=endpoint.type_name,
        topic_type_hash=endpoint.type_hash,
        endpoint_type=TopicEndpointTypeEnum.PUBLISHER,
        endpoint_gid=list(endpoint.gid),
        qos_profile=endpoint.profile,
    )


class BatchSubscriptions:
    """Subscriptions of one node, known by numbers, that are polled and not waited for.

    They keep the last `depth` messages of each topic. A message that is overwritten before it is taken is counted:
    `lost` says how many of each subscription. Messages are CDR bytes with the 4-byte header, as with `raw=True`.
    What a publisher's own history has overwritten before it was sent, DDS does not tell, and is not in `lost`.
    Not thread-safe; `take` costs about 2 µs for a subscription where nothing waits.
    """

    def __init__(self, node: Node) -> None:
        from seat_gear_dynamics.runtime.wire.counted import Sink

        self._node = node
        self._sink = Sink()
        self._readers: dict[int, CountedReader] = {}
        self._past: dict[int, int] = {}
        self._next = self._first = 0
        self.complete = True
        node._rt_batches.append(self)

    def create(self, msg_type: Any, topic: str, qos: QoSProfile) -> int:
        """Subscribe and return the subscription's number.

        Raises:
            TypeError, ValueError: the type is no message class, or the QoS is not one or keeps all messages.
            InvalidTopicNameException: the name is invalid.
            RCLError: DDS refuses.
        """
        check_message_class(msg_type)
        if qos.history is HistoryPolicy.KEEP_ALL:
            raise ValueError("A batch subscription keeps the last messages; set a depth instead of KEEP_ALL.")
        name = self._node.resolve_topic_name(topic)
        policies = dds_qos(qos, f"typehash={type_hash(msg_type.FULL_NAME)};")
        participant = self._node._context._participant
        number, self._next = self._next, self._next + 1
        reader = participant.counted_reader(dds_topic(name), msg_type.FULL_NAME, policies, max(1, qos.depth), number)
        self._readers[number] = reader
        self._node._rt_announce(readers=[reader.gid()])
        return number

    def take(self) -> Taken | None:
        """Take what has arrived, at most some 16 000 messages or 4 MB, in order of arrival; None if nothing has.

        `complete` then says whether all that had arrived before the call was taken; call again where it was not.

        Raises:
            RCLError: DDS refuses.
        """
        readers, self.complete = list(self._readers.values()), True
        # Begin behind the one that filled the last call: a topic that floods must not starve those behind it.
        for k in range(len(readers)):
            place = (self._first + 1 + k) % len(readers)
            if not readers[place].take(self._sink):
                self._first, self.complete = place, False
                break
        return self._sink.empty()

    def lost(self, number: int) -> int:
        """Return how many messages of a subscription were overwritten before they were taken."""
        reader = self._readers.get(number)
        return reader.lost if reader is not None else self._past.get(number, 0)

    def destroy(self, number: int | None = None) -> None:
        """Leave one topic, or all of them; what still waits is gone, so take it before."""
        gone = {each: self._readers.pop(each) for each in ([number] if number is not None else list(self._readers))}
        self._node._rt_withdraw([reader.gid() for reader in gone.values()])
        for each, reader in gone.items():
            self._past[each] = reader.lost
            reader.close()
