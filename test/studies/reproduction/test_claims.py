"""Verdicts on motions that were made up: what the paper says is reproduced, its opposite is not."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.regimes import Regime
from seat_gear_dynamics.regimes.points import Point
from seat_gear_dynamics.studies.reproduction import frequency, parameters
from seat_gear_dynamics.studies.reproduction.claim import graded
from seat_gear_dynamics.studies.reproduction.geometry import mesh_stiffness_claim
from seat_gear_dynamics.studies.reproduction.survey import Seen, between, share, spell, survey, windows

PERIODIC = Regime("periodic", 1, -0.01, 0.001, "")
CHAOS = Regime("chaotic", None, 0.05, 0.001, "")
TORUS = Regime("quasi-periodic", None, 0.0, 0.001, "", pieces=3)
DOUBT = Regime("undecided", None, 0.004, 0.001, "")
NOTHING = np.empty((0, 2))


def period(n: int) -> Regime:
    return replace(PERIODIC, period=n)


def seen(point: Point, regime: Regime | None) -> Seen:
    return Seen(point, regime, NOTHING, None)


def as_published(f: float) -> Regime:
    """What the paper says of a frequency."""
    if 1.515 < f < 1.975 or 1.285 < f < 1.305:
        return CHAOS
    if abs(f - 1.98) < 1e-9:
        return TORUS
    return PERIODIC if f < 0.695 else period(2)


def over_frequency(says: Callable[[float], Regime | None]) -> list[Seen]:
    return [seen(p, says(p.frequency)) for p in frequency.frequency_points()]


def test_the_paper_reproduces_itself_over_frequency() -> None:
    main = over_frequency(as_published)
    close = [seen(p, as_published(p.frequency)) for p in frequency.close_points()]
    claims = [
        frequency.period_one(main),
        frequency.narrow_window(close),
        frequency.wide_band(main),
        frequency.three_curves(main),
        frequency.calm_elsewhere(main),
    ]
    assert [(c.id, c.verdict) for c in claims] == [(f"C{n}", "reproduced") for n in range(1, 6)]


@pytest.mark.parametrize(
    ("judge", "says", "verdict"),
    [
        (frequency.period_one, lambda f: period(2) if f < 0.3 else PERIODIC, "partly"),
        (frequency.period_one, lambda f: CHAOS, "not reproduced"),
        (frequency.wide_band, lambda f: CHAOS if f < 1.8 else PERIODIC, "partly"),
        (frequency.wide_band, lambda f: PERIODIC, "not reproduced"),
        (frequency.three_curves, lambda f: replace(TORUS, pieces=1), "partly"),
        (frequency.three_curves, lambda f: period(6), "partly"),
        (frequency.three_curves, lambda f: period(4), "not reproduced"),
        (frequency.three_curves, lambda f: CHAOS, "not reproduced"),
        (frequency.calm_elsewhere, lambda f: DOUBT if f < 0.25 else PERIODIC, "partly"),
        (frequency.calm_elsewhere, lambda f: None, "not reproduced"),
        (frequency.narrow_window, lambda f: PERIODIC, "not reproduced"),
    ],
)
def test_what_differs_from_the_paper_is_not_reproduced(
    judge: Callable[[list[Seen]], object], says: Callable[[float], Regime | None], verdict: str
) -> None:
    points = frequency.close_points() if judge is frequency.narrow_window else frequency.frequency_points()
    claim = judge([seen(p, says(p.frequency)) for p in points])
    assert claim.verdict == verdict  # type: ignore[attr-defined]


def test_a_chaotic_window_beside_the_claimed_one_counts_in_part() -> None:
    claim = frequency.narrow_window(
        [seen(p, CHAOS if p.frequency < 1.2687 else PERIODIC) for p in frequency.close_points()]
    )
    assert claim.verdict == "partly"
    assert claim.figures["windows"] == [(1.25, pytest.approx(1.2675))]


def test_the_published_speeds_follow_from_the_published_scale(train: GearTrain) -> None:
    claim = frequency.band_speeds(train)
    assert claim.verdict == "reproduced"
    assert claim.figures["worst_rpm"] < 1.0
    assert claim.figures["derived"] / claim.figures["published"] == pytest.approx(62.3, abs=0.1)


def test_stability_has_to_grow_at_every_step() -> None:
    def sweep(onset: float, chaos: float) -> list[Seen]:
        return over_frequency(lambda f: CHAOS if f > chaos else PERIODIC if f < onset else period(2))

    growing = {0.07: sweep(0.7, 1.5), 0.09: sweep(0.8, 1.6), 0.11: sweep(0.9, 1.9), 0.13: sweep(3.0, 3.0)}
    assert parameters.stable_region(growing).verdict == "reproduced"
    assert parameters.stable_region(growing | {0.11: sweep(0.75, 1.9)}).verdict == "partly"
    assert parameters.stable_region(dict.fromkeys(growing, sweep(0.7, 1.5))).verdict == "not reproduced"


def over_load(says: Callable[[float], Regime]) -> list[Seen]:
    return [seen(p, says(p.load)) for p in parameters.load_points()]


def test_one_load_has_to_part_chaos_from_periodic_motion() -> None:
    published = over_load(lambda t: CHAOS if t < 420 else TORUS if t < 425 else PERIODIC)
    claim = parameters.load_study(published)
    assert claim.verdict == "reproduced"
    assert 420 <= claim.figures["threshold"] <= 425
    assert parameters.load_study(over_load(lambda t: CHAOS if t < 410 else period(4))).verdict == "partly"
    assert parameters.load_study(over_load(lambda t: CHAOS if t > 410 else PERIODIC)).verdict == "not reproduced"


def test_the_backlash_is_read_in_the_unit_that_fits_best() -> None:
    def says(backlash: float) -> Regime:
        if backlash < 11e-6:
            return PERIODIC
        return replace(TORUS, pieces=2) if backlash < 11.9e-6 else CHAOS

    motions = [seen(p, says(p.backlash or 0.0)) for p in parameters.backlash_points()]
    claim = parameters.backlash_study(motions, 1e-5)
    assert claim.verdict == "reproduced"
    assert claim.figures["length_unit"] * 6 == pytest.approx(12.2e-6, rel=0.06)  # a step of the grid is 3.6 %
    calm = [seen(p, PERIODIC) for p in parameters.backlash_points()]
    assert parameters.backlash_study(calm, 1e-5).verdict == "not reproduced"


def test_period_four_may_lie_at_any_frequency() -> None:
    assert (
        parameters.period_four(over_frequency(lambda f: period(4) if 1.0 < f < 1.1 else CHAOS)).verdict == "reproduced"
    )
    assert parameters.period_four(over_frequency(lambda f: PERIODIC)).verdict == "not reproduced"


def test_the_stiffness_alternates_and_its_mean_is_told(train: GearTrain) -> None:
    claim = mesh_stiffness_claim(train)
    first = claim.figures["s1_s2"]
    assert first["contact_ratio"] == pytest.approx(1.6142, abs=1e-4)
    assert first["double_contact"] > 1.5 * first["single_contact"]
    assert claim.verdict == "partly"


def test_helpers_of_a_survey() -> None:
    assert graded(True, False) == "reproduced"
    assert windows([1, 2, 3, 4], [True, True, False, True]) == [(1, 2), (4, 4)]
    assert spell([(1.0, 1.5), (2.0, 2.0)]) == "1.00-1.50, 2.00"
    assert spell([]) == "nowhere"
    assert np.isnan(share([], lambda s: True))
    assert len(between(over_frequency(as_published), 0.1, 0.69)) == 60


def test_a_survey_tells_periodic_motion_from_divergence(make_train: Callable[..., GearTrain]) -> None:
    train = make_train({"*damping_ratio": 0.3})
    told: list[tuple[int, int]] = []
    points = [Point(0.5, 600.0, transient=60, periods=60), Point(0.6, 600.0, transient=60, periods=60)]
    found = survey(train, points, lambda done, total: told.append((done, total)))
    assert [s.name for s in found] == ["period-1", "period-1"]
    assert told == [(1, 2), (2, 2)]
    assert seen(points[0], None).name == "diverged"
    assert not seen(points[0], None).calm
