"""Columns of a fit to a measured bench."""

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.plotting import Table
from seat_gear_dynamics.studies.identification.identify import Fitted


def identification_table(found: Fitted) -> Table:
    """Return a row for each observable of each dwell: measured and its standard error, the model before and after.

    `left_out` says why the fit left the dwell out; it is empty where it did not.
    """
    names = [name for observed in found.observed for name in observed.names]
    dwells = [d for d, observed in enumerate(found.observed) for _ in observed.names]
    measured = [float(value) for observed in found.observed for value in observed.value]
    errors = [float(value) for observed in found.observed for value in observed.standard_error]
    unit = found.sensor.unit
    units = {"dwell": "", "speed_rpm": "r/min", "load": "N·m", "observable": "", "measured": unit}
    units |= dict.fromkeys(("standard_error", "before", "after"), unit) | {"left_out": ""}
    rows = [
        (d + 1, float(found.drives.speed[d]) / RPM, float(found.drives.load[d]), *said, found.left_out[d])
        for d, *said in zip(
            dwells, names, measured, errors, found.before.value.tolist(), found.after.value.tolist(), strict=True
        )
    ]
    return Table.of_rows([dict(zip(units, row, strict=True)) for row in rows], units)
