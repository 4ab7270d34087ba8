"""Warnings against dangers whose delays, leads and misses are known."""

import numpy as np
import pytest

from seat_gear_dynamics.logs.analysis.batches import Warned
from seat_gear_dynamics.logs.analysis.detection import DangerSpans, Detection, LevelSpans, Span, detect


def held(dangers: list[tuple[float, float]], *warnings: tuple[float, int, str]) -> Detection:
    spans, levels = DangerSpans(lambda drive: drive[:, 1] > 0), LevelSpans()
    spans.spans = [Span(*danger) for danger in dangers]
    levels.add([Warned(time, level, "", regime) for time, level, regime in warnings])
    return detect(spans, levels)


def test_delay_and_lead_of_a_warning_that_comes_in_time() -> None:
    found = held([(5.0, 8.0)], (0.0, 0, ""), (3.0, 1, ""), (5.04, 2, ""), (8.5, 0, ""))
    assert found.episodes[0].delay == pytest.approx(0.04)
    assert found.episodes[0].lead == pytest.approx(2.0)
    assert (found.missed, found.errors, found.false) == (0, 1, ())


def test_an_error_that_stands_already_has_no_delay_and_a_danger_without_one_is_missed() -> None:
    found = held([(5.0, 6.0), (20.0, 21.0)], (0.0, 0, ""), (4.0, 2, ""), (7.0, 0, ""), (30.0, 0, ""))
    assert [episode.delay for episode in found.episodes] == [0.0, None]
    assert found.missed == 1
    np.testing.assert_array_equal(found.delays(), [0.0])


def test_errors_outside_every_danger_are_false_and_those_that_state_chaos_are_told_apart() -> None:
    rows = [(0.0, 0, ""), (2.0, 2, "chaotic"), (3.0, 0, ""), (10.0, 2, "periodic"), (11.0, 0, ""), (12.0, 0, "")]
    found = held([(5.0, 6.0)], *rows)
    assert found.false == (Span(2.0, 3.0), Span(10.0, 11.0))
    assert found.false_chaotic == 1
    assert found.missed == 1


def test_stale_is_no_warning() -> None:
    found = held([(5.0, 6.0)], (0.0, 3, ""), (9.0, 0, ""))
    assert found.missed == 1
    assert found.episodes[0].lead is None
    assert found.errors == 0


def test_noise_at_an_edge_makes_one_stretch_of_danger() -> None:
    spans = DangerSpans(lambda drive: drive[:, 1] > 0)
    flags = [0, 1, 0, 1, 1, 0, 0, 1] + [0] * 60 + [1]
    rows = np.column_stack([0.02 * np.arange(len(flags)), flags, flags, flags]).astype(float)
    for part in np.array_split(rows, 7):
        spans.add(part)
    np.testing.assert_allclose(spans.spans, [(0.02, 0.14), (1.36, 1.36)])


def test_seconds_by_level_and_regime_add_up_to_the_time_between_first_and_last() -> None:
    levels = LevelSpans()
    levels.add([Warned(0.0, 0, "a", "periodic"), Warned(1.0, 2, "b", "chaotic")])
    levels.add([Warned(4.0, 2, "c", "undecided"), Warned(5.0, 0, "d", "undecided")])
    assert levels.seconds == {(0, "periodic"): 1.0, (2, "chaotic"): 3.0, (2, "undecided"): 1.0}
    assert [(span, level, text) for span, level, text in levels.spans] == [
        (Span(0.0, 1.0), 0, "a"),
        (Span(1.0, 5.0), 2, "b"),
        (Span(5.0, 5.0), 0, "d"),
    ]


def test_nothing_gives_nothing() -> None:
    found = held([])
    assert (found.episodes, found.false, found.errors, found.missed) == ((), (), 0, 0)
