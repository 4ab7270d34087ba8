"""Who is at the other end: which client a request came from, and whether its reply will be heard."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.wire.participant import Reader, Writer


def hears(writer: Writer, reader: Reader, request_handle: int) -> bool:
    """Return whether the client that wrote a request is matched to hear a reply.

    A client's two endpoints are discovered one after the other, and a reply written in between would be lost; they
    tell that they belong together by the `clientid` in their user data, as those of rmw_cyclonedds do. A client without
    one, or one that has left, counts as hearing: there is nothing to wait for.
    """
    from cyclonedds.core import DDSException

    try:
        identity = _client_id(reader.entity.get_matched_publication_data(request_handle))
        if identity is None:
            return True
        handles = writer.entity.get_matched_subscriptions()
        return any(_client_id(writer.entity.get_matched_subscription_data(h)) == identity for h in handles)
    except DDSException:
        return True


def _client_id(endpoint: Any) -> bytes | None:
    """Return what an endpoint says of the client it belongs to, None if nothing."""
    if endpoint is None:
        return None
    for policy in endpoint.qos:
        if policy.__scope__ == "Userdata":
            found = re.search(rb"clientid=([^;]*);", policy.data)
            return found[1] if found else None
    return None
