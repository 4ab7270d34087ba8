"""The basins of attraction over the plane of initial states, with the motions that the starts settle on."""

from typing import Any

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from numpy.typing import NDArray

from seat_gear_dynamics.regimes.attractors import LOST, Attractor
from seat_gear_dynamics.regimes.basins import Basins
from seat_gear_dynamics.views.figures.regime_map import cell_edges
from seat_gear_dynamics.views.figures.style import in_style, new_figure

Array = NDArray[np.float64]
Axes = Any  # matplotlib ships no types for what is used here

_COLOURS = ("#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#F0E442", "#0072B2", "#D55E00")
"""Okabe & Ito, light ones first, so that the black points of the motions show on them."""
_LOST_COLOUR = "#FFFFFF"
_MARKERS = "os^Dvph"


@in_style
def basins_figure(found: Basins) -> Any:
    """Return the figure of basins: each start in the colour of the motion it settles on, and the motions' sections."""
    figure, axes = new_figure(1, 1, width=7.0, height=5.2)
    draw_basins(axes, found)
    return figure


def draw_basins(axes: Axes, found: Basins) -> None:
    """Draw the plane, the section points of each motion as far as they lie in it, and the shares as a legend.

    Beyond seven motions colours repeat; starts that diverged are white.
    """
    count = len(found.attractors)
    shown = [_LOST_COLOUR, *(_COLOURS[index % len(_COLOURS)] for index in range(count))]
    norm = BoundaryNorm(np.arange(LOST, count + 1) - 0.5, count + 1)
    edges = cell_edges(found.deflections), cell_edges(found.rates)
    axes.pcolormesh(*edges, found.labels, cmap=ListedColormap(shown), norm=norm, rasterized=True)
    handles, names = [], []
    for index, each in enumerate(found.attractors):
        marker = _MARKERS[index % len(_MARKERS)]
        axes.plot(*each.section.T, marker, color="black", markerfacecolor=shown[index + 1], markersize=4, mew=0.7)
        key = axes.plot([], [], marker, color="black", markerfacecolor=shown[index + 1], markersize=8, mew=0.7)
        handles.append(key[0])
        names.append(f"{_words(each)}: {_share(found, index)}")
    if (found.labels == LOST).any():
        handles.append(axes.plot([], [], "s", color="black", markerfacecolor=_LOST_COLOUR, markersize=8)[0])
        names.append(f"diverged: {_share(found, LOST)}")
    axes.set_xlim(*edges[0][[0, -1]])
    axes.set_ylim(*edges[1][[0, -1]])
    axes.set_xlabel("initial δ / b_c of s1_s2")
    axes.set_ylabel("initial rate of δ / b_c, 1/τ")
    axes.grid(visible=False)
    # To the left of the axes too, where a narrow figure has room for the words.
    place = {"loc": "lower left", "bbox_to_anchor": (-0.15, 1.0), "alignment": "left", "handlelength": 1.0}
    axes.legend(handles, names, title="motion and share of the plane", **place)


def _words(each: Attractor) -> str:
    regime = each.regime
    kind = regime.name if regime.period is None else f"period {regime.period}"
    return f"{kind}, contact lost {each.force.contact_loss:.0%} of the time"


def _share(found: Basins, label: int) -> str:
    share = found.share(label)
    return f"{share.value:.1%} ± {share.error:.1%}"
