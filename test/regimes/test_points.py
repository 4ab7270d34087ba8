"""The seam between questions and kernels: answers in order, whatever the threads; states handed on."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import astuple, replace
from itertools import repeat

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System, integrate
from seat_gear_dynamics.regimes import classify
from seat_gear_dynamics.regimes import points as points_module
from seat_gear_dynamics.regimes.points import (
    BATCH,
    Answer,
    Diverged,
    Motion,
    Point,
    abreast,
    answer,
    follow,
    increasing,
    regime_of,
    respond,
)

POINT = Point(0.9, 200.0, transient=5, periods=20)
POINTS = [replace(POINT, frequency=0.6), POINT, replace(POINT, frequency=1.6, load=50.0)]
ASTRAY = replace(POINT, state=np.full(24, 1e12))


def numbers(found: Answer) -> tuple[object, ...]:
    assert isinstance(found, Motion)
    return found.section.tolist(), found.growth.tolist(), found.forces, found.state.tolist(), found.interval


def test_an_answer_is_the_integration_of_its_point(train: GearTrain) -> None:
    found = answer(train, POINT)
    response = integrate(System(train).at(frequency=0.9, load=200.0), transient=5, periods=20)
    assert isinstance(found, Motion)
    # Lanes make the same steps but for rounding; P34, which P12 does not feel, they leave out.
    assert found.section == pytest.approx(response.section, rel=1e-9, abs=1e-9)
    assert [astuple(f) for f in found.forces] == [pytest.approx(astuple(response.windows[0]), rel=1e-9, abs=1e-9)]
    assert found.state[:6] == pytest.approx(response.state[:6], rel=1e-9, abs=1e-9)
    assert found.interval == response.period


def test_a_coupled_train_is_integrated_whole(train: GearTrain) -> None:
    coupled = train.with_shaft(2.6e4)
    found = answer(coupled, POINT)
    response = integrate(System(coupled).at(frequency=0.9, load=200.0), transient=5, periods=20)
    assert isinstance(found, Motion)
    expected = [pytest.approx(astuple(window), rel=1e-9, abs=1e-9) for window in response.windows]
    assert [astuple(f) for f in found.forces] == expected
    assert found.state == pytest.approx(response.state, rel=1e-9, abs=1e-9)


def test_a_point_too_slow_for_lanes_is_integrated_by_itself(train: GearTrain) -> None:
    slow = replace(POINT, frequency=-0.003, transient=0, periods=1)
    first, found, last = respond(train, [POINT, slow, POINT])
    response = integrate(System(train).at(frequency=-0.003, load=200.0), transient=0, periods=1)
    assert isinstance(found, Motion)
    assert found.section.tolist() == response.section.tolist()
    assert found.growth.tolist() == response.growth[:, 0].tolist()
    assert found.forces == response.windows
    assert numbers(first) == numbers(last)


def test_a_train_that_lanes_do_not_march_is_integrated(train: GearTrain, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(points_module, "supports", lambda _: False)
    found = answer(train, POINT)
    response = integrate(System(train).at(frequency=0.9, load=200.0), transient=5, periods=20)
    assert isinstance(found, Motion)
    assert found.state.tolist() == response.state.tolist()


def test_points_that_ask_for_different_things_are_each_answered_alone(train: GearTrain) -> None:
    state = np.zeros(24)
    mixed = [
        POINT,
        replace(POINT, state=state),
        replace(POINT, damping_ratio=0.2),
        replace(POINT, backlash=0.0),
        replace(POINT, periods=7),
        replace(POINT, transient=0, damping_ratio=0.0, state=state),
    ]
    assert [numbers(each) for each in respond(train, mixed)] == [numbers(answer(train, point)) for point in mixed]
    assert len({repr(numbers(answer(train, point))) for point in mixed}) == len(mixed)


@pytest.fixture(scope="module")
def alone(train: GearTrain) -> list[tuple[object, ...]]:
    """The answer to each of POINTS by itself."""
    return [numbers(answer(train, point)) for point in POINTS]


@pytest.mark.parametrize("workers", [1, 3])
def test_answers_come_in_order_and_do_not_depend_on_threads(
    train: GearTrain, alone: list[tuple[object, ...]], workers: int
) -> None:
    assert [numbers(each) for each in respond(train, POINTS, workers=workers)] == alone


def test_answers_do_not_depend_on_the_order_of_points(train: GearTrain, alone: list[tuple[object, ...]]) -> None:
    assert [numbers(each) for each in respond(train, POINTS[::-1])] == alone[::-1]


def test_damping_and_backlash_of_a_point_are_those_of_both_meshes(train: GearTrain) -> None:
    changed = train
    for index in (0, 1):
        changed = changed.with_mesh(index, damping_ratio=0.2, backlash=5e-6)
    varied = replace(POINT, damping_ratio=0.2, backlash=5e-6)
    assert numbers(answer(train, varied)) == numbers(answer(changed, POINT))
    assert varied.applied_to(train) == changed


def test_a_divergence_is_an_outcome_and_leaves_its_neighbours_alone(train: GearTrain) -> None:
    before, astray, after = respond(train, [POINT, ASTRAY, POINT], workers=2)
    assert isinstance(astray, Diverged)
    assert numbers(before) == numbers(after)
    regime = regime_of(astray)
    assert (regime.name, regime.period, regime.lyapunov) == ("undecided", None, None)
    assert "diverged" in regime.reason


def test_the_regime_of_an_answer_is_that_of_its_section(train: GearTrain) -> None:
    found = answer(train, replace(POINT, periods=64))
    assert isinstance(found, Motion)
    assert regime_of(found) == classify(found.section, found.growth, found.interval)


def test_few_points_are_taken_ahead_of_the_answer_that_is_read(train: GearTrain) -> None:
    taken = 0

    def endless() -> Iterator[Point]:
        nonlocal taken
        for point in repeat(replace(POINT, transient=0, periods=1)):
            taken += 1
            yield point

    answers = respond(train, endless(), workers=2)
    next(answers)
    assert taken <= 2 * 2 * BATCH  # two batches for each worker
    del answers


def test_followed_points_start_where_the_one_before_ended(train: GearTrain, alone: list[tuple[object, ...]]) -> None:
    first, second = follow(train, POINTS[:2])
    assert numbers(first) == alone[0]
    assert isinstance(first, Motion)
    assert numbers(second) == numbers(answer(train, replace(POINTS[1], state=first.state)))
    assert numbers(second) != alone[1]


def test_following_an_unchanged_point_goes_on_with_its_motion(train: GearTrain) -> None:
    # P12 does not feel the phase of P34, so 5 + 20 periods twice are 30 + 20 in one go: the same steps, but for the
    # rounding of the state that is handed on.
    _, second = follow(train, [POINT, POINT])
    whole = answer(train, replace(POINT, transient=30))
    assert isinstance(second, Motion)
    assert isinstance(whole, Motion)
    assert second.section == pytest.approx(whole.section, rel=1e-9, abs=1e-9)


def test_after_a_divergence_the_next_point_starts_from_rest(train: GearTrain, alone: list[tuple[object, ...]]) -> None:
    astray, after = follow(train, [ASTRAY, POINT])
    assert isinstance(astray, Diverged)
    assert numbers(after) == alone[1]


def test_sequences_advance_in_turn_until_each_is_exhausted() -> None:
    assert list(abreast([iter("abc"), iter("1"), iter("xy")])) == ["a", "1", "x", "b", "y", "c"]
    assert list(abreast([])) == []


def test_an_error_in_a_sequence_reaches_the_reader() -> None:
    def failing() -> Iterator[int]:
        yield 1
        raise RuntimeError("no more")

    with closing(abreast([failing(), iter([2, 3])])) as found:
        assert [next(found), next(found)] == [1, 2]
        with pytest.raises(RuntimeError, match="no more"):
            next(found)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"frequency": 0.0}, "frequency is 0"),
        ({"frequency": float("nan")}, "frequency is nan, expected a finite number"),
        ({"load": float("inf")}, "load is inf, expected a finite number"),
        ({"damping_ratio": -0.1}, "damping ratio is -0.1, expected a finite number of at least 0"),
        ({"backlash": float("nan")}, "backlash is nan"),
        ({"transient": -1}, "-1 transient and 20 sampled periods"),
        ({"periods": 0}, "5 transient and 0 sampled periods"),
    ],
)
def test_impossible_points_are_refused_when_they_are_made(change: dict[str, float], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        replace(POINT, **change)  # type: ignore[arg-type]


def test_no_workers_are_refused_before_anything_runs(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="Asked for 0 workers, expected at least 1"):
        respond(train, POINTS, workers=0)


@pytest.mark.parametrize("values", [[], [1.0, 1.0], [2.0, 1.0], [1.0, float("nan")], [[1.0]], 3.0])
def test_grids_that_do_not_increase_are_refused_by_name(values: object) -> None:
    with pytest.raises(ValueError, match=r"The speeds are .* expected finite numbers of rad/s"):
        increasing("speeds", values, least=0.0, unit="rad/s")


def test_grids_that_begin_too_low_are_refused() -> None:
    assert increasing("speeds", (1, 2), least=0.0, unit="rad/s").tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="lowest of the speeds is 0 rad/s, expected more than 0 rad/s"):
        increasing("speeds", (0, 2), least=0.0, unit="rad/s")
