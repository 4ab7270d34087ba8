"""The search: repeatable, and better than its start."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.studies.calibration import search as module
from seat_gear_dynamics.studies.calibration.freedom import FREEDOMS, read
from seat_gear_dynamics.studies.calibration.restarts import distinct, restarts
from seat_gear_dynamics.studies.calibration.score import WEIGHTS
from seat_gear_dynamics.studies.calibration.search import Candidate, evaluate, search
from seat_gear_dynamics.studies.calibration.sensitivity import sensitivity
from seat_gear_dynamics.studies.calibration.starts import STARTS

MakeTrain = Callable[..., GearTrain]
START = STARTS["prototype B"]


def bowl(base: GearTrain, coordinates: object, harmonics: int, *, threads: int | None = None) -> Candidate:
    """A cost whose lowest point is known: every coordinate at its start, but the first 0.3 decades up."""
    values = tuple(f.value(float(c)) for f, c in zip(FREEDOMS, coordinates, strict=True))  # type: ignore[call-overload]
    short = sum(
        (f.code(v) - f.code(w) - (0.3 if i == 0 else 0.0)) ** 2
        for i, (f, v, w) in enumerate(zip(FREEDOMS, values, START[1], strict=True))
    )
    # As `evaluate` has it; without it the cost is flat beyond a bound, and the start lies beside one.
    beyond = sum(f.excess(float(c)) ** 2 for f, c in zip(FREEDOMS, coordinates, strict=True))  # type: ignore[call-overload]
    return Candidate(values, harmonics, float(short) + beyond, {})


def started(train: GearTrain) -> GearTrain:
    return Candidate(tuple(START[1]), 10, 0.0, {}).train(train)


def test_the_search_goes_down_to_a_known_lowest_point(train: GearTrain, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "evaluate", bowl)
    best = search(started(train), harmonics=3, evaluations=4800, seed=1)
    assert best.cost < 1e-6
    assert best.values[0] == pytest.approx(START[1][0] * 10**0.3, rel=1e-3)


def test_the_same_seed_gives_the_same_set(train: GearTrain, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "evaluate", bowl)
    runs = [search(started(train), harmonics=3, evaluations=640, seed=seed) for seed in (5, 5, 6)]
    assert runs[0] == runs[1] != runs[2]


def test_a_set_is_worth_the_same_however_many_threads_look_at_it(train: GearTrain) -> None:
    harmonics, values = START
    coordinates = [f.code(v) for f, v in zip(FREEDOMS, values, strict=True)]
    one, two = (evaluate(train, coordinates, harmonics, threads=n) for n in (1, 2))
    assert one == two
    assert 0 < one.cost < sum(WEIGHTS.values())
    assert read(one.train(train)) == pytest.approx(list(one.values))
    assert one.values[:9] == pytest.approx(values[:9])


def test_too_few_evaluations_are_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="expected at least 16, a population"):
        search(train, harmonics=3, evaluations=15, seed=1)


def test_restarts_keep_the_best_and_need_a_start(train: GearTrain, monkeypatch: pytest.MonkeyPatch) -> None:
    from seat_gear_dynamics.studies.calibration import restarts as many

    monkeypatch.setattr(module, "evaluate", bowl)
    monkeypatch.setattr(many, "evaluate", bowl)
    told: list[int] = []
    found = restarts(train, runs=2, evaluations=320, seed=3, starts=[START], report=lambda run, best: told.append(run))
    assert told == [0, 1]
    assert len(found) == 3
    start = bowl(train, [f.code(v) for f, v in zip(FREEDOMS, START[1], strict=True)], 10)
    assert found[0].cost == min(c.cost for c in found) < start.cost
    with pytest.raises(ValueError, match="no set to start from"):
        restarts(train, runs=1, evaluations=16, seed=1, starts=())


def test_sets_that_are_nearly_alike_count_once() -> None:
    first = Candidate(tuple(START[1]), 3, 1.0, {})
    twin = replace(first, cost=2.0, values=(first.values[0] * 1.01, *first.values[1:]))
    other = replace(first, cost=3.0, values=(first.values[0] * 2.0, *first.values[1:]))
    assert distinct([other, twin, first]) == [first, other]


def test_sensitivity_finds_the_drift_at_which_a_claim_is_lost(
    train: GearTrain, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A claim that holds while k1 is within 3 % of its value, whatever the rest."""
    from seat_gear_dynamics.studies.calibration import sensitivity as drifting

    base = started(train)
    k1 = read(base)[0]

    def fragile(_: GearTrain, coordinates: object, harmonics: int, *, threads: int | None = None) -> Candidate:
        values = tuple(f.value(float(c)) for f, c in zip(FREEDOMS, coordinates, strict=True))  # type: ignore[call-overload]
        met = dict.fromkeys(drifting.MET, 1.0)
        met["C3"] = 1.0 if abs(values[0] / k1 - 1) < 0.03 else 0.0
        return Candidate(values, harmonics, 0.0, met)

    monkeypatch.setattr(drifting, "evaluate", fragile)
    found = {d.name: d for d in sensitivity(base)}
    assert (found["k1"].down, found["k1"].up) == (0.02, 0.02)
    assert found["k1"].lost_down == found["k1"].lost_up == ("C3",)
    assert (found["k2"].up, found["k2"].lost_up) == (0.5, ())
