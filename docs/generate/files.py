"""Files that commands write: arrays of a regime map, columns of a sweep."""

from dataclasses import fields

from docs.generate.description import field_words
from docs.generate.markdown import code, plain, table
from seat_gear_dynamics.regimes import RegimeMap, regime_map
from seat_gear_dynamics.regimes.sweep_table import COLUMNS, POINT_COLUMNS

_COLUMNS = {
    "value": "of the quantity that was varied, in its unit",
    "regime": "`periodic`, `quasi-periodic`, `chaotic` or `undecided`",
    "period": "in mesh periods; empty where the motion is not periodic",
    "lyapunov": "largest exponent per unit of τ",
    "contact_loss": "share of the time that s1_s2 is out of contact, 0 to 1",
    "force_min": "least force of s1_s2, N",
    "force_max": "largest force, N",
    "force_mean": "mean force, N",
    "force_rms": "root mean square of the force, N",
    "direction": "`up`, `down` or `cold`: where the motion started from",
    "lyapunov_error": "standard error of the exponent, per unit of τ",
}
_POINTS = {
    "value": "as above",
    "direction": "as above",
    "delta": "deformation of the mesh at the section, in units of b_c",
    "rate": "its rate, in b_c per unit of τ",
}


def map_arrays() -> str:
    """Return the arrays of a map's file."""
    said = field_words("RegimeMap", regime_map)
    return table(("array", "content"), ((code(each.name), plain(said[each.name])) for each in fields(RegimeMap)))


def sweep_columns() -> str:
    """Return the columns of a sweep's table and of its section points."""
    first = table(("column of F.csv", "content"), ((code(name), _COLUMNS[name]) for name in COLUMNS))
    second = table(("column of F_points.csv", "content"), ((code(name), _POINTS[name]) for name in POINT_COLUMNS))
    return f"{first}\n\n{second}"
