"""An analysis in words and plain values: the summary on the terminal, for programs, and at the report's head."""

from math import isfinite
from typing import Any

import numpy as np

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.logs.analysis.bands import BandStay
from seat_gear_dynamics.logs.analysis.detection import Detection
from seat_gear_dynamics.views.colours import LEVEL_NAMES
from seat_gear_dynamics.views.figures.band_stays import stretch_name


def summary(found: Analysis) -> dict[str, Any]:
    """Return the analysis as plain values for JSON: SI units but for speeds, in r/min; None where nothing is known."""
    return {
        "log": str(found.provenance.log),
        "duration": found.duration,
        "load_scale": found.train.model.load_scale,
        "estimated": found.provenance.estimated,
        "closed": found.provenance.closed,
        "warned": found.warned,
        "stretches": None if found.stretches is None else vars(found.stretches),
        "warning_time": warning_time(found),
        "judged_by": found.judged_by.label,
        "stated_bands": list(found.stated_bands),
        "bands": [
            {
                "load": stay.stretch.load,
                "outside_map": stay.stretch.outside,
                "from_rpm": stay.stretch.low / RPM,
                "to_rpm": stay.stretch.high / RPM if isfinite(stay.stretch.high) else None,
                "forbidden": stay.stretch.forbidden,
                "seconds": stay.seconds,
                "visits": stay.visits,
                "longest": stay.longest,
                "forces": {mesh: _finite(vars(force)) for mesh, force in stay.forces.items()},
            }
            for stay in found.bands
        ],
        "detection": detection_values(found.detection) if found.warned else None,
        "detection_map": detection_values(found.map_detection) if found.map_detection and found.warned else None,
        "dwells": found.dwells.count,
        "restarts": max(len(found.restarts) - 1, 0),
        "topics": {
            f.topic: {"count": f.count, **_finite({"period": f.period, "longest_gap": f.longest_gap})}
            for f in found.flows
        },
        "damage": found.damage,
        "provenance": {
            "files": [{"name": n, "bytes": size, "sha256": digest} for n, size, digest in found.provenance.files],
            "log_version": found.provenance.log_version,
            "log_system_hash": found.provenance.log_system_hash,
            "system_hash": found.provenance.system_hash,
            "drive_topics": list(found.provenance.drive_topics),
            "notes": dict(found.provenance.notes),
        },
    }


def warning_time(found: Analysis) -> dict[str, float]:
    """Return how long each warning level stood, s, by its name."""
    total = dict.fromkeys(LEVEL_NAMES, 0.0)
    for (level, _), seconds in found.levels.seconds.items():
        if level < len(LEVEL_NAMES):
            total[LEVEL_NAMES[level]] += seconds
    return total


def detection_values(found: Detection) -> dict[str, Any]:
    """Return the figures of a detection; times in s, None where there is none."""
    delays, leads = found.delays(), np.array([e.lead for e in found.episodes if e.lead is not None])
    return {
        "stays": len(found.episodes),
        "missed": found.missed,
        "delay_median": float(np.median(delays)) if len(delays) else None,
        "delay_max": float(delays.max()) if len(delays) else None,
        "lead_median": float(np.median(leads)) if len(leads) else None,
        "errors": found.errors,
        "false": len(found.false),
        "false_that_state_chaos": found.false_chaotic,
        "unlisted": found.unlisted,
    }


def summary_lines(found: Analysis) -> list[str]:
    """Return the analysis in lines for a terminal."""
    lines = [f"{found.duration:.1f} s; {outputs_words(found)}", *state_notices(found)]
    if found.warned:
        lines.append("warning, time by level")
        lines += [f"  {name:6s}{seconds:9.1f} s" for name, seconds in warning_time(found).items()]
    lines += band_notices(found)
    lines.append(f"time in each stretch of speed (visits, longest), largest force of s1_s2; {bands_words(found)}")
    width = 2 + max((len(stretch_words(stay)) for stay in found.bands), default=26)
    for stay in found.bands:
        force = stay.forces["s1_s2"].max
        most = f"{force:8.0f} N" if isfinite(force) else "       –"
        lines.append(
            f"  {stretch_words(stay):{width}s}{stay.seconds:9.1f} s  ({stay.visits}, {stay.longest:.1f} s){most}"
        )
    lines += detection_lines(found.detection) if found.warned else []
    if found.warned and found.map_detection is not None:
        lines += ["against the chaos of the map's own nodes:", *detection_lines(found.map_detection)]
    restarts = max(len(found.restarts) - 1, 0)  # the first is the start
    lines.append(counted(found.dwells.count, "dwell"))
    if restarts:
        lines[-1] += f", {counted(restarts, 'restart')} of the model"
    if seams := seam_words(found):
        lines.append(seams)
    if found.damage:
        lines.append(f"damage: {found.damage}")
    return lines


def counted(count: int, what: str) -> str:
    """Return a number of things, as in `1 dwell`."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def outputs_words(found: Analysis) -> str:
    """Return where forces, section and warnings come from, and which of them there are not."""
    if found.provenance.estimated:
        return "forces, section points and warnings computed here, the log has no outputs"
    there = {"forces": True, "section points": found.cloud.seen > 0, "warnings": found.warned}
    held = " and ".join(", ".join(what for what, held in there.items() if held).rsplit(", ", 1))
    absent = " and no ".join(what for what, held in there.items() if not held)
    return f"{held} as logged" + (f"; the log has no {absent}" if absent else "")


def state_notices(found: Analysis) -> list[str]:
    """Return sentences on a log that is not whole."""
    notices = []
    if not found.provenance.closed:
        notices.append("The log was not ended: its recorder was killed or still writes. What it had synced is here.")
    notes = dict(found.provenance.notes)
    if "failure" in notes:
        notices.append(f"The recorder ended the log early: {notes['failure']}")
    if (gone := notes.get("files let go", "0")) != "0":
        notices.append(f"The log's beginning is gone: of its files, retention let go of the first {gone}.")
    for key, value in notes.items():
        if key.startswith("lost unread of "):
            topic = key.removeprefix("lost unread of ")
            notices.append(f"{value} messages of {topic} were lost before the recorder read them.")
    return notices


def stretch_words(stay: BandStay) -> str:
    """Return a stretch of speeds in words, with the map's load that it stands at, where bands follow the load."""
    if stay.stretch.outside:
        return "outside the map"
    at = "" if stay.stretch.load is None else f" at {stay.stretch.load:g} N·m"
    return f"{stretch_name(stay)}{at}"


def bands_words(found: Analysis) -> str:
    """Return by which bands an analysis is judged, in words."""
    if not found.judged_by.follows_load:
        return "published bands, at every load"
    return f"bands of the {found.judged_by.label}, which follow the load"


def band_notices(found: Analysis) -> list[str]:
    """Return sentences where the log's warnings were judged by other bands than those of the analysis."""
    stated, here = found.stated_bands, found.judged_by.label
    if len(stated) > 1:
        named = " and ".join(_bands_of(label) for label in stated)
        return [
            f"The monitor's bands changed while the log ran: its warnings name {named}; here {_bands_of(here)} hold."
        ]
    if not stated or stated[0] == here:
        return []
    notice = f"The log's warnings were judged by {_bands_of(stated[0])}; here they are held against {_bands_of(here)}."
    if stated[0].startswith("map ") and not found.judged_by.follows_load:
        notice += " That map is not the packaged one of this machine: give its file with --map."
    return [notice]


def _bands_of(label: str) -> str:
    return f"the bands of the {label}" if label.startswith("map ") else f"the {label} bands"


def seam_words(found: Analysis) -> str | None:
    """Return how an estimate was cut and joined; None where it was not cut."""
    cut = found.stretches
    if cut is None or cut.count < 2:
        return None
    same = cut.count - 1 - cut.shifted - cut.chaotic - cut.again
    kinds = (
        (same, "in the same state"),
        (cut.shifted, "in the same motion, some mesh periods off"),
        (cut.chaotic, "in chaos, on another path"),
        (cut.again, "after being marched again in a row"),
    )
    joined = ", ".join(f"{count} {how}" for count, how in kinds if count)
    return f"marched in {cut.count} stretches, which join: {joined}"


DETECTION_WORDS = {
    "stays": "stays in danger",
    "missed": "of these missed: no ERROR at all",
    "delay_median": "time from entry to ERROR, median",
    "delay_max": "time from entry to ERROR, longest",
    "lead_median": "time that WARN stood before entry, median",
    "errors": "times that ERROR stood",
    "false": "of these outside all danger",
    "false_that_state_chaos": "of those, with chaotic motion stated",
    "unlisted": "further stretches, not listed",
}
"""The figures of `detection_values` in words."""


def detection_lines(found: Detection) -> list[str]:
    """Return a detection in words."""
    if not found.episodes and not found.errors:
        return ["no stay in a band and no ERROR"]
    delays = found.delays()
    lines = [f"{counted(len(found.episodes), 'stay')} in danger, {found.missed} missed"]
    if len(delays):
        lines[0] += f"; time to ERROR {1e3 * np.median(delays):.0f} ms in the median, {1e3 * delays.max():.0f} at most"
    stated = f", of which {found.false_chaotic} state chaotic motion" if found.false else ""
    lines.append(f"{counted(found.errors, 'time')} ERROR, {len(found.false)} of them outside{stated}")
    if found.unlisted:
        lines.append(f"{found.unlisted} further stretches are not listed")
    return lines


def _finite(values: dict[str, float]) -> dict[str, float | None]:
    """Return values with None for what JSON has no number for."""
    return {name: value if isfinite(value) else None for name, value in values.items()}
