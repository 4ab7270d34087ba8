"""One motion in the paper's form: time history, phase portrait and Poincaré section side by side (Figs 9-10, 12-14)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion import History, Response
from seat_gear_dynamics.regimes.simulate import Simulation
from seat_gear_dynamics.views.colours import MESH_COLOURS
from seat_gear_dynamics.views.figures.style import LINE_COLOURS, REGIME_COLOURS, Axes, chosen, in_style, new_figure

Array = NDArray[np.float64]

_EDGE: Any = {"color": "#7F7F7F", "linewidth": 0.8, "linestyle": "--"}
_DELTA, _RATE = "δ / b_c", "dδ/dτ / b_c"
_FEW = 64
"""Section points up to which each is drawn so large that it is seen alone."""


@in_style
def draw_motion(tau: Array, delta: Array, rate: Array, section: Array, *, title: str, half_backlash: float) -> Any:
    """Return the figure of one mesh's motion.

    `tau` (n,), `delta` and `rate` (n,) in units of b_c and of b_c per τ, `section` (m, 2) in the same units;
    `half_backlash` in b_c marks where teeth part and where they touch on the other flank, as far as the motion goes.
    """
    figure, axes = new_figure(1, 3, width=10.5, height=3.4)
    time, portrait, poincare = axes
    time.plot(tau, delta, color=LINE_COLOURS[0], linewidth=0.9)
    time.set(xlabel="dimensionless time τ", ylabel=_DELTA, title="time history")
    time.margins(x=0)
    portrait.plot(delta, rate, color=LINE_COLOURS[0], linewidth=0.6)
    portrait.set(xlabel=_DELTA, ylabel=_RATE, title="phase portrait")
    _mark_edges(time, portrait, delta, half_backlash)
    _draw_section(poincare, section, LINE_COLOURS[1])
    poincare.set(title="Poincaré section")
    _give_room(poincare, section, np.column_stack([delta, rate]))
    figure.suptitle(title)
    return figure


def plot_history(axes: Axes, found: History, *, panel: str = "time", mesh: int = 0) -> None:
    """Draw `time` (δ of a mesh over τ), `portrait` (phase portrait), `force` (over τ) or `section` (s1_s2 only).

    `mesh` is 0 for s1_s2, 1 for s3_s4. Raises ValueError for another panel, and for a section of s3_s4.
    """
    panels: dict[str, tuple[Array, Array, str, str]] = {
        "time": (found.tau, found.delta[:, mesh], "dimensionless time τ", _DELTA),
        "portrait": (found.delta[:, mesh], found.rate[:, mesh], _DELTA, _RATE),
        "force": (found.tau, found.force[:, mesh], "dimensionless time τ", "mesh force, N"),
    }
    if panel == "section" and mesh == 0:
        _draw_section(axes, found.section, LINE_COLOURS[1])
        return
    x, y, xlabel, ylabel = chosen(panel, panels)
    axes.plot(x, y, color=MESH_COLOURS[mesh], linewidth=0.9)
    axes.set(xlabel=xlabel, ylabel=ylabel)


def plot_section(axes: Axes, found: Response) -> None:
    """Draw the Poincaré section of s1_s2."""
    _draw_section(axes, found.section, LINE_COLOURS[1])


def plot_simulation(axes: Axes, found: Simulation) -> None:
    """Draw the Poincaré section of s1_s2 in the colour of its regime.

    A simulation keeps no steps: its time history, phase portrait and force are `found.history().plot(panel=…)`.
    """
    _draw_section(axes, found.response.section, REGIME_COLOURS[found.regime.name])
    axes.set_title(f"Ω {found.frequency:.4g}, {found.speed_rpm:.4g} r/min, {found.load:.4g} N·m: {found.regime.label}")


def _draw_section(axes: Axes, section: Array, colour: str) -> None:
    places = len(np.unique(section.round(3), axis=0))
    size = 7 if places <= _FEW else 3
    axes.plot(*section.T, ".", color=colour, markersize=size, markeredgewidth=0, rasterized=len(section) > 10**4)
    axes.set(xlabel=f"{_DELTA} at mesh phase 0", ylabel=_RATE)


def _mark_edges(time: Axes, portrait: Axes, delta: Array, half_backlash: float) -> None:
    """Mark the edges of the backlash, each only where the motion comes near, lest it be squeezed into a strip."""
    low, high = float(delta.min()), float(delta.max())
    near = 0.25 * (high - low)
    for edge in (-half_backlash, half_backlash):
        if low - near <= edge <= high + near:
            time.axhline(edge, **_EDGE)
            portrait.axvline(edge, **_EDGE)


def _give_room(axes: Axes, section: Array, portrait: Array) -> None:
    """Keep a single point from filling its axes: show at least a twentieth of the portrait's extent."""
    for k, setter in enumerate((axes.set_xlim, axes.set_ylim)):
        low, high = float(section[:, k].min()), float(section[:, k].max())
        least = 0.05 * float(np.ptp(portrait[:, k]))
        margin = max(0.08 * (high - low), (least - (high - low)) / 2)
        setter(low - margin, high + margin)
