"""An analysis as a small `Run`: what the one-page picture draws, of a log however long."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.logs.analysis.analyse import Analysis
from seat_gear_dynamics.logs.analysis.batches import FORCE_NAMES, Array
from seat_gear_dynamics.logs.analysis.histories import Binned
from seat_gear_dynamics.logs.run import Run
from seat_gear_dynamics.logs.series import JointSeries, Status


def overview(found: Analysis) -> Run:
    """Return bins of the histories as samples, stretches of warning level as warnings, and a sample of the section.

    Outputs that were computed here, because the log holds none, are left out: this is what was recorded.
    """
    recorded = not found.provenance.estimated
    points = np.concatenate([found.cloud.points(1), found.cloud.points(-1)]) if recorded else np.empty((0, 4))
    points = points[np.argsort(points[:, 3])]
    return Run(
        path=found.provenance.log,
        duration=found.duration,
        speed=_known(found.drive, "speed"),
        load=_known(found.drive, "load"),
        force=_force(found.force) if recorded else None,
        warnings=_warnings(found) if recorded else [],
        section=points[:, [1, 2, 3]],
        flows=found.flows,
        damage=found.damage,
        software_version=found.provenance.log_version,
        system_text=found.provenance.system_text,
    )


def band_boxes(found: Analysis) -> Array:
    """Return where |speed| is forbidden over time, (n, 4): begin and end in s, low and high in rad/s of s1.

    Bands that hold at every load are one box each; those that follow the load are a box for each bin of the histories,
    at the mean load in it.
    """
    source, history = found.judged_by, found.drive
    if not source.follows_load:
        return np.array([(0.0, found.duration, band.low, band.high) for band in source.at(0.0)]).reshape(-1, 4)
    load, half = history.mean("load"), history.width / 2
    spans = zip(history.time.tolist(), load.tolist(), strict=True)
    boxes = [(t - half, t + half, band.low, band.high) for t, at in spans if at == at for band in source.at(at)]
    return np.array(boxes).reshape(-1, 4)


def band_plane(found: Analysis, *, steps: int = 240) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return speeds (rad/s), loads (N·m) and where they are forbidden, (loads, speeds), over all that the map covers.

    Only for bands of a map.
    """
    chart = found.map
    assert chart is not None, "the bands are a map's, so there is one"
    speeds = np.linspace(0.0, float(chart.speeds[-1]), 2 * steps)
    loads = np.linspace(float(chart.loads[0]), float(chart.loads[-1]), steps)
    forbidden = np.zeros((len(loads), len(speeds)), dtype=bool)
    for row, load in enumerate(loads.tolist()):
        for band in found.judged_by.at(load):
            forbidden[row] |= (speeds >= band.low) & (speeds <= band.high)
    return speeds, loads, forbidden


def _known(history: Binned, name: str) -> tuple[Array, Array]:
    mean = history.mean(name)
    known = np.isfinite(mean)
    return history.time[known], mean[known]


def _force(history: Binned) -> JointSeries:
    known = np.isfinite(history.mean(FORCE_NAMES[0]))
    time = history.time[known]
    pick = {"min": history.least, "max": history.most}
    effort = {name: pick.get(name.split("/")[1], history.mean)(name)[known] for name in FORCE_NAMES}
    return JointSeries(time, (time * 1e9).astype(np.int64), {}, {}, effort)


def _warnings(found: Analysis) -> list[Status]:
    statuses = [Status(span.begin, level, text, {}) for span, level, text in found.levels.spans]
    if statuses:
        last, level, text = found.levels.spans[-1]
        statuses.append(Status(last.end, level, text, {}))
    return statuses
