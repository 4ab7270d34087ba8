"""What writers and readers of Cyclone DDS have in common."""

from __future__ import annotations

from typing import Any, ClassVar

from seat_gear_dynamics.runtime.wire.library import delete, library


class Endpoint:
    """A writer or a reader: its name on the network, how many others it is matched with, its end."""

    _COUNTS_MATCHES: ClassVar[str]
    """Function of the library that counts. Not the matched status: reading that eats what a matched event reports."""

    def __init__(self, entity: Any) -> None:
        self.entity = entity
        self._ref = entity._ref

    def gid(self) -> bytes:
        """Return the 16 bytes that name this endpoint on the network."""
        identifier: bytes = self.entity.guid.bytes
        return identifier

    def matched(self) -> int:
        """Return how many endpoints of the other kind are matched now."""
        return int(getattr(library(), self._COUNTS_MATCHES)(self._ref, None, 0))

    def close(self) -> None:
        """Delete the endpoint and what hangs on it."""
        delete(self.entity)


class WriterEndpoint(Endpoint):
    """A writer, matched with readers."""

    _COUNTS_MATCHES = "dds_get_matched_subscriptions"


class ReaderEndpoint(Endpoint):
    """A reader, matched with writers."""

    _COUNTS_MATCHES = "dds_get_matched_publications"
