"""The response curve: amplitude, contact loss and largest mesh force over a parameter, stable and unstable."""

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np

from seat_gear_dynamics.studies.harmonic_balance import Agreement, Branch, ResponseCurve
from seat_gear_dynamics.views.figures.style import (
    LINE_COLOURS,
    Axes,
    chosen,
    in_style,
    is_narrow,
    legend_columns,
    new_figure,
)

PARAMETER_LABELS = {
    "frequency": ("mesh frequency Ω of s1_s2, dimensionless", 1.0),
    "load": ("load torque T4, N·m", 1.0),
    "damping_ratio": ("mesh damping ratio ξ, dimensionless", 1.0),
    "backlash": ("backlash b, µm", 1e6),
}
"""Of each parameter: axis label with its unit, and what SI values are multiplied by to be in it."""
_PANELS = {"rms": "rms of δ, µm", "contact_loss": "out of contact, %", "force_max": "largest mesh force, kN"}

MARKERS = {"fold": "o", "branch point": "X", "period doubling": "s", "Neimark-Sacker": "^"}


@in_style
def response_curve_figure(curve: ResponseCurve, agreements: Sequence[Agreement] = ()) -> tuple[Any, Any]:
    """Return (figure, three axes): rms of δ about its mean in µm, share out of contact in %, largest force in kN.

    Stable motions are drawn solid, unstable ones dashed, each period in its colour; bifurcations are marked. Where
    integrated motions are given, `agreements` of `harmonic_balance.compare`, those that are periodic and lie on a
    stable motion of the curve are marked at it: crosses going up, pluses going down.
    """
    figure, axes = new_figure(3, 1, height=7.0, sharex=True)
    label, unit = PARAMETER_LABELS[curve.parameter]
    for branch in curve.branches:
        _draw_branch(axes, branch, unit)
    _draw_bifurcations(axes[0], curve, unit)
    _draw_agreements(axes[0], curve, agreements, unit)
    load = f" at {curve.system.operating_point.load:g} N·m" if curve.parameter != "load" else ""
    narrow = is_narrow(figure)
    title = f"Periodic motions of s1_s2{load} by harmonic balance"
    axes[0].set_title(fill(title, 40) if narrow else title)
    for ax, text in zip(axes, _PANELS.values(), strict=True):
        ax.set_ylabel(text)
        ax.set_ylim(bottom=0)
    axes[-1].set_xlabel(label)
    axes[-1].set_xlim(curve.low * unit, curve.high * unit)
    _legend(axes[0], above=narrow)
    return figure, axes


def plot_curve(axes: Axes, curve: ResponseCurve, *, panel: str = "rms") -> None:
    """Draw one panel of a curve: `rms` of δ with its bifurcations, `contact_loss` or `force_max`.

    Raises ValueError for another panel.
    """
    row = chosen(panel, {name: n for n, name in enumerate(_PANELS)})
    label, unit = PARAMETER_LABELS[curve.parameter]
    for branch in curve.branches:
        _draw_branch([axes if n == row else None for n in range(len(_PANELS))], branch, unit)
    if panel == "rms":
        _draw_bifurcations(axes, curve, unit)
    axes.set(xlabel=label, ylabel=_PANELS[panel], xlim=(curve.low * unit, curve.high * unit))
    axes.set_ylim(bottom=0)
    place = {"loc": "lower left", "bbox_to_anchor": (-0.1, 1.0), "ncols": legend_columns(axes.figure, most=4)}
    axes.legend(*_once(axes), **place)


def _draw_branch(axes: Sequence[Axes | None], branch: Branch, unit: float) -> None:
    """Draw one branch on all axes that there are; each line is drawn twice, with gaps where the other style holds."""
    pair, colour = branch.balance.pair, _colour(branch.subharmonics)
    quantities = (
        [m.rms * pair.length_unit * 1e6 for m in branch.motions],
        [m.contact_loss * 100 for m in branch.motions],
        [float(m.force.max()) * pair.force_unit * 1e-3 for m in branch.motions],
    )
    x, stable = branch.parameters * unit, branch.stable
    pieces = stable[1:] & stable[:-1]
    name = f"period {branch.subharmonics}"
    for ax, values in zip(axes, quantities, strict=True):
        if ax is None:
            continue
        y = np.array(values)
        for wanted, style, text in ((True, "-", name), (False, "--", f"{name}, unstable")):
            xs, ys = _pieces(x, y, pieces == wanted)
            if len(xs):
                ax.plot(xs, ys, style, color=colour, label=text, linewidth=1.3 if wanted else 0.9)


def _pieces(x: Any, y: Any, wanted: Any) -> tuple[Any, Any]:
    """Return the points of the wanted pieces between neighbours, (n - 1,), as one line with gaps between runs."""
    before, after = np.append(False, wanted), np.append(wanted, False)
    kept, gap = before | after, np.flatnonzero(before & ~after) + 1
    kept_before = np.cumsum(kept)[gap - 1]
    return np.insert(x[kept], kept_before, np.nan), np.insert(y[kept], kept_before, np.nan)


def _draw_bifurcations(ax: Any, curve: ResponseCurve, unit: float) -> None:
    length = curve.branches[0].balance.pair.length_unit * 1e6
    for event in curve.bifurcations:
        ax.plot(
            event.parameter * unit,
            event.motion.rms * length,
            MARKERS[event.kind],
            color="black",
            markerfacecolor="white",
            markersize=5,
            linestyle="none",
            label=event.kind,
            zorder=3,
        )


def _draw_agreements(ax: Any, curve: ResponseCurve, agreements: Sequence[Agreement], unit: float) -> None:
    length = curve.branches[0].balance.pair.length_unit * 1e6
    for item in agreements:
        if item.comparable and item.motion is not None:
            ax.plot(
                item.value * unit,
                item.motion.rms * length,
                "x" if item.direction == "up" else "+",
                color="black",
                markersize=6,
                linestyle="none",
                label=f"integrated, {item.direction}",
                zorder=4,
            )


def _legend(ax: Any, *, above: bool) -> None:
    """Put each name once beside the axes, or above them all where there is no room beside."""
    if above:
        ax.figure.legend(*_once(ax), loc="outside upper center", ncols=2)
    else:
        ax.legend(*_once(ax), loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8)


def _once(ax: Any) -> tuple[list[Any], list[str]]:
    handles, labels = ax.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    return list(once.values()), list(once)


def _colour(period: int) -> str:
    return LINE_COLOURS[(period - 1) % len(LINE_COLOURS)]
