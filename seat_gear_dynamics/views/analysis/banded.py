"""The figures that show forbidden bands: published ones as the figures draw them, a map's as they follow the load."""

from dataclasses import replace
from typing import Any

import matplotlib as mpl
import numpy as np

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.logs.analysis.overview import band_boxes, band_plane
from seat_gear_dynamics.views.analysis.words import stretch_words
from seat_gear_dynamics.views.figures.band_stays import band_stays_figure
from seat_gear_dynamics.views.figures.histories import histories_figure
from seat_gear_dynamics.views.figures.recorded_bifurcation import recorded_bifurcation_figure
from seat_gear_dynamics.views.figures.trajectory import trajectory_figure
from seat_gear_dynamics.views.report import draw_boxes

_EDGE = "#1b1f24"  # a band lies on the map's own colours
_UNKNOWN = "#7f7f7f"


def histories(found: Analysis) -> Any:
    """Return the figure of the time histories; a map's bands are those at the load of each moment."""
    if not found.judged_by.follows_load:
        return histories_figure(found)
    figure = histories_figure(_with_bands(found, ()))
    axes = figure.axes[0]
    limits = axes.get_ylim()
    draw_boxes(axes, band_boxes(found), backward=bool((found.drive.least("speed") < 0).any()))
    axes.set(xlim=(0, max(found.duration, 1e-3)), ylim=limits)
    return figure


def trajectory(found: Analysis) -> Any:
    """Return the figure of the plane of speed and load; a map's bands are hatched, with their edge."""
    if not found.judged_by.follows_load:
        return _dark_hatch(trajectory_figure(found)) if found.map is not None else trajectory_figure(found)
    figure = trajectory_figure(_with_bands(found, ()))
    axes = figure.axes[0]
    limits = axes.get_xlim(), axes.get_ylim()
    speeds, loads, forbidden = band_plane(found)
    if forbidden.any():
        place = (speeds / RPM, loads, forbidden.astype(float))
        with mpl.rc_context({"hatch.color": _EDGE, "hatch.linewidth": 0.5}):
            axes.contourf(*place, levels=[0.5, 1.5], colors="none", hatches=["//"])
        axes.contour(*place, levels=[0.5], colors=_EDGE, linewidths=1.2)
    axes.set(xlim=limits[0], ylim=limits[1])
    return _dark_hatch(figure)


def band_stays(found: Analysis) -> Any:
    """Return the figure of time and forces by stretch; a map's stretches are named with their load."""
    figure = band_stays_figure(found)
    if found.judged_by.follows_load:
        axes = figure.axes[0]
        axes.set_yticks(range(len(found.bands)), [stretch_words(stay) for stay in found.bands])
        for stay, bar in zip(found.bands, axes.patches, strict=True):
            if stay.stretch.outside:
                bar.set_color(_UNKNOWN)
    return figure


def bifurcation(found: Analysis) -> Any:
    """Return the bifurcation diagram; a map's bands are those at the load at which the drive spent most time."""
    if not found.judged_by.follows_load:
        return recorded_bifurcation_figure(found)
    bands = found.judged_by.at(found.load) if np.isfinite(found.load) else ()
    return recorded_bifurcation_figure(_with_bands(found, bands))


def _with_bands(found: Analysis, bands: tuple[Any, ...]) -> Analysis:
    """Return the analysis with other bands of its train, which are those that the figures draw."""
    return replace(found, train=replace(found.train, bands=bands))


def _dark_hatch(figure: Any) -> Any:
    """Draw the edges of bands, and their place in the legend, in a colour that is none of the map's."""
    axes = figure.axes[0]
    for patch in (*axes.patches, axes.get_legend().legend_handles[-1]):
        patch.set_edgecolor(_EDGE)
    return figure
