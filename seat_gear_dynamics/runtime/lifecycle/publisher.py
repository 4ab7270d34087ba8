"""Publishers that speak only while their node is active."""

from __future__ import annotations

from typing import Any

from seat_gear_dynamics.runtime.endpoints import Publisher
from seat_gear_dynamics.runtime.lifecycle.managed_entity import SimpleManagedEntity


class LifecyclePublisher(SimpleManagedEntity, Publisher):
    """A publisher of a managed node; made by `LifecycleNode.create_lifecycle_publisher`."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        SimpleManagedEntity.__init__(self)
        Publisher.__init__(self, *args, **kwargs)

    def publish(self, msg: Any) -> None:
        """Send a message while the node is active, otherwise nothing; see `Publisher.publish`."""
        if self._enabled:
            Publisher.publish(self, msg)
