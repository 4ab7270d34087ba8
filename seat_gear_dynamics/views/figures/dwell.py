"""One dwell: phase portrait and Poincaré section, recorded points over the model's motion at the same drive."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.logs.analysis.dwells import Dwell
from seat_gear_dynamics.views.figures.style import LINE_COLOURS, Axes, in_style, new_figure

Array = NDArray[np.float64]
_RECORDED, _MODEL = LINE_COLOURS[1], LINE_COLOURS[0]


@in_style
def dwell_figure(found: Analysis, dwell: Dwell) -> Any:
    """Return the figure of s1_s2 in a dwell.

    Recorded states are few (as the monitor publishes them) and recorded section points one a mesh period; the line and
    the circles are the model's at the dwell's mean drive, without its noise.
    """
    figure, axes = new_figure(1, 2, width=10.5, height=4.0)
    portrait, section = axes
    train, state = found.train, found.dimensionless(dwell.state)
    motion = next((each for each in found.motions if each.dwell is dwell), None)
    if motion is not None:
        portrait.plot(*motion.portrait.T, color=_MODEL, linewidth=0.6, label=f"model: {motion.regime.label}")
        # Above the recorded points: a periodic motion is one or two circles, which a cloud would hide.
        section.plot(
            *motion.section.T, "o", color=_MODEL, markersize=5, fillstyle="none", markeredgewidth=0.7, zorder=3
        )
    portrait.plot(*state.T, ".", color=_RECORDED, markersize=3.5, markeredgewidth=0, label="recorded")
    section.plot(*dwell.section.T, ".", color=_RECORDED, markersize=3, markeredgewidth=0)
    half = train.meshes[0].backlash / 2 / train.model.displacement_scale
    for edge in (-half, half):
        portrait.axvline(edge, color="#7F7F7F", linewidth=0.8, linestyle="--")
    portrait.set(xlabel="δ / b_c of s1_s2", ylabel="dδ/dτ / b_c", title="phase portrait")
    section.set(xlabel="δ / b_c of s1_s2 at mesh phase 0", ylabel="dδ/dτ / b_c", title="Poincaré section")
    _give_room(section, np.concatenate([dwell.section, *([motion.section] if motion else [])]), portrait)
    portrait.legend(loc="upper left", fontsize=8, frameon=True)
    figure.suptitle(dwell_title(dwell), x=0.99, ha="right", fontsize=9)
    return figure


def dwell_title(dwell: Dwell) -> str:
    """Return a dwell in words."""
    way = {1: "reached from below", -1: "reached from above", 0: "reached unseen"}[dwell.direction]
    drive = f"{dwell.speed / RPM:.0f} r/min, {dwell.load:.0f} N·m"
    return f"{drive}, from {dwell.begin:.1f} s for {dwell.seconds:.1f} s, {way}"


def _give_room(axes: Axes, points: Array, portrait: Axes) -> None:
    """Keep a single point from filling its axes: show at least a twentieth of the portrait's extent."""
    if not len(points):
        axes.text(0.5, 0.5, "no section point", transform=axes.transAxes, ha="center", color="#7F7F7F")
        return
    limits = (portrait.get_xlim(), portrait.get_ylim())
    for k, setter in enumerate((axes.set_xlim, axes.set_ylim)):
        low, high = float(points[:, k].min()), float(points[:, k].max())
        margin = max(0.08 * (high - low), (0.05 * (limits[k][1] - limits[k][0]) - (high - low)) / 2)
        setter(low - margin, high + margin)
