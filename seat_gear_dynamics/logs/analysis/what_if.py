"""Parameters other than the log's: a description with values replaced, the monitor's settings, the source of bands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fnmatch import fnmatch
from typing import Any, NamedTuple

import yaml

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.sources import holds
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.schemas import Decoder
from seat_gear_dynamics.sensing import AlarmSettings, BandSource, PublishedBands

_ALARM = {
    "margin_rpm": ("margin", RPM),
    "horizon": ("horizon", 1.0),
    "hysteresis_rpm": ("hysteresis", RPM),
    "debounce": ("debounce", 1.0),
    "hold": ("hold", 1.0),
}
_OTHERS = ("input_timeout", "section_points")
MONITOR_NAMES = (*_ALARM, *_OTHERS)
"""Parameters of the monitor that a replay knows, by the monitor's names."""
BANDS_KEY = "bands"
"""The value of a warning that names the bands it was judged by: the label of their source."""


class MonitorSettings(NamedTuple):
    """What a monitor was run with beside the gear train; the monitor's defaults."""

    alarm: AlarmSettings = AlarmSettings()
    max_gap: float = 0.5
    """s"""
    section_points: int = 256
    bands: BandSource | None = None
    """None: the published ones."""
    given: frozenset[str] = frozenset()
    """The monitor's names of those that were asked for: what a log tells of them does not count."""


def monitor_settings(given: Mapping[str, str]) -> MonitorSettings:
    """Return the settings with those of `given` (monitor's name → number as text) replaced.

    Raises LogError, naming the parameter, for an unknown one and for what is no possible number.
    """
    values = {name: _number(name, text) for name, text in given.items()}
    for name in values:
        if name not in MONITOR_NAMES:
            raise LogError(
                f"The parameter {name!r} is unknown; expected one of {', '.join(MONITOR_NAMES)}, or a parameter of the "
                f"system by its path, such as meshes.s1_s2.damping_ratio."
            )
    return with_numbers(MonitorSettings(given=frozenset(given)), values)


def with_numbers(settings: MonitorSettings, values: Mapping[str, float]) -> MonitorSettings:
    """Return `settings` with those of `values` (monitor's name, of MONITOR_NAMES → number in its unit) replaced.

    Raises LogError for an impossible number.
    """
    alarm = {_ALARM[name][0]: value * _ALARM[name][1] for name, value in values.items() if name in _ALARM}
    gap = values.get("input_timeout", settings.max_gap)
    points = values.get("section_points", settings.section_points)
    if gap <= 0 or points < 1:
        raise LogError(
            f"input_timeout is {gap:g} s and section_points {points:g}; expected more than 0 and at least 1."
        )
    try:
        alarm_settings = replace(settings.alarm, **alarm)
    except ValueError as error:
        raise LogError(str(error)) from error
    return settings._replace(alarm=alarm_settings, max_gap=gap, section_points=int(points))


def recorded_bands(bag: Bag) -> str | None:
    """Return the label of the bands that the log's first warning was judged by; None where none says it.

    Limit: a monitor that took another map while the log ran is not noticed.
    """
    name = topics.CHAOS_WARNING.name
    if not holds(bag, name):
        return None
    first = next(iter(bag.messages(name)), None)
    if first is None:
        return None
    status = Decoder({}).decode(first.data, topics.DIAGNOSTIC_STATUS)
    return {value.key: str(value.value) for value in status.values}.get(BANDS_KEY)


def other_bands(logged: str | None, replayed: str) -> str | None:
    """Return a sentence where a log and its replay were judged by bands of other labels.

    None where they agree, or where the log does not say (`logged` None) and the replay has the published ones, which
    are the monitor's default.
    """
    if (logged or PublishedBands.label) == replayed:
        return None
    if logged is None:
        return f"The log does not say by which bands its warnings were judged; the replay's are of `{replayed}`."
    return f"The log's warnings were judged by the bands of `{logged}`, the replay's by those of `{replayed}`."


def with_values(text: str, given: Mapping[str, str]) -> str:
    """Return the description `text` (YAML) with values replaced: path or pattern, as meshes.*.damping_ratio → value.

    Values are in the unit that the description has for them. Raises LogError for a path that names no parameter; what
    the values may be is checked when the description is read.
    """
    if not given:
        return text
    document = yaml.safe_load(text)
    entries = _entries(document)
    for entry in entries.values():  # YAML 1.1 takes 2.05e11 for a text
        entry["value"] = _plain(entry["value"])
    for pattern, value in given.items():
        paths = [pattern] if pattern in entries else [path for path in entries if fnmatch(path, pattern)]
        if not paths:
            raise LogError(
                f"The system has no parameter {pattern!r}; expected a path such as gears.s1.mass, "
                f"meshes.s1_s2.backlash or model.load_scale."
            )
        for path in paths:
            entries[path]["value"] = _plain(value)
    replaced: str = yaml.safe_dump(document, allow_unicode=True, sort_keys=False)
    return replaced


def split(settings: list[str]) -> tuple[dict[str, str], dict[str, str]]:
    """Return NAME=VALUE settings as (of the system, of the monitor); a name with a dot is the system's.

    Raises LogError for what is no NAME=VALUE.
    """
    system: dict[str, str] = {}
    monitor: dict[str, str] = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not equals or not name or not value:
            raise LogError(f"--set got {setting!r}, expected NAME=VALUE, such as meshes.s1_s2.damping_ratio=0.09.")
        (system if "." in name else monitor)[name] = value
    return system, monitor


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise LogError(f"The parameter {name} is {text!r}, expected a number.") from error


def _plain(value: Any) -> Any:
    """Return a text as the number, truth value or list that it spells, else as it is."""
    if not isinstance(value, str):
        return [_plain(item) for item in value] if isinstance(value, list) else value
    try:
        return float(value)
    except ValueError:
        return yaml.safe_load(value) if value.startswith("[") or value in ("true", "false") else value


def _entries(node: Any, path: str = "") -> dict[str, dict[str, Any]]:
    if isinstance(node, dict) and "value" in node:
        return {path: node}
    found: dict[str, dict[str, Any]] = {}
    pairs = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in pairs:
        name = f"{path}[{key}]" if isinstance(key, int) else f"{path}.{key}" if path else str(key)
        found |= _entries(child, name)
    return found
