"""The sets that no other beats in every claim."""

import pytest

from seat_gear_dynamics.studies.calibration.front import front
from seat_gear_dynamics.studies.calibration.search import Candidate


def candidate(cost: float, **scores: float) -> Candidate:
    return Candidate((), 3, cost, scores)


def test_the_front_holds_what_nothing_dominates_best_cost_first() -> None:
    a, b = candidate(2.0, C2=1.0, C5=0.8), candidate(1.0, C2=0.5, C5=1.0)
    dominated, twin = candidate(0.5, C2=0.4, C5=0.9), candidate(3.0, C2=1.0, C5=0.8)
    assert front([a, dominated, b, twin], ["C2", "C5"]) == [b, a, twin]


def test_one_claim_alone_has_its_best_as_front() -> None:
    a, b = candidate(2.0, C2=1.0), candidate(1.0, C2=0.5)
    assert front([a, b], ["C2"]) == [a]
    assert front([], ["C2"]) == []


def test_a_front_needs_claims() -> None:
    with pytest.raises(ValueError, match="name at least one"):
        front([], [])
