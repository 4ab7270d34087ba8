"""Figs 17 and 18: panels, labels with units, scales that compare, and a picture that is one."""

from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.studies.contact_verification import (
    CONDITIONS,
    Assumptions,
    ConditionRun,
    ForceHistory,
    Statistics,
)
from seat_gear_dynamics.views.figures.contact_force import (
    CLEARANCE_CONDITIONS,
    LOAD_CONDITIONS,
    contact_force_figure,
)
from seat_gear_dynamics.views.figures.style import save


def history(duration: float, peak: float) -> ForceHistory:
    time = np.linspace(0.0, duration, 501)
    force = 5652.0 + peak * np.sin(2 * np.pi * 4 * time / duration)
    return ForceHistory(time, force, force, 0 * force, 0 * force)


def run(number: int, mesh_period: float = 0.027) -> ConditionRun:
    made = history(5.0, 100.0 * number)
    statistics = Statistics.of(made.force)
    return ConditionRun(CONDITIONS[number], Assumptions(), 5652.0, mesh_period, made, 1.0, statistics, statistics)


RUNS = {number: run(number) for number in range(4, 10)}
STARTS = {number: history(5e-4, 1000.0 * number) for number in range(4, 10)}


@pytest.mark.parametrize("numbers", [CLEARANCE_CONDITIONS, LOAD_CONDITIONS])
def test_every_condition_has_its_row_of_three_panels_in_its_units(numbers: tuple[int, ...], tmp_path: Path) -> None:
    figure, axes = contact_force_figure(RUNS, STARTS, numbers)
    assert axes.shape == (3, 3)
    for row, number in zip(axes, numbers, strict=True):
        assert row[1].get_title().startswith(f"Condition {number}: ")
        assert row[0].get_ylabel() == "force, kN"
        start, whole = row[0].lines[0], row[1].lines[0]
        assert np.allclose(start.get_xdata(), STARTS[number].time * 1e3)
        assert np.allclose(whole.get_ydata(), RUNS[number].history.force / 1e3)
        assert row[2].lines[1].get_ydata()[0] == pytest.approx(5.652)
    assert [axis.get_xlabel() for axis in axes[-1]] == ["start, ms", "whole run as sampled, s", "settled, ms"]
    save(figure, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_a_column_shares_its_scales() -> None:
    _, axes = contact_force_figure(RUNS, STARTS, CLEARANCE_CONDITIONS)
    for column in axes.T:
        assert len({axis.get_ylim() for axis in column}) == 1
        assert len({axis.get_xlim() for axis in column}) == 1


def test_settled_panel_holds_four_mesh_periods_after_the_start() -> None:
    _, axes = contact_force_figure(RUNS, STARTS, (6,))
    time = axes[0][2].lines[0].get_xdata()
    assert time[0] == pytest.approx(0.0, abs=1e-9)
    assert time[-1] <= 4 * 27.0
    assert time[-1] > 4 * 27.0 - 10.0  # one sample of this history is 10 ms


def test_standstill_shows_all_that_is_settled() -> None:
    _, axes = contact_force_figure({6: run(6, np.inf)}, STARTS, (6,))
    assert axes[0][2].lines[0].get_xdata()[-1] == pytest.approx(4000.0)


def test_nothing_to_draw_and_missing_runs_are_refused() -> None:
    with pytest.raises(ValueError, match="no conditions"):
        contact_force_figure(RUNS, STARTS, ())
    with pytest.raises(KeyError):
        contact_force_figure(RUNS, STARTS, (1,))
