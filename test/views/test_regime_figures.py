"""Figures of sweeps, maps and basins: drawn of results made here, they show what the results hold."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import Window
from seat_gear_dynamics.regimes import MeshForce, Regime
from seat_gear_dynamics.regimes.attractors import LOST, Attractor
from seat_gear_dynamics.regimes.basins import Basins
from seat_gear_dynamics.regimes.regime_map import RegimeMap
from seat_gear_dynamics.regimes.sweep import UNITS, Row, Sweep, Way
from seat_gear_dynamics.views.figures.basins import basins_figure
from seat_gear_dynamics.views.figures.bifurcation import bifurcation_figure
from seat_gear_dynamics.views.figures.regime_map import cell_edges, regime_map_figure
from seat_gear_dynamics.views.figures.style import save

FORCE = MeshForce(1.0, 0.0, 2.0, 1.1, 0.0, 1.0)


def row(value: float, way: Way, name: Any, delta: float) -> Row:
    regime = Regime(name, 1 if name == "periodic" else None, 0.01, 0.002, "made")
    return Row(value, way, regime, FORCE, np.full((5, 2), delta))


def both_ways() -> Sweep:
    up = [row(float(k), "up", "periodic", 1.0) for k in range(4)]
    down = [row(float(k), "down", "chaotic" if k == 3 else "periodic", 2.0 if k in (1, 2) else 1.0) for k in range(4)]
    return Sweep("speed_rpm", (*up, *down))


def words(figure: Any) -> set[str]:
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    return {text.get_text() for legend in legends for text in legend.get_texts()}


def drawn_points(axes: Any) -> int:
    return sum(len(line.get_xdata()) for line in axes.get_lines() if line.get_marker() == ".")


def test_up_and_down_have_panels_of_their_own_and_every_point_is_drawn() -> None:
    figure = bifurcation_figure(both_ways())
    up, down, exponent = figure.axes
    assert (drawn_points(up), drawn_points(down)) == (20, 20)
    assert up.get_title(loc="left").startswith("up")
    assert down.get_title(loc="left").startswith("down")
    assert exponent.get_xlabel() == "speed of s1, r/min"
    assert {"periodic", "chaotic", "up and down differ", "up", "down"} <= words(figure)
    assert "quasi-periodic" not in words(figure)
    assert all(axes.get_ylabel() for axes in figure.axes)


def test_a_cold_sweep_has_one_panel_of_points_and_no_word_of_differences() -> None:
    figure = bifurcation_figure(Sweep("load", tuple(row(float(k), "cold", "chaotic", 1.0) for k in range(3))))
    assert len(figure.axes) == 2
    assert "up and down differ" not in words(figure)


@pytest.mark.parametrize("over", UNITS)
def test_every_quantity_names_itself_and_its_unit(over: Any) -> None:
    figure = bifurcation_figure(Sweep(over, tuple(row(float(k), "cold", "periodic", 1.0) for k in range(2))))
    label = figure.axes[-1].get_xlabel()
    assert label.endswith(UNITS[over]) or UNITS[over] == "1"


def test_a_sweep_that_diverged_everywhere_is_still_a_figure(tmp_path: Path) -> None:
    nothing = Regime("undecided", None, None, None, "diverged")
    lost = Row(1.0, "up", nothing, None, np.empty((0, 2)))
    figure = bifurcation_figure(Sweep("load", (lost, replace(lost, value=2.0))))
    assert drawn_points(figure.axes[0]) == 0
    save(figure, tmp_path / "f.png")
    assert (tmp_path / "f.png").read_bytes().startswith(b"\x89PNG")


def regime_map(samples: int = 0) -> RegimeMap:
    chaos = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    codes = np.where(chaos > 0, 2, np.array([[0, 0, 0, 3], [0, 1, 0, 0]])).astype(np.int64)
    force = np.where(codes == 3, np.nan, 100.0)
    speeds, loads = RPM * np.array([100.0, 200.0, 300.0, 400.0]), np.array([300.0, 600.0])
    return RegimeMap(speeds, loads, codes, codes, chaos, chaos, force, chaos, samples, "made", 1, 48)


def test_a_map_shows_its_regimes_its_bands_and_what_diverged() -> None:
    figure = regime_map_figure(regime_map())
    (axes,) = figure.axes
    assert words(figure) == {"periodic", "quasi-periodic", "chaotic", "undecided", "diverged", "forbidden band"}
    bars = [tuple(np.round(line.get_xdata(), 6)) for line in axes.get_lines() if line.get_linewidth() == 2.6]
    assert bars == [(150.0, 350.0), (250.0, 350.0)]
    thin = [tuple(np.round(line.get_xdata(), 6)) for line in axes.get_lines() if line.get_linewidth() == 0.8]
    assert thin == [(100.0, 400.0), (200.0, 400.0)]  # half a step further either way
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("speed of s1, r/min", "load torque T4, N·m")


def test_a_map_of_many_machines_shows_their_probability_too() -> None:
    figure = regime_map_figure(regime_map(samples=7))
    assert len(figure.axes) == 3  # and a scale of colours
    assert any("probability of chaos, 7 machines" in axes.get_ylabel() for axes in figure.axes)


def test_cells_lie_around_their_nodes() -> None:
    assert cell_edges(np.array([1.0, 2.0, 4.0])).tolist() == [0.5, 1.5, 3.0, 5.0]
    assert cell_edges(np.array([100.0])).tolist() == [95.0, 105.0]
    assert cell_edges(np.array([0.0])).tolist() == [-1.0, 1.0]


def test_basins_name_their_motions_and_shares(tmp_path: Path) -> None:
    window = Window(duration=10.0, separated=4.5)
    regimes = Regime("periodic", 2, 0.0, 0.0, ""), Regime("chaotic", None, 0.0, 0.0, "")
    motions = tuple(Attractor(regime, np.full((4, 2), 0.5), window, np.zeros(24)) for regime in regimes)
    labels = np.array([[0, 0, 1], [0, LOST, 1]])
    figure = basins_figure(Basins(np.array([0.0, 1.0, 2.0]), np.array([-1.0, 1.0]), labels, motions))
    text = " ".join(words(figure))
    assert "period 2, contact lost 45% of the time: 50.0%" in text
    assert "chaotic" in text
    assert "diverged: 16.7%" in text
    assert "b_c" in figure.axes[0].get_xlabel()
    assert "1/τ" in figure.axes[0].get_ylabel()
    save(figure, tmp_path / "f.svg")
    assert (tmp_path / "f.svg").stat().st_size > 1000
