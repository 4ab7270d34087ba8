"""An analysis as a small `Run`: what the one-page picture draws, of a log however long."""

from __future__ import annotations

import numpy as np

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
