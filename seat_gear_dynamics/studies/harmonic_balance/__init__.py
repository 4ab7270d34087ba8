"""Harmonic balance of P12: response curves through folds, with stability, and their agreement with integration."""

from seat_gear_dynamics.studies.harmonic_balance.branch import BIFURCATIONS, Bifurcation, Branch, Motion
from seat_gear_dynamics.studies.harmonic_balance.comparison import Agreement, compare
from seat_gear_dynamics.studies.harmonic_balance.newton import NoSolutionError
from seat_gear_dynamics.studies.harmonic_balance.orbit import CONTACT_STATES, Orbit
from seat_gear_dynamics.studies.harmonic_balance.pair import PARAMETERS, Conditions, Pair, pair
from seat_gear_dynamics.studies.harmonic_balance.response_curve import ResponseCurve, response_curve
from seat_gear_dynamics.studies.harmonic_balance.table import COLUMNS, rows

__all__ = [
    "BIFURCATIONS",
    "COLUMNS",
    "CONTACT_STATES",
    "PARAMETERS",
    "Agreement",
    "Bifurcation",
    "Branch",
    "Conditions",
    "Motion",
    "NoSolutionError",
    "Orbit",
    "Pair",
    "ResponseCurve",
    "compare",
    "pair",
    "response_curve",
    "rows",
]
