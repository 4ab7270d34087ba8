"""Callback groups: with one thread they only say which entities belong together."""

from __future__ import annotations

import weakref
from typing import Any


class CallbackGroup:
    """Base of the callback groups."""

    def __init__(self) -> None:
        self.entities: set[weakref.ReferenceType[Any]] = set()

    def add_entity(self, entity: Any) -> None:
        """Put an entity in the group."""
        self.entities.add(weakref.ref(entity))

    def has_entity(self, entity: Any) -> bool:
        """Return whether an entity is in the group."""
        return weakref.ref(entity) in self.entities


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """Callbacks never run at the same time, as is always so with one thread."""


class ReentrantCallbackGroup(CallbackGroup):
    """Callbacks may run at the same time; with one thread they do not."""
