"""The bifurcation diagram: section points coloured by regime, up and down apart, the exponent beneath."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from seat_gear_dynamics.regimes.sweep import UNITS, Row, Sweep, Way
from seat_gear_dynamics.views.figures.style import REGIME_COLOURS, chosen, in_style, legend_columns, new_figure

Axes = Any  # matplotlib ships no types for what is used here

_NAMES = {
    "frequency": "dimensionless mesh frequency Ω",
    "speed": "speed of s1",
    "speed_rpm": "speed of s1",
    "damping": "mesh damping ratio ξ",
    "backlash_um": "backlash",
    "load": "load torque T4",
}
_WAYS: dict[Way, str] = {
    "up": "up: each goes on from the one below",
    "down": "down: each goes on from the one above",
    "cold": "each from rest at static deflection",
}
_LINES: dict[Way, tuple[str, str]] = {"up": ("^", "#009E73"), "down": ("v", "#000000"), "cold": ("o", "#000000")}
"""Marker and colour, none of them a regime's."""
_APART = "#CC79A7"


@in_style
def bifurcation_figure(found: Sweep) -> Any:
    """Return the figure of a sweep: a panel of δ/b_c on the section for each direction, then the largest exponent.

    Shaded are values at which up and down end on different motions. Diverged values have no points.
    """
    ways = found.directions
    rows = len(ways) + 1
    figure, axes = new_figure(rows, 1, width=7.5, height=2.1 + 2.3 * len(ways), sharex=True)
    for panel, way in zip(axes[:-1], ways, strict=True):
        panel.sharey(axes[0])
        draw_section(panel, found.along(way))
        panel.set_title(_WAYS[way], loc="left")
    draw_exponent(axes[-1], found)
    for panel in axes:
        _shade(panel, found)
    axes[-1].set_xlabel(_value_label(found))
    _legend(figure, found)
    return figure


def plot_sweep(axes: Axes, found: Sweep, *, panel: str = "section") -> None:
    """Draw one panel of a sweep: `section` (points of all directions together, shaded where they differ) or `exponent`.

    Raises ValueError for another panel.
    """
    if chosen(panel, {"section": True, "exponent": False}):
        draw_section(axes, found.rows)
        names = [name for name in REGIME_COLOURS if any(row.regime.name == name for row in found.rows)]
        handles = [axes.plot([], [], "s", color=REGIME_COLOURS[name], markersize=6)[0] for name in names]
        axes.legend(handles, names, ncols=legend_columns(axes.figure), loc="lower right", bbox_to_anchor=(1.0, 1.0))
    else:
        draw_exponent(axes, found)
    _shade(axes, found)
    axes.set_xlabel(_value_label(found))


def _value_label(found: Sweep) -> str:
    unit = UNITS[found.over]
    return _NAMES[found.over] + ("" if unit == "1" else f", {unit}")


def draw_section(axes: Axes, rows: Sequence[Row]) -> None:
    """Draw the section points of `rows`, δ/b_c over the value, in the colours of their regimes."""
    for name, colour in REGIME_COLOURS.items():
        chosen = [row for row in rows if row.regime.name == name and len(row.section)]
        if not chosen:
            continue
        value = np.concatenate([np.full(len(row.section), row.value) for row in chosen])
        delta = np.concatenate([row.section[:, 0] for row in chosen])
        # A periodic motion has few points, an irregular one hundreds. As pixels also in a vector file: there are many.
        size = 4.0 if name == "periodic" else 2.0
        axes.plot(value, delta, ".", color=colour, markersize=size, markeredgewidth=0, rasterized=True)
    axes.set_ylabel("δ / b_c at mesh phase 0")


def draw_exponent(axes: Axes, found: Sweep) -> None:
    """Draw the largest exponent over the value, a line for each direction, with its standard error."""
    axes.axhline(0.0, color="black", linewidth=0.8)
    for way in found.directions:
        marker, colour = _LINES[way]
        rows = [row for row in found.along(way) if row.regime.lyapunov is not None]
        values, exponents = [row.value for row in rows], [row.regime.lyapunov for row in rows]
        errors = [row.regime.lyapunov_error for row in rows]
        axes.errorbar(
            values,
            exponents,
            errors,
            color=colour,
            marker=marker,
            markersize=2.5,
            linewidth=0.8,
            label=way,
        )
    axes.set_ylabel("largest exponent, 1/τ")
    if len(found.directions) > 1:
        axes.legend(ncols=2, loc="best", frameon=False)


def _shade(axes: Axes, found: Sweep) -> None:
    values = np.unique([row.value for row in found.rows])
    half = float(np.diff(values).min()) / 2 if len(values) > 1 else 0.0
    for value in found.coexisting():
        axes.axvspan(value - half, value + half, color=_APART, alpha=0.18, linewidth=0)


def _legend(figure: Any, found: Sweep) -> None:
    """Put the legend of regimes above all panels, where it hides no point."""
    present = {row.regime.name for row in found.rows}
    names: list[str] = [name for name in REGIME_COLOURS if name in present]
    axes = figure.axes[0]
    handles = [axes.plot([], [], "s", color=REGIME_COLOURS[name], markersize=6)[0] for name in names]
    if found.coexisting():
        handles.append(axes.fill_between([], [], color=_APART, alpha=0.35))
        names.append("up and down differ")
    figure.legend(handles, names, ncols=legend_columns(figure), loc="outside upper right", frameon=False)
