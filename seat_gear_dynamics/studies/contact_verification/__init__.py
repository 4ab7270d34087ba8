"""The verification model of section 4, rebuilt: rigid gears whose flanks touch by ADAMS' IMPACT force."""

from seat_gear_dynamics.studies.contact_verification.claims import Comparison, Finding, findings, static_chain
from seat_gear_dynamics.studies.contact_verification.conditions import CONDITIONS, TABLE_4, Condition
from seat_gear_dynamics.studies.contact_verification.readings import READINGS, Assumptions
from seat_gear_dynamics.studies.contact_verification.verify import (
    ConditionRun,
    ForceHistory,
    Statistics,
    run_condition,
    run_conditions,
    start_up,
)

__all__ = [
    "CONDITIONS",
    "READINGS",
    "TABLE_4",
    "Assumptions",
    "Comparison",
    "Condition",
    "ConditionRun",
    "Finding",
    "ForceHistory",
    "Statistics",
    "findings",
    "run_condition",
    "run_conditions",
    "start_up",
    "static_chain",
]
