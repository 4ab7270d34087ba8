"""Evidence on one scale: what each piece weighs, and what levels follow."""

from math import exp, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.regimes import Regime
from seat_gear_dynamics.regimes.classification import LEAST_CHAOS, Name
from seat_gear_dynamics.sensing import Evidence, Level
from seat_gear_dynamics.sensing.evidence import (
    ERROR_FROM,
    PRIOR,
    WARN_FROM,
    Kind,
    closeness,
    probability_of,
    scatter_of,
    together,
    warns,
    weigh,
)


def judged(name: Name, errors: float, *, zero_one: float | None = None) -> Regime:
    """Return a regime whose exponent is so many standard errors above the least of chaos."""
    return Regime(name, None, LEAST_CHAOS + 0.001 * errors, 0.001, "told so", zero_one=zero_one)


@pytest.mark.parametrize(
    ("name", "errors", "level", "lasting"),
    [
        ("periodic", -5.0, Level.OK, 0),
        ("periodic", 2.9, Level.OK, 0),
        ("quasi-periodic", 2.9, Level.OK, 0),
        ("undecided", 0.9, Level.OK, 0),
        ("undecided", 1.1, Level.WARN, 0),
        ("undecided", 50.0, Level.WARN, 3),
        ("chaotic", 3.0, Level.WARN, 0),
        ("chaotic", 50.0, Level.WARN, 0),
        ("chaotic", 4.4, Level.WARN, 1),
        ("chaotic", 4.6, Level.ERROR, 1),
        ("chaotic", 50.0, Level.ERROR, 1),
    ],
)
def test_without_a_map_classification_errors_and_time_decide(
    name: Name, errors: float, level: Level, lasting: int
) -> None:
    assert weigh(judged(name, errors), lasting=lasting).level == level


def test_the_sum_is_of_its_parts_and_they_are_named() -> None:
    found = weigh(judged("chaotic", 4.0), 0.5, lasting=2)
    assert dict(found.parts) == {"prior": 0.0, "exponent": pytest.approx(4.0), "section": 1.0, "lasting": 2.0}
    assert found.odds == pytest.approx(7.0)
    assert found.words == "prior +0.0, exponent +4.0, section +1.0, lasting +2.0"
    assert found.probability == pytest.approx(1 / (1 + exp(-7.0)))


def test_weak_chaos_that_lasts_becomes_an_error() -> None:
    levels = [weigh(judged("chaotic", 3.6), lasting=n).level for n in range(4)]
    assert levels == [Level.WARN, Level.WARN, Level.ERROR, Level.ERROR]


def test_a_map_without_chaos_asks_for_more_and_one_with_chaos_for_less() -> None:
    def least(prior: float) -> float:
        exponents = np.arange(3, 9, 0.1)
        return next(e for e in exponents if weigh(judged("chaotic", float(e)), prior, lasting=2).level == Level.ERROR)

    assert least(0.001) > least(probability_of(PRIOR)) > least(0.4)
    assert least(0.001) == pytest.approx(4.5, abs=0.11)  # within the step, and never out of reach


def test_the_zero_one_test_and_the_scatter_count_only_as_hints() -> None:
    assert weigh(judged("undecided", 0.0, zero_one=0.9)).odds == pytest.approx(PRIOR + 0.5)
    assert weigh(judged("undecided", 0.0, zero_one=0.1)).odds == pytest.approx(PRIOR - 0.5)
    assert weigh(judged("undecided", 0.0, zero_one=0.5)).odds == pytest.approx(PRIOR)
    assert weigh(judged("undecided", 2.0), scatter=1.0).odds == pytest.approx(PRIOR + 2.5)
    # A wide section with a falling exponent is a transient, and no hint of chaos.
    assert weigh(judged("undecided", -2.0), scatter=1.0).odds == pytest.approx(PRIOR - 2.0)


def test_nothing_seen_and_a_model_just_started_are_no_evidence() -> None:
    blind = Regime("undecided", None, None, None, "no section point yet")
    for found in (weigh(blind), weigh(blind, 0.9), weigh(judged("chaotic", 9.0), settled=False)):
        assert (found.level, found.seen) == (Level.OK, False)


@given(st.floats(-20, 20), st.floats(0.01, 0.99), st.sampled_from(["periodic", "chaotic", "undecided"]))
def test_more_exponent_and_more_probability_never_say_less(errors: float, prior: float, name: Name) -> None:
    found = weigh(judged(name, errors), prior)
    assert weigh(judged(name, errors + 1), prior).odds >= found.odds
    assert weigh(judged(name, errors), min(prior + 0.05, 0.999)).odds >= found.odds
    assert found.level == Level.OK or found.odds > WARN_FROM
    assert (found.level == Level.ERROR) == (found.odds >= ERROR_FROM - 1e-9)


def sign(kind: Kind, probability: float) -> Evidence:
    return Evidence(kind, Level.OK, probability, "told so")


def test_two_dangers_add_up_and_two_signs_of_one_do_not() -> None:
    assert together([]) == 0.0
    assert together([sign("band", 0.2), sign("approach", 0.1)]) == pytest.approx(0.2)
    assert together([sign("band", 0.2), sign("probability", 0.2)]) == pytest.approx(1 - 0.8 * 0.8)
    assert together([sign("probability", 0.2), sign("motion", 0.3)]) == pytest.approx(0.3)


def test_closeness_warns_exactly_from_the_margin_on() -> None:
    assert warns(closeness(0.999))
    assert not warns(closeness(1.001))
    assert closeness(0.0) == closeness(-1.0) == pytest.approx(probability_of(ERROR_FROM))


def test_scatter_is_nothing_for_a_period_and_the_size_of_noise() -> None:
    index = np.arange(64)
    period = np.column_stack([0.5 * (index % 3), np.zeros(64), index])
    assert scatter_of(period) == 0.0
    torn = np.random.default_rng(1).normal(size=(80, 3))
    kept = torn[-64:, :2]
    medians = [np.median(np.abs(kept[p:] - kept[:-p]).max(axis=1)) for p in range(1, 17)]
    assert scatter_of(torn) == min(medians)  # the same operations in the same order
    assert scatter_of(period[:31]) is None
    found = [scatter_of(np.random.default_rng(seed).normal(size=(64, 2))) for seed in range(50)]
    # The median of the larger of two |differences|, each normal with deviation sqrt 2: P(|x| < m)² = 1/2, m = 1.516.
    # The best of 16 lags is below it, by about two of the median's own deviations of some 0.12.
    assert np.mean(np.array(found, dtype=float)) == pytest.approx(1.0719 * sqrt(2), abs=0.3)
    assert max(np.array(found, dtype=float)) < 1.0719 * sqrt(2)
