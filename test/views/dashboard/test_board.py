"""The board: every row once and in order to each page, clocks that step back, trends, frames that a page can read."""

import json
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.views.dashboard.board import Board, Cursor
from seat_gear_dynamics.views.dashboard.scene import Scene, Shown
from seat_gear_dynamics.views.dashboard.series import Series, Trend

START = 1_700_000_000.0


def windows(*times: float) -> np.ndarray[Any, Any]:
    return np.array([[START + t, *range(8)] for t in times], dtype=float).reshape(-1, 9)


def samples(*times: float) -> np.ndarray[Any, Any]:
    return np.array([[START + t, *range(6)] for t in times], dtype=float).reshape(-1, 7)


def read(board: Board, cursor: Cursor) -> tuple[dict[str, Any], Cursor]:
    text, after = board.frame(cursor)
    return json.loads(text), after


@settings(max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 7), st.booleans()), max_size=40), st.integers(1, 30))
def test_a_series_gives_each_row_once_and_in_order(steps: list[tuple[int, bool]], room: int) -> None:
    series, cursor, got, put = Series(room), 0, [], 0
    for count, look in steps:
        series.extend([[float(put + i)] for i in range(count)])
        put += count
        if look:
            rows = series.since(cursor)
            got += [row[0] for row in rows]
            assert len(rows) == min(put - cursor, room), "all that came, as far as it is kept"
            cursor = series.end
    assert got == sorted(set(got))


def test_a_trend_merges_windows_as_statistics_merge() -> None:
    trend = Trend(0.5, 10)
    for row in ([0.1, 1.0, -1.0, 4.0, 3.0], [0.4, 3.0, -2.0, 5.0, 4.0], [0.6, 9.0, 9.0, 9.0, 9.0]):
        trend.add(row)
    # Two windows in the first half second; the third only closes it.
    assert trend.series.since(0) == [[0.25, 2.0, -2.0, 5.0, sqrt((9 + 16) / 2)]]


def test_a_new_page_gets_what_is_kept_and_then_only_what_is_new(bench: Any, scene: Scene) -> None:
    board = Board(scene)
    bench.run(700, windows=windows(0.0, 0.02), samples=samples(0.0, 0.02), section=np.array([[1.0, 0.5, START]]))
    board.update(bench.now, 0.0)
    frame, cursor = read(board, Cursor())
    assert frame["fresh"] is True
    assert [row[0] for row in frame["windows"]] == [row[0] for row in frame["samples"]] == [0.0, 0.02]
    assert frame["section"] == [[1.0, 0.5]]
    bench.run(700, windows=windows(0.04), samples=samples(0.04), section=None)
    board.update(bench.now, 0.05)
    frame, cursor = read(board, cursor)
    assert frame["fresh"] is False
    assert [row[0] for row in frame["windows"]] == [0.04]
    assert "section" not in frame
    assert read(board, cursor)[0]["windows"] == []


def test_a_page_that_missed_ticks_gets_their_rows_with_the_next_frame(bench: Any, scene: Scene) -> None:
    board, cursor = Board(scene), Cursor()
    for k in range(10):
        bench.run(700, windows=windows(0.02 * k), samples=samples())
        board.update(bench.now, 0.05 * k)
        if k == 0:
            _, cursor = read(board, cursor)
    assert len(read(board, cursor)[0]["windows"]) == 9


def test_a_clock_that_steps_back_begins_anew_and_late_rows_are_left_out(bench: Any, scene: Scene) -> None:
    board = Board(scene)
    bench.run(700, windows=windows(100.0, 100.02, 100.01, 100.02, 100.04))
    board.update(bench.now, 0.0)
    frame, cursor = read(board, Cursor())
    assert [row[0] for row in frame["windows"]] == [100.0 - 100.0, 0.02, 0.04]
    bench.run(700, windows=windows(20.0, 20.02), samples=samples(20.0))
    board.update(bench.now, 0.05)
    frame, _ = read(board, cursor)
    assert frame["fresh"] is True
    assert [row[0] for row in frame["windows"]] == [0.0, 0.02]
    assert len(frame["samples"]) == 1


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-1e6, 1e6), max_size=30))
def test_times_increase_within_an_epoch_whatever_the_stamps(times: list[float]) -> None:
    from types import SimpleNamespace

    board = Board.__new__(Board)
    scene = SimpleNamespace(shown=lambda load, said: Shown([], "none", 2000.0), caution=lambda *given: None)
    Board.__init__(board, scene)  # type: ignore[arg-type]
    heard = SimpleNamespace(
        speed=None, load=None, section=None, warning=None, in_band=None, recorder=None, health=(), ages={}
    )
    for t in times:
        heard.windows, heard.samples = windows(t), samples(t)
        board.update(heard, 0.0)
    frame, _ = read(board, Cursor())
    for name in ("windows", "samples"):
        assert all(a[0] <= b[0] for a, b in pairwise(frame[name]))


def test_every_number_a_bench_can_send_makes_a_frame_that_a_page_can_read(bench: Any, scene: Scene) -> None:
    board = Board(scene)
    huge = 9.9e11  # the listener lets nothing larger through
    bench.say(speed=huge, load=-huge, windows=np.full((2, 9), huge), samples=np.full((2, 7), -huge))
    bench.warn(2, "\ud800 lone half of a pair", lyapunov="inf", time="-inf", nearest="1e999")
    bench.now.ages.update(speed=0.0, load=0.0, warning=0.0)
    board.update(bench.now, 0.0)
    frame, _ = read(board, Cursor())
    assert frame["now"]["calm"] is None
    assert json.loads(json.dumps(frame, allow_nan=False)) == frame


def test_the_words_of_a_frame(bench: Any, scene: Scene) -> None:
    board = Board(scene)
    bench.run(-1800)
    bench.warn(2, "inside", in_band=True, probability_of_chaos="0.83")
    bench.record("recording")
    bench.status("gear_monitor: input", 0, "50 samples a second")
    board.update(bench.now, 0.0)
    now = read(board, Cursor())[0]["now"]
    assert now["speed"] == -1800
    assert now["trip"] is True
    assert now["levelName"] == "ERROR"
    assert ["probability of chaos", "0.83"] in now["values"], "what this version does not know is shown as it came"
    assert now["bands"][0][:2] == pytest.approx([1349, 1359])
    assert now["old"] == []
    assert now["health"] == [{"name": "gear_monitor: input", "level": 0, "text": "50 samples a second"}]


def test_what_is_old_is_said_to_be(bench: Any, scene: Scene) -> None:
    board = Board(scene)
    bench.run(1800)
    bench.warn(2, "inside", in_band=True)
    bench.now.ages.update(speed=3.0, warning=30.0)
    board.update(bench.now, 0.0)
    now = read(board, Cursor())[0]["now"]
    assert now["old"] == ["speed"]
    assert now["trip"] is False, "a trip signal of half a minute ago is none"
    assert now["entry"] == "unknown"


def test_the_operating_point_leaves_a_trail_while_it_is_heard(bench: Any, scene: Scene) -> None:
    board = Board(scene)
    for k in range(8):
        bench.run(100.0 * k)
        board.update(bench.now, 0.05 * k)  # two looks at each tenth of a second
    bench.now.ages["speed"] = 5.0
    board.update(bench.now, 0.9)
    trail = read(board, Cursor())[0]["trail"]
    assert [row[1] for row in trail] == pytest.approx([0, 200, 400, 600])
