"""The drive's way through the plane of speed and load, over the regime map where there is one."""

from typing import Any

import numpy as np
from matplotlib.colors import LogNorm

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.views.colours import BAND
from seat_gear_dynamics.views.figures.regime_map import draw_regimes
from seat_gear_dynamics.views.figures.style import Axes, in_style, new_figure


@in_style
def trajectory_figure(found: Analysis) -> Any:
    """Return the figure: dots where the drive was, larger and darker the longer; hatched are the system's bands."""
    figure, axes = new_figure(width=9.5, height=5.0)
    if found.map is not None:
        draw_regimes(axes, found.map)
        legend = axes.get_legend()
        if legend is not None:
            legend.remove()
        _legend(axes, found)
    _draw_bands(axes, found)
    _draw_cells(axes, found)
    axes.set_xlabel("|speed| of s1, r/min")
    axes.set_ylabel("load torque T4, N·m")
    return figure


def _draw_bands(axes: Axes, found: Analysis) -> None:
    for band in found.train.bands:
        axes.axvspan(band.low / RPM, band.high / RPM, facecolor="none", edgecolor=BAND, hatch="//", linewidth=0.8)


def _draw_cells(axes: Axes, found: Analysis) -> None:
    cells = found.occupancy.cells()
    if not len(cells):
        axes.text(0.5, 0.5, "the drive is not known", transform=axes.transAxes, ha="center", color="#7F7F7F")
        return
    speed, load, seconds = cells[:, 0] / RPM, cells[:, 1], cells[:, 2]
    order = np.argsort(seconds)
    norm = LogNorm(max(float(seconds.min()), 1e-3), max(float(seconds.max()), 2e-3))
    size = 5 + 60 * np.sqrt(seconds / seconds.max())
    dots = axes.scatter(
        speed[order], load[order], size[order], seconds[order], cmap="Greys", norm=norm, edgecolors="white", lw=0.3
    )
    axes.figure.colorbar(dots, ax=axes, label="time in a cell of 10 r/min by 10 N·m, s")
    margin = 0.03 * float(np.ptp(speed)) + 10
    axes.set_xlim(max(float(speed.min()) - margin, 0.0), float(speed.max()) + margin)
    if found.map is None:
        axes.set_ylim(float(load.min()) - 30, float(load.max()) + 30)


def _legend(axes: Axes, found: Analysis) -> None:
    from seat_gear_dynamics.regimes.regime_map import NAMES
    from seat_gear_dynamics.views.figures.style import REGIME_COLOURS

    assert found.map is not None
    names: list[str] = [name for code, name in enumerate(NAMES) if (found.map.codes == code).any()]
    handles = [axes.plot([], [], "s", color=REGIME_COLOURS[name], markersize=7)[0] for name in names]
    handles.append(axes.fill_between([], [], facecolor="none", edgecolor=BAND, hatch="//"))
    axes.legend(handles, [*names, "forbidden band"], ncols=5, loc="lower left", bbox_to_anchor=(0, 1))
