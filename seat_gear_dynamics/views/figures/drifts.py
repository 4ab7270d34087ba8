"""How far each parameter of a train may drift before a claim that is met is lost."""

import numpy as np

from seat_gear_dynamics.studies.calibration.sensitivity import Drifts
from seat_gear_dynamics.views.figures.style import LINE_COLOURS, Axes


def plot_drifts(axes: Axes, found: Drifts) -> None:
    """Draw a bar for each parameter from its lowest to its highest harmless drift; the claims lost next beside it.

    Phases drift in rad, which is drawn on the same scale: 1 % stands for 0.01 rad.
    """
    place = np.arange(len(found))
    axes.barh(place, [100 * each.up for each in found], color=LINE_COLOURS[0], height=0.6)
    axes.barh(place, [-100 * each.down for each in found], color=LINE_COLOURS[1], height=0.6)
    for row, each in enumerate(found):
        for x, lost, side in ((-100 * each.down, each.lost_down, "right"), (100 * each.up, each.lost_up, "left")):
            text = " ".join(lost)
            axes.annotate(
                text,
                (x, row),
                (4 if side == "left" else -4, 0),
                textcoords="offset points",
                ha=side,
                va="center",
                fontsize=7,
            )
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.margins(x=0.25)
    axes.set_yticks(place, [each.name for each in found])
    axes.invert_yaxis()
    axes.set(xlabel="harmless drift, % (phases: 0.01 rad)", ylabel="parameter")
