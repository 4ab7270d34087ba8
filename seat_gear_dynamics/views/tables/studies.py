"""Columns of studies: response curve, Taguchi, work and precision, sensitivity, quality of the warning."""

from dataclasses import asdict

from seat_gear_dynamics.plotting import Column, Table
from seat_gear_dynamics.studies.calibration.sensitivity import Drifts
from seat_gear_dynamics.studies.harmonic_balance import ResponseCurve
from seat_gear_dynamics.studies.harmonic_balance.table import COLUMNS, rows
from seat_gear_dynamics.studies.taguchi.result import Study
from seat_gear_dynamics.studies.taguchi.tables import effect_rows
from seat_gear_dynamics.studies.warning_quality.assess import Assessment
from seat_gear_dynamics.studies.warning_quality.score import Roc
from seat_gear_dynamics.studies.work_precision import WorkPrecision

_VALUES = {"load": "N·m", "backlash": "m"}


def response_curve_table(found: ResponseCurve) -> Table:
    """Return a row for each motion followed, branch by branch, in SI units as `harmonic_balance.table` has them."""
    units = {name: {"delta": "m", "force": "N"}.get(name.partition("_")[0], "") for name in COLUMNS}
    return Table.of_rows(rows(found), units | {"value": _VALUES.get(found.parameter, "")})


def effects_table(found: Study) -> Table:
    """Return a row for each response, factor and level: its value and mean signal-to-noise ratio; no row where the
    runs carry no analysis."""
    units = {"response": "", "factor": "", "unit": "", "level": "", "value": "", "S/N": "dB", "best": ""}
    listed = [{**row, "S/N": row["S/N (dB)"]} for row in effect_rows(found)]
    return Table.of_rows(listed, units | {"failed runs": ""})


def work_precision_table(found: WorkPrecision) -> Table:
    """Return a row for each measurement; seconds are NaN where none were taken."""
    units = {"case": "", "solver": "", "setting": "", "error": "b_c", "evaluations": "", "seconds": "s"}
    return Table.of_rows([asdict(each) for each in found.measurements], units)


def drifts_table(found: Drifts) -> Table:
    """Return a row for each parameter: value (SI), drifts at which all met claims still are, and what is lost next."""
    listed = [
        {**asdict(each), "lost_down": " ".join(each.lost_down), "lost_up": " ".join(each.lost_up)} for each in found
    ]
    return Table.of_rows(listed, dict.fromkeys(("name", "value", "down", "up", "lost_down", "lost_up"), ""))


def roc_table(found: Roc) -> Table:
    """Return a row for each threshold."""
    names = {"threshold": found.thresholds, "false_rate": found.false_rate, "true_rate": found.true_rate}
    return Table(Column(name, "", values) for name, values in names.items())


def assessment_table(found: Assessment) -> Table:
    """Return a row for each threshold of each curve; `truth` says against what the score was held."""
    columns: dict[str, list[object]] = {name: [] for name in ("truth", "score", "threshold", "false_rate", "true_rate")}
    for truth, curves in (("model", found.rocs), ("machine", found.machine_rocs)):
        for score, roc in curves.items():
            columns["truth"] += [truth] * len(roc.thresholds)
            columns["score"] += [score] * len(roc.thresholds)
            for each in roc_table(roc):
                columns[each.name] += list(each.values)
    return Table(Column(name, "", values) for name, values in columns.items())
