"""A sweep as text: the lines of its table and of the table of its section points, made where a row is computed."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.classification import Regime
from seat_gear_dynamics.regimes.simulate import MeshForce
from seat_gear_dynamics.regimes.sweep import Row
from seat_gear_dynamics.regimes.sweep_plan import Way

Array = NDArray[np.float64]

COLUMNS = (
    "value",
    "regime",
    "period",
    "lyapunov",
    "contact_loss",
    "force_min",
    "force_max",
    "force_mean",
    "force_rms",
    "direction",
    "lyapunov_error",
)
"""Of the table: forces in N, of s1_s2; exponent and its standard error per unit of τ; empty where nothing is said."""
POINT_COLUMNS = ("value", "direction", "delta", "rate")
"""Of the table of section points: delta in units of b_c, its rate per unit of τ."""


@dataclass(frozen=True, eq=False)
class Lines:
    """A row as text in UTF-8, and what a following sweep needs to go on behind it."""

    table: bytes
    """Its line of the table."""
    points: bytes
    """Its lines of the table of section points; none where the motion diverged."""
    direction: Way
    state: tuple[float, ...] | None
    """`Row.state`."""


def lines(row: Row) -> Lines:
    """Return the lines of `row`; numbers are written so that they read back to the last bit."""
    values = row.as_dict()
    # Plain joins: this runs for every section point, and no field holds what a table would have to quote.
    begin = f"{row.value},{row.direction},"
    points = "".join([f"{begin}{delta},{rate}\n" for delta, rate in row.section.tolist()])
    state = None if row.state is None else tuple(row.state.tolist())
    return Lines(_line(values[name] for name in COLUMNS), points.encode(), row.direction, state)


def heads() -> tuple[bytes, bytes]:
    """Return the first line of the table and that of the table of section points."""
    return _line(COLUMNS), _line(POINT_COLUMNS)


def _line(values: Iterable[object]) -> bytes:
    return (",".join("" if value is None else str(value) for value in values) + "\n").encode()


def parse(line: str, section: Array | None = None) -> Row:
    """Return the row of a line that `lines` made, with a section if that was read too.

    Limit: the table does not hold the evidence of a regime nor the static force, which are empty and NaN.
    """
    fields = dict(zip(COLUMNS, line.rstrip("\n").split(","), strict=True))
    period, exponent, error = (fields[name] or None for name in ("period", "lyapunov", "lyapunov_error"))
    regime = Regime(
        fields["regime"],  # type: ignore[arg-type]  # one of the names: `lines` wrote it
        None if period is None else int(period),
        None if exponent is None else float(exponent),
        None if error is None else float(error),
        "",
    )
    names = ("mean", "min", "max", "rms")
    known = {name: float(fields[f"force_{name}"] or nan) for name in names}
    force = MeshForce(**known, contact_loss=float(fields["contact_loss"]), static=nan) if fields["force_max"] else None
    points = np.empty((0, 2)) if section is None else section
    return Row(float(fields["value"]), fields["direction"], regime, force, points)  # type: ignore[arg-type]


def parse_section(found: Iterable[str]) -> Array:
    """Return the section, (n, 2), of n lines of the table of section points."""
    numbers = [line.split(",")[2:] for line in found]
    return np.array(numbers, dtype=float).reshape(-1, 2)
