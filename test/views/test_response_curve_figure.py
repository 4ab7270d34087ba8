"""The picture of a response curve: its lines are the curve's motions, its marks the bifurcations."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.studies.harmonic_balance import Agreement, ResponseCurve, response_curve
from seat_gear_dynamics.views.figures.response_curve import _pieces, response_curve_figure
from seat_gear_dynamics.views.figures.style import save

MakeTrain = Callable[..., GearTrain]


@pytest.fixture(scope="module")
def curve(train: GearTrain) -> ResponseCurve:
    return response_curve(System(train).at(load=100.0), 0.6, 0.8, harmonics=12)


def test_lines_hold_the_motions_in_their_units(curve: ResponseCurve) -> None:
    _, axes = response_curve_figure(curve)
    lines = {line.get_label(): line for line in axes[0].get_lines()}
    stable, unstable = (lines[name].get_xydata() for name in ("period 1", "period 1, unstable"))
    (branch,) = curve.branches
    micrometres = 1e6 * branch.balance.pair.length_unit
    expected = {(m.parameter, round(m.rms * micrometres, 9)) for m in branch.motions}
    drawn = {(float(x), round(float(y), 9)) for x, y in np.concatenate([stable, unstable]) if np.isfinite(x)}
    assert drawn == expected
    assert lines["period 1, unstable"].get_linestyle() == "--"
    assert np.nanmax(unstable[:, 0]) < np.nanmax(stable[:, 0])


def test_bifurcations_and_integrated_motions_are_marked(curve: ResponseCurve) -> None:
    (motion,) = curve.stable_at(0.61)
    agreements = [Agreement(0.61, "up", 1, motion, 1e-6), Agreement(0.62, "down", None, None, None)]
    _, axes = response_curve_figure(curve, agreements)
    labels = [line.get_label() for line in axes[0].get_lines()]
    assert labels.count("fold") == len(curve.folds) == 2
    assert labels.count("integrated, up") == 1
    assert "integrated, down" not in labels
    assert len({t.get_text() for t in axes[0].get_legend().get_texts()}) == len(axes[0].get_legend().get_texts())


@pytest.mark.parametrize("parameter", ["load", "backlash"])
def test_every_axis_names_its_unit(curve: ResponseCurve, parameter: str) -> None:
    low, high = {"load": (90.0, 110.0), "backlash": (1e-5, 2e-5)}[parameter]
    other = response_curve(curve.system.at(frequency=0.6), low, high, parameter=parameter, harmonics=8)
    _, axes = response_curve_figure(other)
    assert axes[-1].get_xlabel().endswith({"load": "N·m", "backlash": "µm"}[parameter])
    assert [ax.get_ylabel().split(", ")[1] for ax in axes] == ["µm", "%", "kN"]
    assert axes[-1].get_xlim() == pytest.approx([low, high] if parameter == "load" else [10, 20])


def test_runs_are_lines_with_gaps_between() -> None:
    x, y = np.arange(6.0), 10 * np.arange(6.0)
    xs, ys = _pieces(x, y, np.array([True, True, False, False, True]))
    assert np.array_equal(xs, [0, 1, 2, np.nan, 4, 5, np.nan], equal_nan=True)
    assert np.array_equal(ys, [0, 10, 20, np.nan, 40, 50, np.nan], equal_nan=True)
    assert not len(_pieces(x, y, np.zeros(5, dtype=bool))[0])


def test_a_picture_is_written(curve: ResponseCurve, tmp_path: Path) -> None:
    save(response_curve_figure(curve)[0], tmp_path / "curve.png")
    assert (tmp_path / "curve.png").stat().st_size > 10_000
