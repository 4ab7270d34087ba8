"""The regime map over speed and load, with its forbidden bands; and the probability of chaos where machines vary."""

from typing import Any

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.regime_map import NAMES, RegimeMap
from seat_gear_dynamics.views.figures.style import REGIME_COLOURS, chosen, in_style, legend_columns, new_figure

Array = NDArray[np.float64]
Axes = Any  # matplotlib ships no types for what is used here


@in_style
def regime_map_figure(found: RegimeMap, *, threshold: float = 0.5) -> Any:
    """Return the figure of a map: regimes, with the bands at each load marked.

    If machines were drawn, the probability of chaos stands below; from `threshold` of it on a band is forbidden.
    """
    rows = 2 if found.samples else 1
    figure, axes = new_figure(rows, 1, width=7.5, height=0.8 + 3.4 * rows, sharex=True, squeeze=False)
    draw_regimes(axes[0, 0], found)
    draw_bands(axes[0, 0], found, threshold)
    if found.samples:
        draw_probability(axes[1, 0], found)
        draw_bands(axes[1, 0], found, threshold)
    axes[-1, 0].set_xlabel("speed of s1, r/min")
    return figure


def plot_map(axes: Axes, found: RegimeMap, *, panel: str = "regimes", threshold: float = 0.5) -> None:
    """Draw one panel of a map, `regimes` or `chaos` (its probability), with the bands from `threshold` on.

    Raises ValueError for another panel.
    """
    chosen(panel, {"regimes": draw_regimes, "chaos": draw_probability})(axes, found)
    draw_bands(axes, found, threshold)
    axes.set_xlabel("speed of s1, r/min")


def draw_regimes(axes: Axes, found: RegimeMap) -> None:
    """Draw the regime of each node as a cell in the regime's colour; diverged nodes are crossed."""
    colours = ListedColormap([REGIME_COLOURS[name] for name in NAMES])
    norm = BoundaryNorm(np.arange(len(NAMES) + 1) - 0.5, len(NAMES))
    edges = cell_edges(found.speeds / RPM), cell_edges(found.loads)
    axes.pcolormesh(*edges, found.codes, cmap=colours, norm=norm, rasterized=True)
    rows, columns = np.nonzero(np.isnan(found.force_max))
    axes.plot(found.speeds[columns] / RPM, found.loads[rows], "x", color="black", markersize=3)
    present: list[str] = [name for code, name in enumerate(NAMES) if (found.codes == code).any()]
    handles = [axes.plot([], [], "s", color=REGIME_COLOURS[name], markersize=7)[0] for name in present]
    if len(rows):
        handles.append(axes.plot([], [], "x", color="black", markersize=4)[0])
        present.append("diverged")
    handles.append(axes.plot([], [], color="black", linewidth=3)[0])
    _finish(axes, handles, [*present, "forbidden band"])


def draw_probability(axes: Axes, found: RegimeMap) -> None:
    """Draw the probability of chaos at each node."""
    edges = cell_edges(found.speeds / RPM), cell_edges(found.loads)
    mesh = axes.pcolormesh(*edges, found.chaos, cmap="cividis", vmin=0, vmax=1, rasterized=True)
    machines = f"{found.samples} machines" if found.samples else "one machine: 0, ½ or 1"
    axes.figure.colorbar(mesh, ax=axes, label=f"probability of chaos, {machines}")
    _finish(axes, [], [])


def draw_bands(axes: Axes, found: RegimeMap, threshold: float) -> None:
    """Draw the forbidden bands at each load as a bar, with thin ends as far as their edges may be off."""
    for load in found.loads.tolist():
        for band in found.bands(load, threshold):
            low, high = band.low / RPM, band.high / RPM
            off = band.low_error / RPM, band.high_error / RPM
            # White beneath black is seen on every colour.
            for colour, extra in (("white", 1.6), ("black", 0.0)):
                axes.plot([low - off[0], high + off[1]], [load, load], color=colour, linewidth=0.8 + extra)
                axes.plot([low, high], [load, load], color=colour, linewidth=2.6 + extra, solid_capstyle="butt")
    first, last = cell_edges(found.speeds / RPM)[[0, -1]]
    axes.set_xlim(first, last)


def _finish(axes: Axes, handles: list[Any], labels: list[str]) -> None:
    axes.set_ylabel("load torque T4, N·m")
    axes.grid(visible=False)
    if handles:
        axes.legend(
            handles,
            labels,
            ncols=legend_columns(axes.figure),
            handlelength=1.2,
            columnspacing=1.2,
            handletextpad=0.3,
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            frameon=False,
        )


def cell_edges(nodes: Array) -> Array:
    """Return the edges of cells around `nodes` (n,), shape (n + 1,): halfway between neighbours, ±5 % of a lone one."""
    if len(nodes) == 1:
        half = 0.05 * abs(float(nodes[0])) or 1.0
        return np.array([nodes[0] - half, nodes[0] + half])
    inner = (nodes[1:] + nodes[:-1]) / 2
    return np.concatenate([[2 * nodes[0] - inner[0]], inner, [2 * nodes[-1] - inner[-1]]])
