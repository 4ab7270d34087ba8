"""Warnings held against the bands: delays, leads, what was missed, and the level under each stated regime."""

from typing import Any

import numpy as np

from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.views.colours import LEVEL_COLOURS, LEVEL_NAMES
from seat_gear_dynamics.views.figures.style import REGIME_COLOURS, Axes, in_style, new_figure


@in_style
def detection_figure(found: Analysis) -> Any:
    """Return the figure: each stay in a band with its delay and lead, and seconds by regime and level."""
    figure, axes = new_figure(1, 2, width=10.5, height=3.6, width_ratios=(1.5, 1))
    _draw_episodes(axes[0], found)
    _draw_regimes(axes[1], found)
    return figure


def _draw_episodes(axes: Axes, found: Analysis) -> None:
    episodes = found.detection.episodes
    axes.set(xlabel="time since the log's start, s", ylabel="time to ERROR after entry, ms", title="stays in a band")
    axes.set_xlim(0, max(found.duration, 1e-3))
    if not episodes:
        axes.text(0.5, 0.5, "the drive was in no forbidden band", transform=axes.transAxes, ha="center")
        return
    caught = [(e.begin, 1e3 * e.delay, 1e3 * (e.end - e.begin)) for e in episodes if e.delay is not None]
    if caught:
        begin, delay, length = np.array(caught).T
        size = 12 + 60 * np.sqrt(length / length.max())
        axes.scatter(begin, delay, size, color=LEVEL_COLOURS[2], alpha=0.7, lw=0, label="warned; size: length of stay")
    missed = [e.begin for e in episodes if e.delay is None]
    if missed:
        axes.plot(missed, np.zeros(len(missed)), "x", color="black", markersize=6, label="missed")
    for n, span in enumerate(found.detection.false[:500]):
        label = "ERROR outside every band" if n == 0 else None
        axes.axvspan(span.begin, span.end, color=LEVEL_COLOURS[3], alpha=0.35, linewidth=0.8, label=label)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -0.05 * high), high * 1.35)
    axes.legend(loc="upper right", fontsize=8)


def _draw_regimes(axes: Axes, found: Analysis) -> None:
    regimes: list[str] = list(REGIME_COLOURS)
    left = np.zeros(len(regimes))
    for level, name in enumerate(LEVEL_NAMES):
        seconds = np.array([found.levels.seconds[level, regime] for regime in regimes])
        axes.barh(regimes, seconds, left=left, color=LEVEL_COLOURS[level], label=name)
        left += seconds
    axes.invert_yaxis()
    axes.set(xlabel="time, s", title="warning level under each stated regime")
    axes.set_xlim(0, 1.3 * max(float(left.max()), 1e-3))
    axes.legend(loc="upper right", fontsize=8)
