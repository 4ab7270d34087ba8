"""A model fitted to a measured bench: every dwell before and after, the residuals, and what cannot be told apart."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.studies.identification.identify import Fitted
from seat_gear_dynamics.views.figures.style import LINE_COLOURS, Axes, chosen, in_style, new_figure

Array = NDArray[np.float64]
_MEASURED, _BEFORE, _AFTER = LINE_COLOURS[6], LINE_COLOURS[4], LINE_COLOURS[0]
_LEFT_OUT = "#7F7F7F"
_NAME = 0.3  # inches that the name of a dwell takes where it stands upright


@in_style
def identification_figure(fitted: Fitted) -> Any:
    """Return the figure: mean with its quantiles and spread per dwell, residuals, and the correlation matrix.

    Dwells stand in order of load and then speed. Bars reach from the 5 % to the 95 % quantile. Residuals are in per
    cent of the dwell's largest measured observable, all observables of a dwell at one place; dwells that the fit left
    out have grey names.
    """
    figure, axes = new_figure(2, 2, width=10.5, height=7.0)
    for place, panel in zip(axes.flat, _PANELS, strict=True):
        plot_identification(place, fitted, panel=panel)
    return figure


def plot_identification(axes: Axes, found: Fitted, *, panel: str = "ranges") -> None:
    """Draw one panel: `ranges`, `spreads`, `residuals` or `correlation`; raises ValueError for another one."""
    chosen(panel, _PANELS)(axes, found)


def _quantity(fitted: Fitted) -> str:
    return "mesh force of s1_s2" if fitted.sensor.kind == "force" else f"acceleration of {fitted.sensor.gear}"


def _parts(fitted: Fitted, values: Array) -> list[Array]:
    return np.split(values, np.cumsum(fitted.drives.sizes)[:-1])


def _sources(fitted: Fitted) -> list[tuple[str, str, list[Array], float]]:
    """Return label, colour, observables of each dwell and place beside the dwell."""
    measured = [o.value for o in fitted.observed]
    return [
        ("model before", _BEFORE, _parts(fitted, fitted.before.value), -0.25),
        ("measured", _MEASURED, measured, 0.0),
        ("model after", _AFTER, _parts(fitted, fitted.after.value), 0.25),
    ]


def _order(fitted: Fitted) -> NDArray[np.intp]:
    return np.lexsort((np.abs(fitted.drives.speed), fitted.drives.load))


def _ranges(axes: Axes, fitted: Fitted) -> None:
    order = _order(fitted)
    place = np.arange(len(order))
    for label, colour, parts, beside in _sources(fitted):
        mean, low, high = (np.array([parts[d][k] for d in order]) for k in (0, 2, 3))
        axes.vlines(place + beside, low, high, color=colour, linewidth=2.2)
        axes.plot(place + beside, mean, "o", color=colour, markersize=3.5, label=label)
    axes.set(ylabel=f"{_quantity(fitted)}, {fitted.sensor.unit}", title="mean and 5 % to 95 % quantiles")
    _finish(axes, fitted, order)


def _spreads(axes: Axes, fitted: Fitted) -> None:
    order = _order(fitted)
    place = np.arange(len(order))
    for (label, colour, parts, _), marker in zip(_sources(fitted), ("v", "o", "x"), strict=True):
        axes.plot(place, [parts[d][1] for d in order], marker, color=colour, markersize=5, label=label)
    axes.set(ylabel=f"standard deviation, {fitted.sensor.unit}", title="spread", ylim=(0, None))
    _finish(axes, fitted, order)


def _residuals(axes: Axes, fitted: Fitted) -> None:
    order = _order(fitted)
    for label, colour, parts, beside in _sources(fitted):
        if label == "measured":
            continue
        place: list[float] = []
        apart: list[float] = []
        for at, d in enumerate(order):
            value = fitted.observed[d].value
            place += [at + beside * 0.6] * len(value)
            apart += (100 * (parts[d] - value) / np.abs(value).max()).tolist()
        axes.plot(place, apart, ".", color=colour, markersize=5, label=label)
    axes.axhline(0, color=_MEASURED, linewidth=0.8)
    axes.set_yscale("symlog", linthresh=1.0)
    axes.margins(y=0.1)
    axes.set(ylabel="model minus measured, %\nof the largest of the dwell", title="residuals of all observables")
    _finish(axes, fitted, order)


def _correlation(axes: Axes, fitted: Fitted) -> None:
    names = [each.parameter.name.replace("_", "\n") for each in fitted.estimates]
    matrix = fitted.confidence.correlation
    drawn = axes.imshow(matrix, cmap="PuOr", vmin=-1, vmax=1)
    axes.grid(visible=False)
    axes.set_xticks(range(len(names)), names)
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel="parameter", ylabel="parameter")
    for i, j in np.ndindex(matrix.shape):
        text = f"{matrix[i, j]:.2f}" if np.isfinite(matrix[i, j]) else "none"
        axes.text(j, i, text, ha="center", va="center", color="white" if abs(matrix[i, j]) > 0.6 else "black")
    axes.set_title("correlation of the estimates")
    axes.figure.colorbar(drawn, ax=axes, shrink=0.8, label="correlation")


def _finish(axes: Axes, fitted: Fitted, order: NDArray[np.intp]) -> None:
    """Name the dwells and the colours."""
    drives = fitted.drives
    upright = len(order) * _NAME <= axes.get_position().width * axes.figure.get_size_inches()[0]
    names = [f"{drives.speed[d] / RPM:.0f}{chr(10) if upright else ' / '}{drives.load[d]:.0f}" for d in order]
    axes.set_xticks(range(len(order)), names, fontsize=7, rotation=0 if upright else 90)
    for at, d in enumerate(order):
        if fitted.left_out[d]:
            axes.get_xticklabels()[at].set_color(_LEFT_OUT)
    grey = " (grey: left out)" if any(fitted.left_out) else ""
    axes.set_xlabel(f"dwell: speed of s1 in r/min / load, N·m{grey}")
    axes.set_title(axes.get_title(), pad=20)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, borderaxespad=0.2, columnspacing=1.2)


_PANELS: dict[str, Callable[[Axes, Fitted], None]] = {
    "ranges": _ranges,
    "spreads": _spreads,
    "residuals": _residuals,
    "correlation": _correlation,
}
