"""What a step costs against lanes, points and threads, with the machine's limit drawn in."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from seat_gear_dynamics.views.figures.style import LINE_COLOURS, Axes, in_style, new_figure

_MARKS = "osD^"


@dataclass(frozen=True)
class CostCurve:
    """The cost of one kernel or call over a quantity."""

    name: str
    values: Sequence[float]
    """Of the quantity, increasing, positive."""
    nanoseconds: Sequence[float]
    """For a Runge-Kutta step of one motion."""
    limit: Sequence[float]
    """The same where nothing but the arithmetic took time, at each value."""

    def __post_init__(self) -> None:
        lengths = {len(self.values), len(self.nanoseconds), len(self.limit)}
        if len(lengths) != 1 or not self.values:
            raise ValueError(
                f"The curve {self.name!r} has {len(self.values)} values, {len(self.nanoseconds)} costs and "
                f"{len(self.limit)} limits; expected the same number of each, at least one."
            )


@dataclass(frozen=True)
class CostPanel:
    """What the cost is drawn over, and its curves."""

    title: str
    quantity: str
    """With its unit, where it has one."""
    curves: Sequence[CostCurve]


@in_style
def cost_figure(panels: Sequence[CostPanel], *, title: str = "") -> Any:
    """Return the figure: a panel for each quantity, both axes logarithmic, the limit of each curve dashed.

    Lower is better; a curve on its dashed line leaves nothing to gain but fewer operations. Raises ValueError where
    there is no panel.
    """
    if not panels:
        raise ValueError("There is no panel to draw; give one at least.")
    figure, axes = new_figure(1, len(panels), width=3.3 * len(panels) + 0.6, height=3.6, sharey=True, squeeze=False)
    for axis, panel in zip(axes[0], panels, strict=True):
        _draw(axis, panel)
    axes[0, 0].set_ylabel("cost of a step of one motion, ns")
    if title:
        figure.suptitle(title, fontsize=9)
    return figure


def _draw(axis: Axes, panel: CostPanel) -> None:
    for n, curve in enumerate(panel.curves):
        colour = LINE_COLOURS[n % len(LINE_COLOURS)]
        mark = _MARKS[n % len(_MARKS)]
        axis.loglog(curve.values, curve.nanoseconds, marker=mark, markersize=4, color=colour, label=curve.name)
        axis.loglog(curve.values, curve.limit, linestyle="--", linewidth=1.0, color=colour)
    ticks = sorted({x for curve in panel.curves for x in curve.values})
    axis.set_xticks(ticks, [f"{x:g}" for x in ticks], fontsize=8)
    axis.minorticks_off()
    axis.set_xlabel(panel.quantity)
    axis.set_title(panel.title)
    axis.plot([], [], linestyle="--", linewidth=1.0, color="#555555", label="multiply-adds alone")
    axis.legend(fontsize=7)
