"""The cost figure: what is drawn is what was measured."""

from pathlib import Path

import pytest

from benchmarks.cost import panels
from seat_gear_dynamics.views.figures.cost import CostCurve, CostPanel, cost_figure
from seat_gear_dynamics.views.figures.style import save

CURVE = CostCurve("one core", [1, 2, 4], [30.0, 16.0, 9.0], [4.0, 4.0, 4.0])


def test_a_curve_is_drawn_with_its_limit_and_units(tmp_path: Path) -> None:
    figure = cost_figure([CostPanel("kernel", "lanes", [CURVE]), CostPanel("call", "points", [CURVE])], title="t")
    first, second = figure.axes
    cost, limit = first.get_lines()[:2]
    assert (list(cost.get_xdata()), list(cost.get_ydata())) == ([1, 2, 4], [30.0, 16.0, 9.0])
    assert list(limit.get_ydata()) == [4.0, 4.0, 4.0]
    assert limit.get_linestyle() == "--"
    assert first.get_ylabel() == "cost of a step of one motion, ns"
    assert (first.get_xlabel(), second.get_xlabel()) == ("lanes", "points")
    assert first.get_xscale() == first.get_yscale() == "log"
    save(figure, tmp_path / "cost.png")
    assert (tmp_path / "cost.png").stat().st_size > 10_000


def test_a_curve_needs_as_many_of_each() -> None:
    with pytest.raises(ValueError, match="2 values, 1 costs and 2 limits"):
        CostCurve("x", [1, 2], [1.0], [1.0, 1.0])
    with pytest.raises(ValueError, match="0 values"):
        CostCurve("x", [], [], [])


def test_a_figure_needs_a_panel() -> None:
    with pytest.raises(ValueError, match="no panel"):
        cost_figure([])


def test_the_limit_is_that_of_as_many_cores_as_work() -> None:
    figures = {
        "values": {"lanes": [1, 16], "points": [1, 64], "threads": [1, 2, 4]},
        "nanoseconds": {
            "lanes": {"full": [30.0, 4.0], "bare": [20.0, 2.0]},
            "points": {"one": [90.0, 5.0], "all": [90.0, 3.0]},
            "threads": {"full": [4.0, 2.0, 2.0]},
        },
        "limit_nanoseconds": {"full": 3.0, "bare": 1.5},
        "processors": 2,
    }
    lanes, points, threads = panels(figures)
    assert [list(curve.limit) for curve in lanes.curves] == [[3.0, 3.0], [1.5, 1.5]]
    assert [list(curve.limit) for curve in points.curves] == [[3.0, 3.0], [1.5, 1.5]]
    assert list(threads.curves[0].limit) == [3.0, 1.5, 1.5]
