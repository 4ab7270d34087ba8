"""The one style of every figure: size, type, colours safe for colour-blind readers, and saving to a file."""

from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

Axes = Any  # matplotlib ships no types for what is used here

REGIME_COLOURS = {
    "periodic": "#0072B2",
    "quasi-periodic": "#E69F00",
    "chaotic": "#D55E00",
    "undecided": "#7F7F7F",
}
"""Okabe & Ito; told apart in print without colour by their lightness."""
LINE_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

_STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E5E5E5",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
}


def new_figure(rows: int = 1, columns: int = 1, *, width: float = 7.0, height: float = 4.2, **options: Any) -> Any:
    """Return (figure, axes) in the style; `options` go to `Figure.subplots`; sizes in inches.

    No pyplot: nothing global is touched, so figures may be made in any thread and without a screen.
    """
    with rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        return figure, figure.subplots(rows, columns, **options)


def save(figure: Any, path: Path) -> None:
    """Write the figure to `path`, its format by the ending (PNG, SVG, PDF); raises OSError where it cannot be."""
    with rc_context(_STYLE):
        figure.savefig(path, dpi=150)
