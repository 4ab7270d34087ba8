"""A bag's messages in order of log time, holding only what a later block may still come before."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from seat_gear_dynamics.logs.container import Block, DamageError, Message, scan
from seat_gear_dynamics.logs.errors import LogError, reason
from seat_gear_dynamics.logs.reader import Bag, BagMessage


class Ordered:
    """Yields the messages of a bag like `Bag.messages`, in memory that depends on overlaps and not on length.

    `Bag.messages` holds blocks together as long as each begins before the last has ended, or as it ends: with several
    messages of one log time that chains a log of hours. Here a message leaves as soon as the next block begins later.
    """

    def __init__(self, bag: Bag, topics: Collection[str] | None = None) -> None:
        """Choose absolute topic names (all by default); raises `LogError` where a file cannot be read."""
        self.damage: list[str] = []
        """Sentences about blocks that could not be read and are left out."""
        chosen = set(bag.topics) if topics is None else set(topics)
        self._path = bag.path
        try:
            contents = [scan(path) for path in bag.files]
        except OSError as cause:
            raise LogError(f"The log {bag.path} cannot be read: {reason(cause)}.") from cause
        numbers = [(each, each.numbers(chosen)) for each in contents]
        blocks = [(block, names) for each, names in numbers if names for block in each.blocks]
        self._blocks: list[tuple[Block, dict[int, str]]] = sorted(blocks, key=lambda pair: pair[0].start_ns)

    def __iter__(self) -> Iterator[BagMessage]:
        waiting: list[tuple[str, Message]] = []
        for block, names in self._blocks:
            keep = next((i for i, (_, m) in enumerate(waiting) if m.log_time_ns >= block.start_ns), len(waiting))
            for topic, (_, log_ns, publish_ns, data) in waiting[:keep]:
                yield BagMessage(topic, log_ns, publish_ns, data)
            waiting = waiting[keep:] + [(names[m.channel], m) for m in self._load(block, names)]
            waiting.sort(key=lambda pair: pair[1].log_time_ns)  # stable: ties stay as they were written
        for topic, (_, log_ns, publish_ns, data) in waiting:
            yield BagMessage(topic, log_ns, publish_ns, data)

    def _load(self, block: Block, names: dict[int, str]) -> list[Message]:
        try:
            return block.messages(names)
        except DamageError as damage:
            self.damage.append(f"{block.path.name}: {damage}; it is left out.")
            return []
        except OSError as cause:
            raise LogError(f"The log {self._path} cannot be read further: {reason(cause)}.") from cause
