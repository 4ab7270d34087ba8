"""The warning and the recorder in words: what is the matter, why, and what to do."""

from collections.abc import Mapping
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
_HERE = 20.0  # r/min; between a speed as measured and as fitted, half the least margin that is of use
_CALM = "nearest calm speed (r/min)"
_OK, _STALE = LEVEL_NAMES.index("OK"), LEVEL_NAMES.index("STALE")


class SteadyCalm:
    """Keeps the nearest calm speed from swinging: in the middle of a band noise decides which side is nearer.

    What was said first stays while the band is the same and the speed on its other side is hardly nearer.
    """

    def __init__(self) -> None:
        self._said: tuple[str, float] | None = None

    def steady(self, values: Mapping[str, str]) -> Mapping[str, str]:
        """Return a warning's values with the calm speed that is to be shown."""
        calm, speed = number(values, _CALM), number(values, "speed (r/min)")
        band = values.get("band (r/min)", "")
        if calm is None or speed is None:
            self._said = None
            return values
        if self._said is not None and self._said[0] == band:
            there, here = self._said[1] - speed, calm - speed
            if there * here < 0 and abs(there) - abs(here) < _HERE:
                return {**values, _CALM: f"{self._said[1]:.0f}"}
        self._said = (band, calm)
        return values


@dataclass(frozen=True)
class Words:
    """The warning as a person reads it; `level` numbers LEVEL_NAMES."""

    level: int
    headline: str
    reason: str
    advice: str


def warning_words(heard: Heard, covered_rpm: float, loads: str = "", values: Mapping[str, str] | None = None) -> Words:
    """Return headline, reason and advice; a monitor that fell silent is STALE whatever it said last.

    `covered_rpm` ends what is known; `loads` says in words where, if nothing is known of the present load;
    `values` stand for the warning's own where they are given.
    """
    age, status = heard.ages.get("warning"), heard.warning
    if status is None or age is None:
        advice = "Start it (seat-gear monitor), on the same ROS_DOMAIN_ID as this dashboard."
        return Words(_STALE, "Waiting for the monitor", "No warning has been heard yet.", advice)
    if age > WARNING_SILENT:
        advice = "Do not rely on what is shown. Look whether the monitor runs, then restart it (seat-gear monitor)."
        return Words(_STALE, "The monitor is silent", f"Its last word is {age:.0f} s old.", advice)
    level = status.level if 0 <= status.level < len(LEVEL_NAMES) else _STALE
    values = dict(status.values) if values is None else values
    headline, advice = _judged(level, values, heard, covered_rpm, loads)
    return Words(level, headline, status.message, advice)


def _judged(level: int, values: Mapping[str, str], heard: Heard, covered_rpm: float, loads: str) -> tuple[str, str]:
    name = LEVEL_NAMES[level]
    if name == "OK":
        return "Clear", "Nothing to do."
    if name == "STALE":
        return "No verdict", _missing(values, heard, covered_rpm, loads)
    calm = _to_calm(values)
    if name == "ERROR":
        inside = bool(heard.in_band) or _inside(values)
        otherwise = "No calm speed is known at this load: stop the drive."
        return "Inside a forbidden band" if inside else "The drive rattles", f"{calm}." if calm else otherwise
    ahead, distance = number(values, "time to band (s)"), number(values, "distance to band (r/min)")
    elsewhere = calm and not _is_here(values)
    hold = f"Hold the speed, or {calm[0].lower()}{calm[1:]}." if elsewhere else "Hold the speed."
    if ahead is not None and ahead <= _SOON:
        return "A forbidden band is ahead", hold
    if distance is not None and distance <= _NEAR:
        return "Close to a forbidden band", f"{calm}." if calm else "Go no closer."
    return "Signs of rattle", hold if elsewhere else "Watch it, and leave this speed if the level becomes ERROR."


def _inside(values: Mapping[str, str]) -> bool:
    distance = number(values, "distance to band (r/min)")
    return distance is not None and distance <= 0


def _to_calm(values: Mapping[str, str]) -> str:
    """Return the way to the nearest calm speed in words without a full stop; empty where it is not known."""
    calm, speed = number(values, _CALM), number(values, "speed (r/min)")
    if calm is None:
        return ""
    if speed is None:
        return f"Go to {abs(calm):.0f} r/min"
    verb = "Slow down" if abs(calm) < abs(speed) else "Speed up"
    return f"{verb} to {abs(calm):.0f} r/min, the nearest calm speed"


def _missing(values: Mapping[str, str], heard: Heard, covered_rpm: float, loads: str) -> str:
    speed = number(values, "speed (r/min)")
    for name, topic in (("speed", topics.MOTOR_SPEED.name), ("load", topics.LOAD_TORQUE.name)):
        if heard.ages.get(name, DATA_SILENT + 1) > DATA_SILENT:
            return f"Look at the {name} signal: does the bench publish {topic}?"
    if speed is not None and abs(speed) > covered_rpm:
        return f"Nothing is known at this speed: go below {covered_rpm:.0f} r/min."
    if loads:
        return f"Nothing is known at this load: keep it from {loads}."
    return "Rely on no verdict until the level changes; the reason is beside."


def entry_words(values: Mapping[str, str]) -> tuple[str, float | None]:
    """Return when a forbidden band will be entered in words, and in s where it is soon."""
    ahead = number(values, "time to band (s)")
    if ahead == 0 or _inside(values):
        return "inside now", 0.0
    if ahead is None or ahead > _SOON:
        return f"not within {_SOON:.0f} s", None
    return f"in {ahead:.1f} s", ahead


def calm_words(values: Mapping[str, str], level: int) -> str:
    """Return the nearest calm speed in words; where the drive is clear it is the present one."""
    calm = number(values, _CALM)
    if calm is None:
        return "unknown"
    return "this one" if level == _OK and _is_here(values) else f"{abs(calm):.0f} r/min"


def _is_here(values: Mapping[str, str]) -> bool:
    """Return whether the nearest calm speed is the present one."""
    calm, speed = number(values, _CALM), number(values, "speed (r/min)")
    return calm is not None and speed is not None and abs(calm - speed) < _HERE


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
