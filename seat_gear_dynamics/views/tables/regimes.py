"""Columns of sweeps, regime maps and basins of attraction."""

from typing import Any

import numpy as np

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.plotting import Column, Table
from seat_gear_dynamics.regimes.basins import Basins
from seat_gear_dynamics.regimes.regime_map import NAMES, RegimeMap
from seat_gear_dynamics.regimes.sweep import UNITS, Sweep
from seat_gear_dynamics.regimes.sweep_table import COLUMNS, POINT_COLUMNS

_UNITS = {"lyapunov": "1/τ", "lyapunov_error": "1/τ"}


def sweep_table(found: Sweep, *, points: bool = False) -> Table:
    """Return a row for each value and direction, as `seat-gear sweep` writes it; with `points` the section points.

    The forces are those of s1_s2.
    """
    unit = _shown(UNITS[found.over])
    if points:
        return _points(found, unit)
    units = {name: _UNITS.get(name, "N" if name.startswith("force") else "") for name in COLUMNS}
    return Table.of_rows([row.as_dict() for row in found.rows], units | {"value": unit})


def _points(found: Sweep, unit: str) -> Table:
    units = {"value": unit, "direction": "", "delta": "b_c", "rate": "b_c/τ"}
    rows: list[dict[str, Any]] = [
        dict(zip(POINT_COLUMNS, (row.value, row.direction, delta, rate), strict=True))
        for row in found.rows
        for delta, rate in row.section.tolist()
    ]
    return Table.of_rows(rows, units)


def map_table(found: RegimeMap) -> Table:
    """Return a row for each node, speed by speed within each load; forces and loss of contact are those of s1_s2."""
    speeds, loads = np.tile(found.speeds, len(found.loads)), np.repeat(found.loads, len(found.speeds))
    return Table(
        (
            Column("speed", "rad/s", speeds),
            Column("speed_rpm", "r/min", speeds / RPM),
            Column("load", "N·m", loads),
            Column("regime", "", [NAMES[code] for code in found.codes.ravel()]),
            Column("period", "", found.period.ravel()),
            Column("lyapunov", "1/τ", found.lyapunov.ravel()),
            Column("contact_loss", "", found.contact_loss.ravel()),
            Column("force_max", "N", found.force_max.ravel()),
            Column("chaos", "", found.chaos.ravel()),
        )
    )


def basins_table(found: Basins) -> Table:
    """Return a row for each start: where it is, and the number of the motion it settles on; -1 where it diverged."""
    count = len(found.deflections)
    return Table(
        (
            Column("delta", "b_c", np.tile(found.deflections, len(found.rates))),
            Column("rate", "b_c/τ", np.repeat(found.rates, count)),
            Column("motion", "", found.labels.ravel()),
        )
    )


def _shown(unit: str) -> str:
    return "" if unit == "1" else unit
