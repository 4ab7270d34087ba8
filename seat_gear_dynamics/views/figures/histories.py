"""Time histories of a log: speed with its forbidden bands and the warning, load, and both mesh forces."""

from typing import Any

import numpy as np

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.logs.analysis.histories import Binned
from seat_gear_dynamics.views.colours import BAND, LEVEL_COLOURS, LEVEL_NAMES, LOAD, MESH_COLOURS, SPEED
from seat_gear_dynamics.views.figures.style import Axes, in_style, new_figure


@in_style
def histories_figure(found: Analysis) -> Any:
    """Return the figure: lines are means over a bin of time, shades reach from the smallest to the largest value."""
    figure, axes = new_figure(4, 1, width=10.5, height=8.0, sharex=True, height_ratios=(2, 1, 1.3, 1.3))
    _draw_bands(axes[0], found)
    _draw(axes[0], found.drive, "speed", SPEED, 1 / RPM)
    _draw_levels(axes[0], found)
    axes[0].set_ylabel("speed of s1, r/min")
    _draw(axes[1], found.drive, "load", LOAD, 1.0)
    axes[1].set_ylabel("load T4, N·m")
    for panel, mesh, colour in zip(axes[2:], ("s1_s2", "s3_s4"), MESH_COLOURS, strict=True):
        _draw_force(panel, found, mesh, colour)
    axes[-1].set_xlabel("time since the log's start, s")
    axes[-1].set_xlim(0, max(found.duration, 1e-3))
    return figure


def _draw(axes: Axes, history: Binned, name: str, colour: str, factor: float) -> None:
    mean = history.mean(name) * factor
    known = np.isfinite(mean)
    time = history.time[known]
    low, high = (values[known] * factor for values in (history.least(name), history.most(name)))
    axes.fill_between(time, low, high, color=colour, alpha=0.25, linewidth=0)
    axes.plot(time, mean[known], color=colour, linewidth=0.9)


def _draw_bands(axes: Axes, found: Analysis) -> None:
    backward = bool((found.drive.least("speed") < 0).any())
    for sign in (1, -1) if backward else (1,):
        for band in found.train.bands:
            axes.axhspan(*sorted((sign * band.low / RPM, sign * band.high / RPM)), color=BAND, alpha=0.2, linewidth=0.8)


def _draw_levels(axes: Axes, found: Analysis) -> None:
    low, high = axes.get_ylim()
    strip = low - 0.05 * (high - low)
    present = sorted({level for _, level, _ in found.levels.spans})
    for level in present:
        spans = [(s.begin, s.end - s.begin) for s, each, _ in found.levels.spans if each == level]
        axes.broken_barh(spans, (strip - 0.02 * (high - low), 0.04 * (high - low)), color=LEVEL_COLOURS[level])
    handles = [axes.plot([], [], color=LEVEL_COLOURS[level], linewidth=6)[0] for level in present]
    handles.append(axes.fill_between([], [], color=BAND, alpha=0.3))
    names = [*(LEVEL_NAMES[level] for level in present), "forbidden band"]
    axes.legend(handles, names, ncols=len(names), loc="lower right", bbox_to_anchor=(1, 1))
    where = "computed here" if found.provenance.estimated else "as logged"
    axes.set_title(f"speed, and the warning ({where}) below it", loc="left")


def _draw_force(axes: Axes, found: Analysis, mesh: str, colour: str) -> None:
    force = found.force
    mean = force.mean(f"{mesh}/mean")
    known = np.isfinite(mean)
    axes.set_ylabel(f"force of {mesh}, N")
    if not known.any():
        axes.text(0.5, 0.5, "no mesh force is known", transform=axes.transAxes, ha="center", color="#7F7F7F")
        return
    low, high = force.least(f"{mesh}/min")[known], force.most(f"{mesh}/max")[known]
    axes.fill_between(force.time[known], low, high, color=colour, alpha=0.25, linewidth=0)
    axes.plot(force.time[known], mean[known], color=colour, linewidth=0.9)
