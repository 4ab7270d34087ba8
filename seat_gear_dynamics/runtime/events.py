"""QoS events of publishers and subscriptions: deadline, liveliness, incompatible QoS, lost messages, matches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from seat_gear_dynamics.runtime.absent import sentence
from seat_gear_dynamics.runtime.groups import CallbackGroup
from seat_gear_dynamics.runtime.logging import get_logger
from seat_gear_dynamics.runtime.qos import QoSPolicyKind, qos_policy_name_from_kind


class UnsupportedEventTypeError(RuntimeError):
    """A callback was given for an event that is not part of the bundled runtime."""


@dataclass
class QoSRequestedDeadlineMissedInfo:
    """How often a publisher missed the deadline a subscription asks for."""

    total_count: int
    total_count_change: int


@dataclass
class QoSOfferedDeadlineMissedInfo:
    """How often a publisher missed the deadline it offers."""

    total_count: int
    total_count_change: int


@dataclass
class QoSLivelinessLostInfo:
    """How often a publisher failed to say in time that it is alive."""

    total_count: int
    total_count_change: int


@dataclass
class QoSMessageLostInfo:
    """How many messages a subscription lost."""

    total_count: int
    total_count_change: int


@dataclass
class QoSLivelinessChangedInfo:
    """How many publishers of a subscription are alive and not."""

    alive_count: int
    not_alive_count: int
    alive_count_change: int
    not_alive_count_change: int


@dataclass
class QoSRequestedIncompatibleQoSInfo:
    """How many endpoints offered or asked for QoS that does not fit, and the last policy in question."""

    total_count: int
    total_count_change: int
    last_policy_kind: QoSPolicyKind


@dataclass
class QoSSubscriptionMatchedInfo:
    """How many endpoints are and were matched."""

    total_count: int
    total_count_change: int
    current_count: int
    current_count_change: int


QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo
QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo

_POLICIES = {
    2: QoSPolicyKind.DURABILITY,
    4: QoSPolicyKind.DEADLINE,
    8: QoSPolicyKind.LIVELINESS,
    11: QoSPolicyKind.RELIABILITY,
    13: QoSPolicyKind.HISTORY,
    21: QoSPolicyKind.LIFESPAN,
}
"""DDS policy identifiers as the kinds of ROS."""


class _Status:
    """One DDS status: its bit, how to read it, and the class that carries it to a callback."""

    def __init__(self, bit: str, getter: str, info: type) -> None:
        self.bit, self.getter, self.info = bit, getter, info

    def read(self, entity: Any) -> Any:
        """Return what the status says now, None if nothing changed; reading resets the changes."""
        status = getattr(entity, self.getter)()
        fields = self.info.__dataclass_fields__  # type: ignore[attr-defined]
        values = {name: getattr(status, name) for name in fields if name != "last_policy_kind"}
        if not any(value for name, value in values.items() if name.endswith("_change")):
            return None
        if "last_policy_kind" in fields:
            values["last_policy_kind"] = _POLICIES.get(status.last_policy_id, QoSPolicyKind.INVALID)
        return self.info(**values)


_SUBSCRIPTION = {
    "deadline": _Status(
        "RequestedDeadlineMissed", "get_requested_deadline_missed_status", QoSRequestedDeadlineMissedInfo
    ),
    "incompatible_qos": _Status(
        "RequestedIncompatibleQos", "get_requested_incompatible_qos_status", QoSRequestedIncompatibleQoSInfo
    ),
    "liveliness": _Status("LivelinessChanged", "get_liveliness_changed_status", QoSLivelinessChangedInfo),
    "message_lost": _Status("SampleLost", "get_sample_lost_status", QoSMessageLostInfo),
    "matched": _Status("SubscriptionMatched", "get_subscription_matched_status", QoSSubscriptionMatchedInfo),
}
_PUBLISHER = {
    "deadline": _Status("OfferedDeadlineMissed", "get_offered_deadline_missed_status", QoSOfferedDeadlineMissedInfo),
    "liveliness": _Status("LivelinessLost", "get_liveliness_lost_status", QoSLivelinessLostInfo),
    "incompatible_qos": _Status(
        "OfferedIncompatibleQos", "get_offered_incompatible_qos_status", QoSRequestedIncompatibleQoSInfo
    ),
    "matched": _Status("PublicationMatched", "get_publication_matched_status", QoSPublisherMatchedInfo),
}

_Callback = Callable[[Any], Any] | None


class EventHandler:
    """All events of one publisher or subscription, as work for the executor."""

    def __init__(
        self,
        *,
        callback_group: CallbackGroup | None,
        callback: dict[str, Callable[[Any], Any]],
        event_type: dict[str, _Status],
        parent_impl: Any,
    ) -> None:
        from cyclonedds.core import DDSStatus

        self.callback_group = callback_group
        self.callback = callback
        self._statuses = {name: event_type[name] for name in callback}
        self._entity = parent_impl
        self._queue: list[Callable[[], Any]] = []
        self._open = True
        self._mask = 0
        for status in self._statuses.values():
            self._mask |= getattr(DDSStatus, status.bit)
        parent_impl.set_status_mask(self._mask)
        self._condition: int = parent_impl._ref

    def _take_work(self) -> Callable[[], Any] | None:
        """Return a call of a user's callback with what changed."""
        if not self._queue and self._open:
            self._entity.take_status(self._mask)
            for name, status in self._statuses.items():
                info = status.read(self._entity)
                if info is not None:
                    self._queue.append(_bound(self.callback[name], info))
        return self._queue.pop(0) if self._queue else None

    def _has_backlog(self) -> bool:
        """Return whether changes read before wait for their callback."""
        return bool(self._queue)

    def destroy(self) -> None:
        """Make no more calls; its publisher or subscription does this at its own end."""
        self._open = False
        self._queue.clear()


def _bound(callback: Callable[[Any], Any], info: Any) -> Callable[[], Any]:
    return lambda: callback(info)


def _refuse_incompatible_type(callback: _Callback, owner: str) -> None:
    if callback is not None:
        raise UnsupportedEventTypeError(sentence(f"{owner}(incompatible_type=…)"))


class SubscriptionEventCallbacks:
    """Callbacks for the events of a subscription."""

    def __init__(
        self,
        *,
        deadline: _Callback = None,
        incompatible_qos: _Callback = None,
        liveliness: _Callback = None,
        message_lost: _Callback = None,
        incompatible_type: _Callback = None,
        matched: _Callback = None,
        use_default_callbacks: bool = True,
    ) -> None:
        _refuse_incompatible_type(incompatible_type, "SubscriptionEventCallbacks")
        self.deadline = deadline
        self.incompatible_qos = incompatible_qos
        self.liveliness = liveliness
        self.message_lost = message_lost
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks

    def _handlers(
        self, callback_group: CallbackGroup | None, entity: Any, topic: str, logger_name: str
    ) -> list[EventHandler]:
        """Return the work for a DDS reader: none or one."""
        callbacks = {name: getattr(self, name) for name in _SUBSCRIPTION}
        if callbacks["incompatible_qos"] is None and self.use_default_callbacks:
            callbacks["incompatible_qos"] = _warner(
                logger_name,
                f"New publisher discovered on topic '{topic}', offering incompatible QoS. "
                "No messages will be received from it. Last incompatible policy: ",
            )
        return _handlers(callback_group, callbacks, _SUBSCRIPTION, entity)


class PublisherEventCallbacks:
    """Callbacks for the events of a publisher."""

    def __init__(
        self,
        *,
        deadline: _Callback = None,
        liveliness: _Callback = None,
        incompatible_qos: _Callback = None,
        incompatible_type: _Callback = None,
        matched: _Callback = None,
        use_default_callbacks: bool = True,
    ) -> None:
        _refuse_incompatible_type(incompatible_type, "PublisherEventCallbacks")
        self.deadline = deadline
        self.liveliness = liveliness
        self.incompatible_qos = incompatible_qos
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks

    def _handlers(
        self, callback_group: CallbackGroup | None, entity: Any, topic: str, logger_name: str
    ) -> list[EventHandler]:
        """Return the work for a DDS writer: none or one."""
        callbacks = {name: getattr(self, name) for name in _PUBLISHER}
        if callbacks["incompatible_qos"] is None and self.use_default_callbacks:
            callbacks["incompatible_qos"] = _warner(
                logger_name,
                f"New subscription discovered on topic '{topic}', requesting incompatible QoS. "
                "No messages will be sent to it. Last incompatible policy: ",
            )
        return _handlers(callback_group, callbacks, _PUBLISHER, entity)


def _handlers(
    group: CallbackGroup | None, callbacks: dict[str, Any], statuses: dict[str, _Status], entity: Any
) -> list[EventHandler]:
    given = {name: callback for name, callback in callbacks.items() if callback is not None}
    if not given:
        return []
    return [EventHandler(callback_group=group, callback=given, event_type=statuses, parent_impl=entity)]


def _warner(logger_name: str, text: str) -> Callable[[Any], None]:
    def warn(info: Any) -> None:
        get_logger(logger_name).warning(text + qos_policy_name_from_kind(info.last_policy_kind))

    return warn
