"""The metadata.yaml of a recovered bag: what is in it now, with the quality of service that its channels state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import yaml
from mcap.records import Channel

from seat_gear_dynamics.logs import metadata
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.metadata import FileRecord, Node, TopicRecord
from seat_gear_dynamics.logs.recovery.claims import Claims
from seat_gear_dynamics.logs.recovery.declarations import Declarations
from seat_gear_dynamics.logs.schemas import schema

# rosbag2 before version 9 of the format wrote the numbers of rmw's enumerations.
_CHOICES = {
    "history": ("system_default", "keep_last", "keep_all", "unknown"),
    "reliability": ("system_default", "reliable", "best_effort", "unknown", "best_available"),
    "durability": ("system_default", "transient_local", "volatile", "unknown", "best_available"),
    "liveliness": ("system_default", "automatic", "manual_by_node", "manual_by_topic", "unknown", "best_available"),
}
_DURATIONS = ("deadline", "lifespan", "liveliness_lease_duration")
_LARGEST_QOS = 2**16  # bytes of text


class Description:
    """Topics of all files, and the texts that state them with the files so far."""

    def __init__(self, claims: Claims, custom_data: Mapping[str, str]) -> None:
        self._distro = claims.distro
        self._custom = dict(custom_data)
        self._topics: dict[str, TopicRecord] = {}
        self._profiles: dict[str, list[Node]] = {}
        self._hashes = {topic.name: topic.type_hash for topic in claims.topics}

    def add_topics(self, declarations: Declarations) -> None:
        """Enter the topics of one file."""
        for number, channel in declarations.channels.items():
            if channel.topic not in self._topics:
                kind = declarations.type_of(number)
                self._topics[channel.topic] = TopicRecord(channel.topic, kind, self._hash(channel, kind), ())
                self._profiles[channel.topic] = profiles(channel.metadata.get("offered_qos_profiles", ""))

    def document(self, files: Sequence[FileRecord]) -> str:
        """Return the text of metadata.yaml."""
        text = metadata.document(self._topics.values(), files, self._custom)
        key = "rosbag2_bagfile_information"
        return metadata.to_yaml({key: self._complete(yaml.safe_load(text)[key])}) + "\n"

    def serialized(self, files: Sequence[FileRecord]) -> str:
        """Return the text that rosbag2 keeps inside a file."""
        return metadata.to_yaml(
            self._complete(yaml.safe_load(metadata.serialized(self._topics.values(), files, self._custom)))
        )

    def _complete(self, information: dict[str, Any]) -> dict[str, Any]:
        for entry in information["topics_with_message_count"]:
            topic = entry["topic_metadata"]
            topic["offered_qos_profiles"] = self._profiles[topic["name"]]
        information["ros_distro"] = self._distro or information["ros_distro"]
        return information

    def _hash(self, channel: Channel, kind: str) -> str:
        stated = channel.metadata.get("topic_type_hash") or self._hashes.get(channel.topic)
        if stated:
            return stated
        try:
            return schema(kind).hash
        except LogError:
            return ""


def profiles(text: str) -> list[Node]:
    """Return the `offered_qos_profiles` of a channel as metadata.yaml lists them, an empty list where they do not read.

    Only known fields of known kinds are taken, so that no text can make the result larger than it is itself.
    """
    if len(text) > _LARGEST_QOS:
        return []
    try:
        found = yaml.safe_load(text)
        return [_profile(profile) for profile in found] if isinstance(found, list) else []
    except Exception:  # as in claims: damaged or foreign YAML fails in many ways
        return []


def _profile(found: Mapping[str, Any]) -> Node:
    def choice(field: str) -> str:
        value = found.get(field, "unknown")
        names = _CHOICES[field]
        if isinstance(value, int):
            return names[value] if 0 <= value < len(names) else "unknown"
        return value if isinstance(value, str) else "unknown"

    def duration(field: str) -> Node:
        value = found.get(field) or {}
        return {"sec": int(value.get("sec", 9223372036)), "nsec": int(value.get("nsec", 854775807))}

    deadline, lifespan, lease = (duration(field) for field in _DURATIONS)
    return {
        "history": choice("history"),
        "depth": int(found.get("depth", 0)),
        "reliability": choice("reliability"),
        "durability": choice("durability"),
        "deadline": deadline,
        "lifespan": lifespan,
        "liveliness": choice("liveliness"),
        "liveliness_lease_duration": lease,
        "avoid_ros_namespace_conventions": bool(found.get("avoid_ros_namespace_conventions", False)),
    }
