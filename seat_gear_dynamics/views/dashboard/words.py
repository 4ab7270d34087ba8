"""The warning and the recorder in words: what is the matter, why, and what to do."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import PurePosixPath
from typing import Any

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.views.colours import LEVEL_NAMES
from seat_gear_dynamics.views.dashboard.heard import Heard, Status

WARNING_SILENT, RECORDER_SILENT, DATA_SILENT = 2.5, 3.5, 1.0
"""s without a word after which what is shown counts as old: above two periods of the slowest allowed rate."""
_SOON = 10.0  # s; a band farther ahead is not announced: the acceleration it follows from is mostly noise
_NEAR = 60.0  # r/min; where a WARN says no more, so close is near a band
_BAND = re.compile(r"([0-9.]+)\s*[-–]\s*([0-9.]+)")
_STALE = LEVEL_NAMES.index("STALE")


@dataclass(frozen=True)
class Words:
    """The warning as a person reads it; `level` numbers LEVEL_NAMES."""

    level: int
    headline: str
    reason: str
    advice: str


def warning_words(heard: Heard, covered_rpm: float) -> Words:
    """Return headline, reason and advice; a monitor that fell silent is STALE whatever it said last."""
    age, status = heard.ages.get("warning"), heard.warning
    if status is None or age is None:
        advice = "Start it (seat-gear monitor), on the same ROS_DOMAIN_ID as this dashboard."
        return Words(_STALE, "Waiting for the monitor", "No warning has been heard yet.", advice)
    if age > WARNING_SILENT:
        advice = "Do not rely on what is shown. Look whether the monitor runs, then restart it (seat-gear monitor)."
        return Words(_STALE, "The monitor is silent", f"Its last word is {age:.0f} s old.", advice)
    level = status.level if 0 <= status.level < len(LEVEL_NAMES) else _STALE
    values = dict(status.values)
    headline, advice = _judged(level, values, heard, covered_rpm)
    return Words(level, headline, status.message, advice)


def _judged(level: int, values: Mapping[str, str], heard: Heard, covered_rpm: float) -> tuple[str, str]:
    name = LEVEL_NAMES[level]
    if name == "OK":
        return "Clear", "Nothing to do."
    if name == "STALE":
        return "No verdict", _missing(values, heard, covered_rpm)
    calm = _to_calm(values)
    if name == "ERROR":
        inside = bool(heard.in_band) or _inside(values)
        otherwise = "No calm speed is known at this load: stop the drive."
        return "Inside a forbidden band" if inside else "The drive rattles", f"{calm}." if calm else otherwise
    ahead, distance = number(values, "time to band (s)"), number(values, "distance to band (r/min)")
    hold = f"Hold the speed, or {calm[0].lower()}{calm[1:]}." if calm else "Hold the speed."
    if ahead is not None and ahead <= _SOON:
        return "A forbidden band is ahead", hold
    if distance is not None and distance <= _NEAR:
        return "Close to a forbidden band", f"{calm}." if calm else "Go no closer."
    return "Signs of rattle", hold


def _inside(values: Mapping[str, str]) -> bool:
    distance = number(values, "distance to band (r/min)")
    return distance is not None and distance <= 0


def _to_calm(values: Mapping[str, str]) -> str:
    """Return the way to the nearest calm speed in words without a full stop; empty where it is not known."""
    calm, speed = number(values, "nearest calm speed (r/min)"), number(values, "speed (r/min)")
    if calm is None:
        return ""
    if speed is None:
        return f"Go to {abs(calm):.0f} r/min"
    verb = "Slow down" if abs(calm) < abs(speed) else "Speed up"
    return f"{verb} to {abs(calm):.0f} r/min, the nearest calm speed"


def _missing(values: Mapping[str, str], heard: Heard, covered_rpm: float) -> str:
    speed = number(values, "speed (r/min)")
    for name, topic in (("speed", topics.MOTOR_SPEED.name), ("load", topics.LOAD_TORQUE.name)):
        if heard.ages.get(name, DATA_SILENT + 1) > DATA_SILENT:
            return f"Look at the {name} signal: does the bench publish {topic}?"
    if speed is not None and abs(speed) > covered_rpm:
        return f"Nothing is known at this speed: go below {covered_rpm:.0f} r/min."
    return "Rely on no verdict until the level changes; the reason is beside."


def entry_words(values: Mapping[str, str]) -> tuple[str, float | None]:
    """Return when a forbidden band will be entered in words, and in s where it is soon."""
    ahead = number(values, "time to band (s)")
    if ahead == 0 or _inside(values):
        return "inside now", 0.0
    if ahead is None or ahead > _SOON:
        return f"not within {_SOON:.0f} s", None
    return f"in {ahead:.1f} s", ahead


def other_band(values: Mapping[str, str], bands: Sequence[Sequence[float]]) -> str | None:
    """Return in words the band that the monitor goes by, where it is none of those shown (r/min, with their errors)."""
    found = _BAND.fullmatch(values.get("band (r/min)", ""))
    if found is None:
        return None
    low, high = float(found[1]), float(found[2])
    if any(abs(low - b[0]) <= b[2] + 1 and abs(high - b[1]) <= b[3] + 1 for b in bands):
        return None
    return f"The monitor goes by other bands than those shown; nearest of its own: {low:.0f} to {high:.0f} r/min."


def motion_words(values: Mapping[str, str]) -> str:
    """Return the kind of motion in words."""
    regime, period = values.get("regime", "undecided"), number(values, "period")
    return f"{regime}, period {period:.0f}" if regime == "periodic" and period is not None else regime


def recorder_picture(status: Status | None, age: float | None) -> dict[str, Any]:
    """Return state, what can be done in it, and facts of the recorder, as plain JSON values."""
    if status is None or age is None or age > RECORDER_SILENT:
        known = "No recorder is heard." if status is None or age is None else f"No word for {age:.0f} s."
        return {"state": "unknown", "level": _STALE, "text": known, "can": [], "facts": []}
    values = dict(status.values)
    state = values.get("state", "unknown")
    can = ["stop", "snapshot"] if state in ("recording", "paused") else ["start", "snapshot"]
    level = status.level if 0 <= status.level < len(LEVEL_NAMES) else _STALE
    return {"state": state, "level": level, "text": status.message, "can": can, "facts": _recorder_facts(values)}


def _recorder_facts(values: Mapping[str, str]) -> list[list[str]]:
    free, full = number(values, "disk free (MB)"), number(values, "time to full (s)")
    facts = [
        ["file", PurePosixPath(values.get("file", "none")).name],
        ["written", _grouped(values.get("written", "0"))],
        ["dropped", _grouped(values.get("dropped", "0"))],
        ["snapshots", values.get("snapshots", "0")],
        ["last snapshot", PurePosixPath(values.get("last snapshot", "none")).name],
    ]
    if free is not None:
        facts.append(["disk free", f"{free / 1000:.1f} GB"])
    if full is not None:
        facts.append(["full in", f"{full / 3600:.0f} h" if full > 5400 else f"{full / 60:.0f} min"])
    return facts


def number(values: Mapping[str, str], key: str) -> float | None:
    """Return a value as a finite number, or None."""
    try:
        found = float(values.get(key, ""))
    except ValueError:
        return None
    return found if isfinite(found) else None


def _grouped(text: str) -> str:
    """Return a whole number with thin spaces between thousands; any other text as it is."""
    return f"{int(text):,}".replace(",", "\u2009") if text.isascii() and text.isdigit() else text
