"""The numbers behind every figure of a report as tables, and writing them as CSV and Parquet."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis.analyse import Analysis
from seat_gear_dynamics.logs.analysis.batches import FORCE_NAMES, MESHES
from seat_gear_dynamics.logs.analysis.detection import Detection
from seat_gear_dynamics.logs.analysis.dwells import Dwell
from seat_gear_dynamics.logs.analysis.histories import Binned
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.regimes.regime_map import NAMES

Table = Mapping[str, Sequence[Any] | np.ndarray[Any, Any]]
"""Column name, with its unit, → values; columns are of one length."""
LEVELS = ("OK", "WARN", "ERROR", "STALE")


def tables(found: Analysis) -> dict[str, Table]:
    """Return every table of an analysis by its name, that of the figure it stands behind; sizes are bounded."""
    return {
        "histories": _histories(found),
        "warnings": _levels(found),
        "trajectory": _trajectory(found),
        "bands": _bands(found),
        **(_warned(found) if found.warned else {}),
        "bifurcation": _recorded(found),
        "topics": _topics(found),
        "dwells": _dwells(found.dwells.rows),
        **_motions(found),
        **_model(found),
    }


def write_tables(written: Mapping[str, Table], folder: Path, *, parquet: bool = False) -> list[Path]:
    """Write each table to `folder` as NAME.csv, with `parquet` as NAME.parquet too; return the paths.

    Raises LogError where Parquet is wanted and pyarrow is not installed, before anything is written, and OSError.
    """
    arrow = _pyarrow() if parquet else None
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, table in written.items():
        path = folder / f"{name}.csv"
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(table)
            writer.writerows(zip(*map(_cells, table.values()), strict=True))
        paths.append(path)
        if arrow is not None:
            path = folder / f"{name}.parquet"
            arrow[1].write_table(arrow[0].table({key: list(_plain(column)) for key, column in table.items()}), path)
            paths.append(path)
    return paths


def _pyarrow() -> tuple[Any, Any]:
    try:
        return import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError as cause:
        raise LogError(
            "Parquet needs pyarrow, which is not installed; run `pip install pyarrow`, or leave --parquet out: "
            "the same tables are written as CSV."
        ) from cause


def _plain(column: Iterable[Any]) -> Iterable[Any]:
    return column.tolist() if isinstance(column, np.ndarray) else column


def _cells(column: Iterable[Any]) -> Iterable[Any]:
    """Return a column for CSV: NaN and None as empty fields."""
    return ("" if value is None or value != value else value for value in _plain(column))


def _histories(found: Analysis) -> Table:
    columns: dict[str, Any] = {"time (s)": found.drive.time}
    for name, unit, factor in (("speed", "r/min", 1 / RPM), ("load", "N·m", 1.0)):
        columns |= _three(found.drive, name, unit, factor)
    for name in FORCE_NAMES:
        mesh, statistic = name.split("/")
        values = {"min": found.force.least, "max": found.force.most}.get(statistic, found.force.mean)(name)
        columns[f"{mesh} force {statistic} (N)"] = values
    return columns


def _three(history: Binned, name: str, unit: str, factor: float) -> dict[str, Any]:
    return {
        f"{name} ({unit})": history.mean(name) * factor,
        f"{name} min ({unit})": history.least(name) * factor,
        f"{name} max ({unit})": history.most(name) * factor,
    }


def _levels(found: Analysis) -> Table:
    spans = found.levels.spans
    return {
        "begin (s)": [span.begin for span, _, _ in spans],
        "end (s)": [span.end for span, _, _ in spans],
        "level": [LEVELS[level] if level < len(LEVELS) else str(level) for _, level, _ in spans],
        "text": [text for _, _, text in spans],
    }


def _trajectory(found: Analysis) -> Table:
    cells = found.occupancy.cells()
    chart = found.map
    regimes = [
        chart.regime_at(speed, load) if chart is not None and chart.covers(speed, load) else None
        for speed, load, _ in cells.tolist()
    ]
    return {
        "|speed| (r/min)": cells[:, 0] / RPM,
        "load (N·m)": cells[:, 1],
        "time (s)": cells[:, 2],
        "regime of the map": regimes,
    }


def _bands(found: Analysis) -> Table:
    columns: dict[str, Any] = {
        "load of the map (N·m)": [stay.stretch.load for stay in found.bands],
        "outside the map": [stay.stretch.outside for stay in found.bands],
        "from (r/min)": [stay.stretch.low / RPM for stay in found.bands],
        "to (r/min)": [stay.stretch.high / RPM if np.isfinite(stay.stretch.high) else None for stay in found.bands],
        "forbidden": [stay.stretch.forbidden for stay in found.bands],
        "time (s)": [stay.seconds for stay in found.bands],
        "visits": [stay.visits for stay in found.bands],
        "longest visit (s)": [stay.longest for stay in found.bands],
    }
    for mesh in MESHES:
        for statistic in ("mean", "min", "max", "rms"):
            values = [getattr(stay.forces[mesh], statistic) for stay in found.bands]
            columns[f"{mesh} force {statistic} (N)"] = values
    return columns


def _warned(found: Analysis) -> dict[str, Table]:
    """Return what holds warnings against stays: of a log without warnings every stay would be called missed."""
    return {
        "detection": _episodes(found.detection),
        **({"detection_map": _episodes(found.map_detection)} if found.map_detection else {}),
        "false_warnings": _false(found.detection),
        "regimes_by_level": _regimes(found),
    }


def _episodes(found: Detection) -> Table:
    return {
        "begin (s)": [episode.begin for episode in found.episodes],
        "end (s)": [episode.end for episode in found.episodes],
        "delay of ERROR (s)": [episode.delay for episode in found.episodes],
        "lead of WARN (s)": [episode.lead for episode in found.episodes],
        "missed": [episode.delay is None for episode in found.episodes],
    }


def _false(found: Detection) -> Table:
    return {"begin (s)": [span.begin for span in found.false], "end (s)": [span.end for span in found.false]}


def _regimes(found: Analysis) -> Table:
    rows = sorted(found.levels.seconds.items())
    return {
        "level": [LEVELS[level] if level < len(LEVELS) else str(level) for (level, _), _ in rows],
        "regime": [regime for (_, regime), _ in rows],
        "time (s)": [seconds for _, seconds in rows],
    }


def _recorded(found: Analysis) -> Table:
    ways = {"run-up": found.cloud.points(1), "run-down": found.cloud.points(-1)}
    points = np.concatenate(list(ways.values()))
    return {
        "direction": [name for name, rows in ways.items() for _ in range(len(rows))],
        "|speed| (r/min)": points[:, 0] / RPM,
        "delta (b_c)": points[:, 1],
        "rate (b_c per tau)": points[:, 2],
        "time (s)": points[:, 3],
    }


def _topics(found: Analysis) -> Table:
    return {
        "topic": [flow.topic for flow in found.flows],
        "messages": [flow.count for flow in found.flows],
        "median period (s)": [flow.period for flow in found.flows],
        "longest gap (s)": [flow.longest_gap for flow in found.flows],
    }


def _dwells(rows: Sequence[Dwell]) -> Table:
    columns: dict[str, Any] = {
        "begin (s)": [dwell.begin for dwell in rows],
        "end (s)": [dwell.end for dwell in rows],
        "speed (r/min)": [dwell.speed / RPM for dwell in rows],
        "load (N·m)": [dwell.load for dwell in rows],
        "reached": [{1: "from below", -1: "from above"}.get(dwell.direction) for dwell in rows],
        "regime most stated": [next(iter(dwell.regimes), None) for dwell in rows],
        "its share": [next(iter(dwell.regimes.values()), None) for dwell in rows],
    }
    for m, mesh in enumerate(MESHES):
        for s, statistic in enumerate(("mean", "min", "max", "rms")):
            columns[f"{mesh} force {statistic} (N)"] = [float(dwell.force[m, s]) for dwell in rows]
    return columns


def _motions(found: Analysis) -> dict[str, Table]:
    """Return the tables of the dwells drawn, numbered from 1 in order of time."""
    motions = {id(motion.dwell): motion for motion in found.motions}
    written: dict[str, Table] = {}
    for number, dwell in enumerate(found.drawn, start=1):
        state, motion = found.dimensionless(dwell.state), motions.get(id(dwell))
        clouds = {"recorded": (state, dwell.section)}
        if motion is not None:
            clouds["model"] = (motion.portrait, motion.section)
        for k, name in enumerate(("portrait", "section")):
            points = np.concatenate([pair[k] for pair in clouds.values()])
            written[f"dwell_{number}_{name}"] = {
                "of": [of for of, pair in clouds.items() for _ in range(len(pair[k]))],
                "delta (b_c)": points[:, 0],
                "rate (b_c per tau)": points[:, 1],
            }
        if motion is not None and motion.spectra:
            first = next(iter(motion.spectra.values()))
            amplitudes = {f"{mesh} amplitude (N)": each.amplitude for mesh, each in motion.spectra.items()}
            written[f"dwell_{number}_order_spectrum"] = {"order of s1": first.orders, **amplitudes}
    return written


def _model(found: Analysis) -> dict[str, Table]:
    written: dict[str, Table] = {}
    if found.sweep is not None:
        rows = found.sweep.rows
        lengths = [len(row.section) for row in rows]
        points = np.concatenate([np.empty((0, 2)), *(row.section for row in rows)])
        written["bifurcation_model"] = {
            "direction": [row.direction for row, n in zip(rows, lengths, strict=True) for _ in range(n)],
            "|speed| (r/min)": np.repeat([row.value for row in rows], lengths),
            "regime": [row.regime.name for row, n in zip(rows, lengths, strict=True) for _ in range(n)],
            "delta (b_c)": points[:, 0],
            "rate (b_c per tau)": points[:, 1],
        }
    if found.map is not None:
        speed, load = np.meshgrid(found.map.speeds / RPM, found.map.loads)
        written["regime_map"] = {
            "|speed| (r/min)": speed.ravel(),
            "load (N·m)": load.ravel(),
            "regime": [NAMES[code] for code in found.map.codes.ravel().tolist()],
            "probability of chaos": found.map.chaos.ravel(),
            "lyapunov (1/tau)": found.map.lyapunov.ravel(),
        }
    return written
