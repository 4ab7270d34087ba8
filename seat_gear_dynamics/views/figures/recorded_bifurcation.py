"""The bifurcation diagram over the recorded speeds, run-up and run-down apart, above the model's."""

from typing import Any

import numpy as np

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.views.colours import BAND
from seat_gear_dynamics.views.figures.bifurcation import draw_section
from seat_gear_dynamics.views.figures.style import REGIME_COLOURS, Axes, in_style, new_figure

_MANY = 5000  # points that would run into each other
_WAYS = ((1, "up", "run-up"), (-1, "down", "run-down"))


@in_style
def recorded_bifurcation_figure(found: Analysis) -> Any:
    """Return the figure: recorded section points above, the model's adiabatic sweep below; shaded are the bands.

    Recorded points are of whatever loads the log holds, the model's of its typical load; a recorded drive that moves
    fast smears what the model shows sharp.
    """
    rows = 1 if found.sweep is None else 2
    figure, axes = new_figure(rows, 2, width=10.5, height=1.0 + 3.0 * rows, sharex=True, sharey=True, squeeze=False)
    for column, (sign, way, name) in enumerate(_WAYS):
        _draw_recorded(axes[0, column], found, sign)
        axes[0, column].set_title(f"{name}, {'computed here' if found.provenance.estimated else 'recorded'}")
        if found.sweep is not None:
            draw_section(axes[1, column], found.sweep.along("up" if way == "up" else "down"))
            axes[1, column].set_title(f"{name}, model at {found.load:.0f} N·m")
        axes[-1, column].set_xlabel("|speed| of s1, r/min")
    for panel in axes.ravel():
        for band in found.train.bands:
            panel.axvspan(band.low / RPM, band.high / RPM, color=BAND, alpha=0.12, linewidth=0.8)
    cells = found.occupancy.cells()
    if len(cells):
        low, high = float(cells[:, 0].min()) / RPM, float(cells[:, 0].max()) / RPM
        margin = 0.04 * (high - low) + 5
        axes[0, 0].set_xlim(max(low - margin, 0.0), high + margin)
    for row in axes:
        row[0].set_ylabel("δ / b_c at mesh phase 0")
        row[1].set_ylabel("")
    _legend(figure, axes[0, 0], found)
    return figure


def _draw_recorded(axes: Axes, found: Analysis, sign: int) -> None:
    points = found.cloud.points(sign)
    if not len(points):
        axes.text(0.5, 0.5, "no section point", transform=axes.transAxes, ha="center", color="#7F7F7F")
        return
    size = 1.4 if len(points) > _MANY else 2.4
    axes.plot(points[:, 0] / RPM, points[:, 1], ".", color="black", markersize=size, markeredgewidth=0, rasterized=True)
    # The whole of a wandering motion is shown, but not what a restart at rest throws about.
    low, high = np.quantile(points[:, 1], (0.001, 0.999))
    margin = 0.08 * max(high - low, 1e-3)
    axes.set_ylim(low - margin, high + margin)


def _legend(figure: Any, axes: Axes, found: Analysis) -> None:
    if found.sweep is None:
        return
    present = {row.regime.name for row in found.sweep.rows}
    names: list[str] = [name for name in REGIME_COLOURS if name in present]
    handles = [axes.plot([], [], "s", color=REGIME_COLOURS[name], markersize=6)[0] for name in names]
    figure.legend(handles, [f"model: {name}" for name in names], ncols=4, loc="outside upper right", frameon=False)
