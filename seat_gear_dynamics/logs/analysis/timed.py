"""The messages that a replay takes of a log, each topic in order of its stamps."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.message_bytes import JointDecoder
from seat_gear_dynamics.logs.analysis.setting_changes import SettingChange
from seat_gear_dynamics.logs.analysis.sources import holds
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.schemas import Decoder

Timed = tuple[int, int, Any]
"""(stamp in ns, rank, what came); of one stamp settings go before inputs, and those before outputs."""
SETTINGS, INPUT, FORCE, STATE, CLOUD, WARNING = range(-1, 5)


def sequences(bag: Bag, changes: Iterable[SettingChange], *, amid: bool) -> list[Iterator[Timed]]:
    """Return what a replay takes; sections and warnings only of a log that does not begin `amid` a run.

    Warnings have no stamp and stand at their log time. `changes` in order of time stand before the first input that was
    published after them: the monitor, which says both from one thread, judged that input by them and none before.
    """
    found = [_inputs(bag, changes), _joints(bag, topics.MESH_FORCE, FORCE)]
    if holds(bag, topics.MESH_STATE.name):
        found.append(_joints(bag, topics.MESH_STATE, STATE))
    if not amid:
        if holds(bag, topics.POINCARE.name):
            found.append(_clouds(bag))
        if holds(bag, topics.CHAOS_WARNING.name):
            found.append(_warnings(bag))
    return found


def _inputs(bag: Bag, changes: Iterable[SettingChange]) -> Iterator[Timed]:
    decoder, coming = JointDecoder(), deque(changes)
    for message in bag.messages(topics.MODEL_INPUT.name):
        joint = decoder.decode(message.data)
        while coming and coming[0].publish_ns < (message.publish_time_ns or message.log_time_ns):
            yield joint.stamp_ns, SETTINGS, coming.popleft()
        yield joint.stamp_ns, INPUT, joint


def _joints(bag: Bag, topic: topics.Topic, rank: int) -> Iterator[Timed]:
    decoder = JointDecoder()
    for message in bag.messages(topic.name):
        joint = decoder.decode(message.data)
        yield joint.stamp_ns, rank, joint


def _clouds(bag: Bag) -> Iterator[Timed]:
    decoder = Decoder({})
    for message in bag.messages(topics.POINCARE.name):
        cloud = decoder.decode(message.data, topics.POINT_CLOUD)
        yield cloud.header.stamp.sec * 1_000_000_000 + cloud.header.stamp.nanosec, CLOUD, cloud


def _warnings(bag: Bag) -> Iterator[Timed]:
    decoder = Decoder({})
    for message in bag.messages(topics.CHAOS_WARNING.name):
        status = decoder.decode(message.data, topics.DIAGNOSTIC_STATUS)
        yield message.log_time_ns, WARNING, status
