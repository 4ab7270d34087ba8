"""Wait for DDS data and for wake-ups from other threads."""

from __future__ import annotations

import ctypes as ct
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.wire.library import checked, library

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.wire.participant import Participant


class Guard:
    """A condition any thread can trigger to wake a wait set."""

    def __init__(self, participant: Participant) -> None:
        self.condition = checked(library().dds_create_guardcondition(participant.ref), "creating a guard condition")
        self._set = library().dds_set_guardcondition

    def trigger(self) -> None:
        """Trigger the condition; after the participant is gone this does nothing."""
        self._set(self.condition, True)

    def clear(self) -> None:
        """Take the trigger back."""
        self._set(self.condition, False)


class WaitSet:
    """Waits for read and guard conditions, each known by a whole number chosen by the caller."""

    def __init__(self, participant: Participant) -> None:
        self._library = library()
        self._ref = checked(self._library.dds_create_waitset(participant.ref), "creating a wait set")
        self._buffer: ct.Array[Any] = (ct.c_void_p * 64)()

    def attach(self, condition: int, token: int) -> None:
        """Wait for a condition too, reported as `token` (from 1)."""
        checked(self._library.dds_waitset_attach(self._ref, condition, token), "attaching a condition")

    def detach(self, condition: int) -> None:
        """Wait for a condition no more; one that was deleted has gone by itself."""
        self._library.dds_waitset_detach(self._ref, condition)

    def wait(self, nanoseconds: int) -> list[int]:
        """Return the tokens of the triggered conditions, none after the time given.

        Raises:
            RCLError: the wait set is gone.
        """
        count = self._library.dds_waitset_wait(self._ref, self._buffer, len(self._buffer), nanoseconds)
        if count <= 0:
            checked(count, "waiting")
            return []
        if count > len(self._buffer):
            self._buffer = (ct.c_void_p * (2 * count))()
            return self.wait(0)
        return self._buffer[:count]
