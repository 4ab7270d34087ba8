"""The one style of every figure: size, type, colours safe for colour-blind readers, and saving to a file."""

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from threading import RLock
from typing import Any, Literal, ParamSpec, TypeVar

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

Axes = Any  # matplotlib ships no types for what is used here
Given = ParamSpec("Given")
Made = TypeVar("Made")
Name = Literal["screen", "print"]

REGIME_COLOURS = {
    "periodic": "#0072B2",
    "quasi-periodic": "#E69F00",
    "chaotic": "#D55E00",
    "undecided": "#7F7F7F",
}
"""Okabe & Ito; told apart in print without colour by their lightness."""
LINE_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

SMALLEST_TYPE = 7.0
"""pt, the smallest letters of any figure in print."""
COLUMN, PAGE = 3.5, 7.2
"""Widths of a column and of both columns of a journal's page, inches."""

_COMMON: Any = {
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E5E5E5",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    # Ids in an SVG file come from this instead of from chance.
    "svg.hashsalt": "seat_gear_dynamics",
    # Letters stay letters that can be searched for.
    "pdf.fonttype": 42,
}


@dataclass(frozen=True)
class Preset:
    """How figures look for one use."""

    settings: dict[str, Any]
    """matplotlib's own, beside those that every figure has."""
    widest: float
    """Inches; wider figures are made smaller."""
    dpi: int
    """Of PNG files, and of what is drawn as pixels in others."""


PRESETS: dict[Name, Preset] = {
    "screen": Preset({"font.size": 9, "axes.titlesize": 10, "legend.fontsize": 9}, 20.0, 150),
    "print": Preset(
        {
            "font.size": 7.5,
            "axes.titlesize": 8,
            "axes.labelsize": 7.5,
            "xtick.labelsize": SMALLEST_TYPE,
            "ytick.labelsize": SMALLEST_TYPE,
            "legend.fontsize": SMALLEST_TYPE,
            "figure.titlesize": 8,
            "lines.linewidth": 1.0,
            "axes.linewidth": 0.6,
        },
        PAGE,
        600,
    ),
}
_PRESET: ContextVar[Name] = ContextVar("preset", default="screen")
# matplotlib's settings belong to the whole process: figures of two threads take turns.
_TURN = RLock()


@contextmanager
def preset(name: Name) -> Generator[None, None, None]:
    """Make the figures within the `with` block for `screen` (the default) or `print`.

    For print one panel is a column wide and a row of panels the page, a little higher for its width, with letters
    of 7 pt and more. Raises ValueError for another name.
    """
    if name not in PRESETS:
        raise ValueError(f"There is no preset {name!r}; expected one of {', '.join(PRESETS)}.")
    before = _PRESET.set(name)
    try:
        yield
    finally:
        _PRESET.reset(before)


def in_style(draw: Callable[Given, Made]) -> Callable[Given, Made]:
    """Return `draw` in the style: what it makes has its type sizes and lines, and the caller's settings come back."""

    @wraps(draw)
    def drawn(*given: Given.args, **named: Given.kwargs) -> Made:
        with _TURN, rc_context(_COMMON | PRESETS[_PRESET.get()].settings):
            return draw(*given, **named)

    return drawn


def legend_columns(figure: Any, *, most: int = 6) -> int:
    """Return how many entries of one word fit beside each other above the axes of `figure`."""
    return max(2, min(most, int(figure.get_size_inches()[0] / 1.2)))


def is_narrow(figure: Any) -> bool:
    """Return whether `figure` is about a column wide, where long titles are wrapped and legends stand above."""
    return bool(figure.get_size_inches()[0] < 1.4 * COLUMN)


def chosen(panel: str, panels: Mapping[str, Made]) -> Made:
    """Return what `panels` has under the name `panel`; raises ValueError, with the names, where it has nothing."""
    if panel not in panels:
        raise ValueError(f"There is no panel {panel!r} to draw; expected one of {', '.join(panels) or 'none at all'}.")
    return panels[panel]


@in_style
def new_figure(rows: int = 1, columns: int = 1, *, width: float = 7.0, height: float = 4.2, **options: Any) -> Any:
    """Return (figure, axes) in the style; `options` go to `Figure.subplots`; sizes in inches, as on the screen.

    No pyplot: there is no window and no list of open figures. Figures may be made in any thread; they take turns.
    """
    size = _size(width, height, rows, columns)
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    figure.seat_gear_dpi = PRESETS[_PRESET.get()].dpi  # type: ignore[attr-defined]  # `save` may be called elsewhere
    return figure, figure.subplots(rows, columns, **options)


def _size(width: float, height: float, rows: int, columns: int) -> tuple[float, float]:
    name = _PRESET.get()
    wanted = COLUMN if name == "print" and columns == 1 else PRESETS[name].widest
    # Letters do not shrink with the paper, so that height goes down by less, the more of it they take.
    share = min(1.0, wanted / width)
    return width * share, height * share ** (0.7 if rows == 1 else 0.35)


@in_style
def save(figure: Any, path: Path) -> None:
    """Write the figure to `path`, its format by the ending (PNG, SVG, PDF); raises OSError where it cannot be.

    The same figure gives the same bytes: no file holds the time at which it was made.
    """
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(Path(path).suffix.lower())
    figure.savefig(path, dpi=getattr(figure, "seat_gear_dpi", PRESETS["screen"].dpi), metadata=undated)
