"""Runs that several tests look at; short, and of the train of fixed parameters."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.studies.contact_verification import (
    CONDITIONS,
    Assumptions,
    Condition,
    ConditionRun,
    run_condition,
)

Runner = Callable[..., ConditionRun]


@pytest.fixture(scope="session")
def short_run(train: GearTrain) -> Runner:
    """Run a condition, changed as asked, for 1.1 s of which 0.2 s are the start: two turns of s1 are left."""

    def run(number: int, assumptions: Assumptions | None = None, **changes: float) -> ConditionRun:
        condition: Condition = replace(CONDITIONS[number], **changes)  # type: ignore[arg-type]
        return run_condition(train, condition, assumptions, duration=1.1, settled_from=0.2)

    return run
