"""What a log tells of the monitor's parameters: each change that `/parameter_events` holds."""

from __future__ import annotations

from typing import Any, NamedTuple

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.sources import holds
from seat_gear_dynamics.logs.analysis.what_if import MONITOR_NAMES, MonitorSettings, with_numbers
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.schemas import Decoder

_INTEGER = 2  # rcl_interfaces/msg/ParameterType; the others of these parameters are doubles


class SettingChange(NamedTuple):
    """Parameters of the monitor that were declared or changed at one moment."""

    publish_ns: int
    """When the monitor said so, by the clock of its other messages' publish times."""
    values: dict[str, float]
    """Its name for a parameter, of those that a replay knows → its new value."""


def setting_changes(bag: Bag) -> list[SettingChange] | None:
    """Return the changes in order of time; None where the log has no `/parameter_events`.

    The monitor is the node of the namespace and name that its inputs' topic begins with. Limit: a node that was renamed
    has other topics than its name, and is not known again.
    """
    if not holds(bag, topics.PARAMETER_EVENTS.name):
        return None
    node = bag.resolve(topics.MODEL_INPUT.name).rsplit("/", 1)[0]
    decoder, found = Decoder({}), []
    for message in bag.messages(topics.PARAMETER_EVENTS.name):
        event = decoder.decode(message.data, topics.PARAMETER_EVENTS.type)
        if event.node != node:
            continue
        given = [*event.new_parameters, *event.changed_parameters]
        values = {each.name: _number(each.value) for each in given if each.name in MONITOR_NAMES}
        if values:
            found.append(SettingChange(message.publish_time_ns or message.log_time_ns, values))
    return sorted(found, key=lambda change: change.publish_ns)


def apply(settings: MonitorSettings, change: SettingChange) -> MonitorSettings:
    """Return the settings after a change; those that were asked for in so many words stay."""
    return with_numbers(settings, {name: v for name, v in change.values.items() if name not in settings.given})


def _number(value: Any) -> float:
    return float(value.integer_value if value.type == _INTEGER else value.double_value)
