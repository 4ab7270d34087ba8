"""The topics of a bag, what became of their messages, and what a new file of the bag begins with."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from seat_gear_dynamics.logs.batch import Batch, Integers
from seat_gear_dynamics.logs.counters import Account, Counters
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.metadata import TopicRecord
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.topics import Qos

LATEST = 2**63  # log times are signed 64-bit nanoseconds in metadata.yaml


class Ledger:
    """Accounts of the declared topics, by absolute name."""

    def __init__(self) -> None:
        self._accounts: dict[str, Account] = {}
        self._latching: frozenset[str] = frozenset()

    def add(self, name: str, type: str, qos: Qos) -> TopicRecord | None:
        """Declare a topic; return its record, None for one that is declared so already.

        Raises `LogError` for a relative name, an unknown type, or a second type for the same name.
        """
        if not name.startswith("/"):
            raise LogError(f"The topic {name!r} is relative; a log needs the resolved name, such as '/{name}'.")
        known = self._accounts.get(name)
        if known is None:
            record = TopicRecord(name, type, schema(type).hash, (qos,))
            self._accounts[name] = account = Account(record)
            self._latching |= {name} if account.latched is not None else set()
            return record
        if known.record.type != type:
            raise LogError(
                f"The topic {name} is already logged as {known.record.type}, not {type}; "
                f"stop the publisher that uses the wrong type, or record it under another name."
            )
        return None

    def __getitem__(self, name: str) -> Account:
        try:
            return self._accounts[name]
        except KeyError as cause:
            raise LogError(f"The topic {name!r} is not declared in this log; call add_topic first.") from cause

    @property
    def records(self) -> list[TopicRecord]:
        """The declared topics."""
        return [account.record for account in self._accounts.values()]

    @property
    def counters(self) -> dict[str, Counters]:
        """Per topic: received, written, dropped."""
        return {name: account.counters for name, account in self._accounts.items()}

    def numbers(self, batch: Batch) -> Integers:
        """Return the sequence number of the next message for each of a batch's names."""
        return np.array([self[name].received for name in batch.names], np.int64)

    def receive(self, batch: Batch) -> None:
        """Count messages as received."""
        for name, count in batch.counts().items():
            self._accounts[name].received += count

    def receive_rest(self, batch: Batch, numbers: Integers) -> None:
        """Count those of a batch that are not counted yet; `numbers` are what was next before it."""
        counts = batch.counts()
        for name, number in zip(batch.names, numbers.tolist(), strict=True):
            self._accounts[name].received = number + counts.get(name, 0)

    def accept(self, written: Batch, numbers: Integers) -> None:
        """Note messages that the file has taken; `numbers` are their first sequence numbers."""
        for name, count in written.counts().items():
            self._accounts[name].accept(count)
        following = dict(zip(written.names, numbers.tolist(), strict=True))
        for topic, data, _, publish_ns in written.of(self._latching):
            self._accounts[topic].latch(data, publish_ns, following[topic] & 0xFFFFFFFF)
            following[topic] += 1

    def latched(self) -> Iterator[tuple[str, bytes, int, int]]:
        """Yield topic, data, publish time and sequence number of what a late subscriber would be sent."""
        for name in self._accounts:
            for kept in self._accounts[name].latched or ():
                yield name, *kept

    def settle(self) -> None:
        """Note that everything accepted is durable."""
        for account in self._accounts.values():
            account.settle()

    def drop_pending(self) -> int:
        """Note that nothing more will become durable; return how many messages that loses."""
        return sum(account.drop_pending() for account in self._accounts.values())


def impossible(topic: str, log_ns: int, publish_ns: int) -> LogError:
    """Return the sentence about times that a log cannot hold."""
    return LogError(
        f"A message on {topic} has log time {log_ns} ns and publish time {publish_ns} ns; "
        f"both must lie from 0 to 2^63-1. Check the clock."
    )


def split_times(batch: Batch) -> tuple[Batch, tuple[str, int, int] | None]:
    """Return the messages whose times a log can hold, and topic and times of the first of the others."""
    wrong = np.flatnonzero((batch.log_ns < 0) | (batch.publish_ns < 0))
    if not len(wrong):
        return batch, None
    topic, _, log_ns, publish_ns = batch.message(int(wrong[0]))
    return batch.part(np.delete(np.arange(len(batch)), wrong)), (topic, log_ns, publish_ns)
