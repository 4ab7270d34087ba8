"""How long the drive stayed in which band, and the mesh forces there."""

from typing import Any

import numpy as np

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.logs.analysis.bands import BandStay
from seat_gear_dynamics.views.colours import BAND, MESH_COLOURS
from seat_gear_dynamics.views.figures.style import in_style, new_figure

_CLEAR = "#009E73"


@in_style
def band_stays_figure(found: Analysis) -> Any:
    """Return the figure: time in each stretch of speed, and mean (bar), rms (tick) and extremes (line) of forces."""
    names = [stretch_name(stay) for stay in found.bands]
    figure, axes = new_figure(1, 2, width=10.5, height=1.4 + 0.45 * len(names), sharey=True)
    place = np.arange(len(names), dtype=float)
    colours = [BAND if stay.stretch.forbidden else _CLEAR for stay in found.bands]
    bars = axes[0].barh(place, [stay.seconds for stay in found.bands], color=colours)
    axes[0].bar_label(bars, [f" {stay.seconds:.1f} s" for stay in found.bands], fontsize=8)
    axes[0].margins(x=0.18)
    axes[0].set_yticks(place, names)
    axes[0].set(xlabel="time, s", title="time in each stretch of |speed|")
    for offset, mesh, colour in zip((-0.18, 0.18), ("s1_s2", "s3_s4"), MESH_COLOURS, strict=True):
        forces = [stay.forces[mesh] for stay in found.bands]
        at = place + offset
        axes[1].hlines(at, [f.min for f in forces], [f.max for f in forces], color=colour, linewidth=1.0)
        axes[1].barh(at, [f.mean for f in forces], height=0.3, color=colour, label=mesh)
        axes[1].plot([f.rms for f in forces], at, "|", color="black", markersize=9, label="rms" if offset > 0 else None)
    axes[1].set(xlabel="mesh force, N", title="mean, rms, smallest to largest")
    axes[1].legend(loc="lower right", fontsize=8, frameon=True)
    axes[0].invert_yaxis()
    return figure


def stretch_name(stay: BandStay) -> str:
    """Return a stretch of speeds in words, r/min."""
    low, high = stay.stretch.low / RPM, stay.stretch.high / RPM
    if not np.isfinite(high):
        return f"above {low:.0f} r/min"
    return f"{low:.0f}-{high:.0f} r/min" + (" (forbidden)" if stay.stretch.forbidden else "")
