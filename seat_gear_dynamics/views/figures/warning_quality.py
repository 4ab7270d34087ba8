"""How good the warning is: ROC curves, notice before ramps, delay to ERROR."""

from collections.abc import Callable
from textwrap import fill
from typing import Any

import numpy as np

from seat_gear_dynamics.studies.warning_quality.assess import Assessment
from seat_gear_dynamics.studies.warning_quality.score import LONGEST_NOTICE, Roc
from seat_gear_dynamics.views.figures.style import LINE_COLOURS, Axes, chosen, in_style, is_narrow, new_figure

_NAMES = {
    "danger": "all evidence",
    "place": "place and course",
    "motion": "running model",
    "map": "map's probability",
    "ahead": "all, 0.5 s ahead",
}
_TITLES = ("danger by the bands and the model's own chaos", "chaos of machines within tolerances")
_REACH = 0.5  # s of notice that is asked for


@in_style
def warning_quality_figure(found: Assessment) -> Any:
    """Return the figure of an assessment: two ROCs above, notice and delay below."""
    figure, axes = new_figure(2, 2, width=9.0, height=7.2)
    draw_roc(axes[0, 0], found.rocs, _TITLES[0])
    draw_roc(axes[0, 1], found.machine_rocs, _TITLES[1])
    draw_notices(axes[1, 0], found)
    draw_delays(axes[1, 1], found)
    return figure


def plot_assessment(axes: Axes, found: Assessment, *, panel: str = "roc") -> None:
    """Draw one panel: `roc`, `machine_roc`, `notices` or `delays`; raises ValueError for another one."""
    draw: dict[str, Callable[[], None]] = {
        "roc": lambda: draw_roc(axes, found.rocs, _TITLES[0]),
        "machine_roc": lambda: draw_roc(axes, found.machine_rocs, _TITLES[1]),
        "notices": lambda: draw_notices(axes, found),
        "delays": lambda: draw_delays(axes, found),
    }
    chosen(panel, draw)()


def plot_roc(axes: Axes, found: Roc) -> None:
    """Draw one curve with its area."""
    draw_roc(axes, {"": found}, "")


def draw_roc(axes: Axes, curves: dict[str, Roc], title: str) -> None:
    """Draw the curves with their areas; where there is none, say so."""
    axes.set(xlabel="false positive rate", ylabel="true positive rate", xlim=(-0.01, 1), ylim=(0, 1.02))
    axes.set_title(fill(title, 36) if is_narrow(axes.figure) else title)
    if not curves:
        axes.text(0.5, 0.5, "the runs hold one class only", transform=axes.transAxes, ha="center")
        return
    for (name, roc), colour in zip(curves.items(), LINE_COLOURS, strict=False):
        label = f"{_NAMES[name]}, area {roc.area:.3f}" if name else f"area {roc.area:.3f}"
        axes.plot(roc.false_rate, roc.true_rate, color=colour, label=label, linewidth=2 if name == "danger" else 1.2)
    axes.plot([0, 1], [0, 1], color="#999999", linestyle=":", linewidth=0.8)
    axes.legend(loc="lower right", fontsize=8)


def draw_notices(axes: Axes, found: Assessment) -> None:
    """Draw a histogram of the notice before ramps into a band, by acceleration."""
    accelerations = sorted({of for of, _ in found.whole.notices})
    edges = np.linspace(0, LONGEST_NOTICE, 21)
    groups = [[notice for of, notice in found.whole.notices if of == each] for each in accelerations]
    colours = list(LINE_COLOURS[: len(groups)])  # a tuple of two is a colour and its opacity to matplotlib 3.8
    if groups:
        labels = [f"{each:g} r/min per s" for each in accelerations]
        axes.hist(groups, bins=edges, stacked=True, color=colours, label=labels)
        axes.legend(fontsize=8)
    axes.axvline(_REACH, color="black", linestyle="--", linewidth=0.8)
    axes.set(xlabel="notice before entry, s (longest counted: 2)", ylabel="ramps", title="notice before ramps")


def draw_delays(axes: Axes, found: Assessment) -> None:
    """Draw a histogram of the delay from a band's edge to ERROR."""
    delays = 1e3 * np.array(found.whole.delays)
    if len(delays):
        axes.hist(delays, bins=np.arange(-5, max(float(delays.max()), 100.0) + 15, 10), color=LINE_COLOURS[0])
    axes.set(xlabel="from the edge to ERROR, ms (0: it stood before)", ylabel="stays in a band", title="delay")
