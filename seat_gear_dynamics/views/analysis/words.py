"""An analysis in words and plain values: the summary on the terminal, for programs, and at the report's head."""

from math import isfinite
from typing import Any

import numpy as np

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
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
        "stretches": None if found.stretches is None else vars(found.stretches),
        "warning_time": warning_time(found),
        "bands": [
            {
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
        "detection": detection_values(found.detection),
        "detection_map": detection_values(found.map_detection) if found.map_detection else None,
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
    where = "computed here, the log has no outputs" if found.provenance.estimated else "as logged"
    lines = [f"{found.duration:.1f} s; forces, section and warnings {where}", "warning, time by level"]
    lines += [f"  {name:6s}{seconds:9.1f} s" for name, seconds in warning_time(found).items()]
    lines.append("time in each stretch of speed (visits, longest), largest force of s1_s2")
    for stay in found.bands:
        force = stay.forces["s1_s2"].max
        most = f"{force:8.0f} N" if isfinite(force) else "       –"
        lines.append(f"  {stretch_name(stay):28s}{stay.seconds:9.1f} s  ({stay.visits}, {stay.longest:.1f} s){most}")
    lines += detection_lines(found.detection)
    if found.map_detection is not None:
        lines += ["against the regime map:", *detection_lines(found.map_detection)]
    restarts = max(len(found.restarts) - 1, 0)  # the first is the start
    lines.append(f"{found.dwells.count} dwells" + (f", {restarts} restarts of the model" if restarts else ""))
    if seams := seam_words(found):
        lines.append(seams)
    if found.damage:
        lines.append(f"damage: {found.damage}")
    return lines


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


def detection_lines(found: Detection) -> list[str]:
    """Return a detection in words."""
    if not found.episodes and not found.errors:
        return ["no stay in a band and no ERROR"]
    delays = found.delays()
    lines = [f"{len(found.episodes)} stays in danger, {found.missed} missed"]
    if len(delays):
        lines[0] += f"; time to ERROR {1e3 * np.median(delays):.0f} ms in the median, {1e3 * delays.max():.0f} at most"
    stated = f", of which {found.false_chaotic} state chaotic motion" if found.false else ""
    lines.append(f"{found.errors} times ERROR, {len(found.false)} of them outside{stated}")
    if found.unlisted:
        lines.append(f"{found.unlisted} further stretches are not listed")
    return lines


def _finite(values: dict[str, float]) -> dict[str, float | None]:
    """Return values with None for what JSON has no number for."""
    return {name: value if isfinite(value) else None for name, value in values.items()}
