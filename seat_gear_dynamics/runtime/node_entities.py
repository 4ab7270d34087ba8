"""Make and own publishers, subscriptions, services, clients and timers: a part of the node."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.absent import unsupported
from seat_gear_dynamics.runtime.clock import Clock, ROSClock
from seat_gear_dynamics.runtime.endpoints import Publisher, Subscription
from seat_gear_dynamics.runtime.events import PublisherEventCallbacks, SubscriptionEventCallbacks
from seat_gear_dynamics.runtime.groups import CallbackGroup, ReentrantCallbackGroup
from seat_gear_dynamics.runtime.interfaces import type_hash
from seat_gear_dynamics.runtime.logging import RcutilsLogger
from seat_gear_dynamics.runtime.messages import check_message_class
from seat_gear_dynamics.runtime.names import dds_topic
from seat_gear_dynamics.runtime.node_services import ServiceOwner
from seat_gear_dynamics.runtime.qos import QoSProfile, as_profile
from seat_gear_dynamics.runtime.services import Client, Service
from seat_gear_dynamics.runtime.time import S_TO_NS
from seat_gear_dynamics.runtime.timer import Rate, Timer
from seat_gear_dynamics.runtime.wire.qos import dds_qos

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.batches import BatchSubscriptions
    from seat_gear_dynamics.runtime.executor import Work
    from seat_gear_dynamics.runtime.graph import NodeEntry


class EntityOwner(ServiceOwner):
    """The part of a node that makes, owns and destroys what it communicates with."""

    _clock: ROSClock
    _logger: RcutilsLogger
    _rt_entry: NodeEntry

    def _rt_init_entities(self) -> None:
        self._publishers: list[Publisher] = []
        self._subscriptions: list[Subscription] = []
        self._timers: list[Timer] = []
        self._rt_batches: list[BatchSubscriptions] = []
        self._rt_init_services()
        self._rate_group = ReentrantCallbackGroup()

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a topic, remapped unless `only_expand`."""
        raise NotImplementedError

    def _rt_wake(self) -> None:
        raise NotImplementedError

    @property
    def publishers(self) -> Iterator[Publisher]:
        """The node's publishers."""
        yield from tuple(self._publishers)

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """The node's subscriptions."""
        yield from tuple(self._subscriptions)

    @property
    def timers(self) -> Iterator[Timer]:
        """The node's timers."""
        yield from tuple(self._timers)

    def _rt_waitable_work(self) -> Iterator[Work]:
        """Yield everything of the node an executor waits for, but timers."""
        for publisher in self._publishers:
            yield from publisher.event_handlers
        for subscription in self._subscriptions:
            yield from subscription.event_handlers
        yield from self._subscriptions
        yield from self._services
        yield from self._clients

    # Topics ------------------------------------------------------------------------------------------------

    def create_publisher(
        self,
        msg_type: Any,
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: PublisherEventCallbacks | None = None,
        qos_overriding_options: Any = None,
        publisher_class: type[Publisher] = Publisher,
    ) -> Publisher:
        """Make a publisher; an int as QoS is the history depth.

        Raises:
            TypeError, ValueError: the type or the QoS is not one.
            InvalidTopicNameException: the name is invalid.
            NotImplementedError: an option is not part of the bundled runtime.
            RCLError: DDS refuses.
        """
        _refuse_overriding(qos_overriding_options)
        check_message_class(msg_type)
        qos = as_profile(qos_profile)
        name = self.resolve_topic_name(topic)
        policies = dds_qos(qos, f"typehash={type_hash(msg_type.FULL_NAME)};")
        writer = self._context._participant.writer(_topic_of(name, qos), msg_type.FULL_NAME, policies)
        publisher = publisher_class(
            writer=writer, context=self._context, msg_type=msg_type, topic=topic, name=name, qos=qos
        )
        callbacks = event_callbacks or PublisherEventCallbacks()
        group = callback_group or self._default_callback_group
        publisher.event_handlers = callbacks._handlers(group, writer.entity, name, self._logger.name)
        self._publishers.append(publisher)
        self._rt_announce(writers=[publisher._gid])
        return publisher

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: Any = None,
        raw: bool = False,
    ) -> Subscription:
        """Make a subscription; the callback takes a message, or a message and its info.

        With `raw` the message is its CDR bytes with the 4-byte header, not decoded; up to three zero bytes may
        follow, since DDS sends multiples of four. Errors as in `create_publisher`; RuntimeError if the callback
        takes neither one nor two arguments.
        """
        _refuse_overriding(qos_overriding_options)
        check_message_class(msg_type)
        qos = as_profile(qos_profile)
        name = self.resolve_topic_name(topic)
        policies = dds_qos(qos, f"typehash={type_hash(msg_type.FULL_NAME)};")
        reader = self._context._participant.reader(_topic_of(name, qos), msg_type.FULL_NAME, policies)
        group = callback_group or self._default_callback_group
        try:
            subscription = Subscription(
                reader=reader,
                msg_type=msg_type,
                topic=topic,
                name=name,
                callback=callback,
                callback_group=group,
                qos=qos,
                raw=raw,
                logger_name=self._logger.name,
            )
        except Exception:
            reader.close()
            raise
        callbacks = event_callbacks or SubscriptionEventCallbacks()
        subscription.event_handlers = callbacks._handlers(group, reader.entity, name, self._logger.name)
        group.add_entity(subscription)
        self._subscriptions.append(subscription)
        self._rt_announce(readers=[subscription._gid])
        return subscription

    # Timers ------------------------------------------------------------------------------------------------

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], Any] | None,
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Have a function called every so many seconds of a clock (the node's own without one)."""
        group = callback_group or self._default_callback_group
        period_ns = int(float(timer_period_sec) * S_TO_NS)
        timer = Timer(callback, group, period_ns, clock or self._clock, context=self._context, autostart=autostart)
        timer._waker = weakref.WeakMethod(self._rt_wake)
        group.add_entity(timer)
        self._timers.append(timer)
        self._rt_changed()
        return timer

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Return something that sleeps to a rate in Hz while another thread spins.

        Raises:
            ValueError: the frequency is not positive.
        """
        if frequency <= 0:
            raise ValueError("frequency must be > 0")
        return Rate(self.create_timer(1.0 / frequency, None, self._rate_group, clock), context=self._context)

    # Ends --------------------------------------------------------------------------------------------------

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """Destroy a publisher of this node; return whether it was one."""
        return self._rt_destroy(self._publishers, publisher)

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Destroy a subscription of this node; return whether it was one."""
        return self._rt_destroy(self._subscriptions, subscription)

    def destroy_service(self, service: Service) -> bool:
        """Destroy a service of this node; return whether it was one."""
        return self._rt_destroy(self._services, service)

    def destroy_client(self, client: Client) -> bool:
        """Destroy a client of this node; return whether it was one."""
        return self._rt_destroy(self._clients, client)

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer of this node; return whether it was one."""
        return self._rt_destroy(self._timers, timer)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate of this node; return whether it was one."""
        success = self.destroy_timer(rate._timer)
        rate.destroy()
        return success

    def _rt_destroy(self, owned: list[Any], entity: Any) -> bool:
        if entity not in owned:
            return False
        owned.remove(entity)
        if isinstance(entity, (Publisher, Subscription)):
            self._rt_withdraw([entity._gid])
        elif isinstance(entity, (Service, Client)):
            self._rt_withdraw(list(entity._gids()))
        entity.destroy()
        self._rt_changed()
        return True

    def _rt_destroy_entities(self, leave: bool) -> None:
        """Drop everything owned; `leave` deletes it from DDS too, which is needless after the participant."""
        everything: tuple[list[Any], ...] = (
            self._publishers,
            self._subscriptions,
            self._clients,
            self._services,
            self._timers,
            self._rt_batches,
        )
        for owned in everything:
            for entity in tuple(owned):
                owned.remove(entity)
                if leave:
                    entity.destroy()

    def _rt_announce(self, readers: list[bytes] | None = None, writers: list[bytes] | None = None) -> None:
        self._rt_entry.readers.extend(readers or ())
        self._rt_entry.writers.extend(writers or ())
        self._context._graph_opened.announce()
        self._rt_changed()

    def _rt_withdraw(self, gids: list[bytes]) -> None:
        entry = self._rt_entry
        entry.readers = [gid for gid in entry.readers if gid not in gids]
        entry.writers = [gid for gid in entry.writers if gid not in gids]
        self._context._graph_opened.announce()


def _topic_of(name: str, qos: QoSProfile) -> str:
    return name.lstrip("/") if qos.avoid_ros_namespace_conventions else dds_topic(name)


def _refuse_overriding(options: Any) -> None:
    if options is not None:
        raise unsupported("qos_overriding_options", options, None)
