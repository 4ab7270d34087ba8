"""Scores of motions whose kind is known."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.studies.calibration.operating_points import OperatingPoints, operating_points
from seat_gear_dynamics.studies.calibration.score import WEIGHTS, Judged, cost, judge, scores

Array = NDArray[np.float64]
PERIODS = 96


def periodic(period: int) -> Array:
    one = np.column_stack([np.arange(period), np.zeros(period)])
    return np.asarray(np.tile(one, (PERIODS // period + 1, 1))[:PERIODS], dtype=float)


def torus(curves: int = 1) -> Array:
    angle = 2 * np.pi * (5**0.5 - 1) / 2 * np.arange(PERIODS)
    centre = np.exp(2j * np.pi * np.arange(PERIODS) / curves) * (10 if curves > 1 else 0)
    return np.column_stack([centre.real + np.cos(angle), centre.imag + np.sin(angle)])


def noise(seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=(PERIODS, 2))


def test_period_torus_chaos_and_divergence_are_told_apart() -> None:
    section = np.stack([periodic(1), periodic(4), torus(), noise(1), noise(2)])
    growth = np.full((5, PERIODS), -0.02) * np.array([1, 1, 0, -10, 0])[:, None]
    seen = judge(section, growth, np.array([False] * 4 + [True]), np.full(5, 1.0))
    assert seen.period.tolist() == [1, 4, 0, 0, -1]
    assert seen.chaotic.tolist() == [0, 0, 0, 1, 0]  # 0.2/2π per τ is well above the soft threshold
    assert seen.calm.tolist() == [1, 1, 1, 0, 0]


def ideal(points: OperatingPoints) -> Judged:
    """What the paper says of every point."""
    n = len(points.claim)
    period, section = np.ones(n, dtype=np.int64), np.zeros((n, PERIODS, 2))
    chaotic, calm = np.zeros(n), np.ones(n)
    backlash = points.backlash[points.of("C10")]
    wild = np.concatenate(
        [
            points.of("C2"),
            points.of("C3"),
            points.of("C9 low"),
            points.of("C9 about")[:2],
            points.of("C10")[backlash > 15e-6],
            points.of("C7 0.09")[-3:],
            points.of("C7 0.11")[-1:],
        ]
    )
    period[wild], chaotic[wild], calm[wild] = 0, 1.0, 0.0
    period[points.of("C8")[3]] = 4
    three = points.of("C4")[0]
    period[three], section[three] = 0, torus(3)
    return Judged(period, chaotic, calm, section)


def test_the_paper_itself_costs_nothing() -> None:
    points = operating_points()
    found = scores(points, ideal(points))
    assert found == pytest.approx(dict.fromkeys(WEIGHTS, 1.0))
    assert cost(found, 0, 0.0) == pytest.approx(0.0)


@pytest.mark.parametrize("claim", ["C1", "C3", "C5", "C9 low", "C9 high"])
def test_each_point_that_is_otherwise_costs(claim: str) -> None:
    points = operating_points()
    seen = ideal(points)
    one = points.of(claim)[0]
    seen.period[one], seen.chaotic[one] = 0, 1 - seen.chaotic[one]
    seen.calm[one] = 1 - seen.calm[one]
    found = scores(points, seen)
    assert found[claim] == pytest.approx(1 - 1 / len(points.of(claim)))
    assert cost(found, 0, 0.0) > 0


def test_divergence_and_leaving_the_bounds_cost_more_than_any_claim_gains() -> None:
    points = operating_points()
    found = scores(points, ideal(points))
    assert cost(found, 1, 0.0) > 1
    assert cost(found, 0, 0.25) == pytest.approx(0.25)


def test_no_point_of_the_search_is_one_that_is_reported_on() -> None:
    points = operating_points()
    band = points.frequency[points.of("C3")]
    assert np.all(np.abs(band * 100 - np.round(band * 100)) > 1e-3)
    assert len(points.claim) == len(points.frequency) == 226
