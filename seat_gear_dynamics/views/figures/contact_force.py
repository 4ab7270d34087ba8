"""Figs 17 and 18 of the paper: the P12 contact force over time, one row per condition."""

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.studies.contact_verification import ConditionRun, ForceHistory
from seat_gear_dynamics.views.figures.style import LINE_COLOURS, Axes, chosen, in_style, is_narrow, new_figure

Array = NDArray[np.float64]

CLEARANCE_CONDITIONS = (4, 5, 6)
"""Fig. 17: backlash 0, 10, 30 µm."""
LOAD_CONDITIONS = (7, 8, 9)
"""Fig. 18: load 100, 300, 600 N·m."""
_SHOWN_PERIODS = 4.0


@in_style
def contact_force_figure(
    runs: Mapping[int, ConditionRun], starts: Mapping[int, ForceHistory], numbers: Sequence[int]
) -> tuple[Any, Any]:
    """Return (figure, axes of shape (n, 3)): per condition its start, the whole run, and some mesh periods.

    Conditions are given by `numbers`; `starts` are finely sampled (`start_up`). All panels of a column share their
    scales, so that conditions compare; dashed is the static force. Raises ValueError for no conditions and KeyError for
    one without a run.
    """
    if not numbers:
        raise ValueError("There are no conditions to draw; give the numbers of at least one.")
    figure, axes = new_figure(
        len(numbers), 3, width=9.0, height=1.0 + 1.7 * len(numbers), sharex="col", sharey="col", squeeze=False
    )
    for row, number, colour in zip(axes, numbers, LINE_COLOURS * len(numbers), strict=False):
        run, start = runs[number], starts[number]
        history = run.history
        _draw(row[0], start.time * 1e3, start.force, run.static, colour)
        _draw(row[1], history.time, history.force, run.static, colour)
        settled = _periods(run)
        _draw(row[2], (history.time[settled] - run.settled_from) * 1e3, history.force[settled], run.static, colour)
        row[0].set_ylabel("force, kN")
        name = run.condition.name
        row[1].set_title(name[0].upper() + name[1:], fontsize=9)
    for axis, label in zip(axes[-1], ("start, ms", "whole run as sampled, s", "settled, ms"), strict=True):
        axis.set_xlabel(label)
    for axis in axes[:, :2].flat:
        axis.set_ylim(bottom=0)
    return figure, axes


def plot_condition(axes: Axes, run: ConditionRun, *, panel: str = "run") -> None:
    """Draw the force of s1_s2: the whole `run` as sampled, or some mesh periods once `settled`; dashed: static.

    Raises ValueError for another panel.
    """
    history = run.history
    if chosen(panel, {"run": True, "settled": False}):
        _draw(axes, history.time, history.force, run.static, LINE_COLOURS[0])
        axes.set_xlabel("time, s")
        axes.set_ylim(0, 1.05 * max(float(history.force.max()), run.static) / 1e3)
    else:
        shown = _periods(run)
        time = (history.time[shown] - run.settled_from) * 1e3
        _draw(axes, time, history.force[shown], run.static, LINE_COLOURS[0])
        axes.set_xlabel("time since it settled, ms")
    axes.set(ylabel="contact force of s1_s2, kN", title=fill(run.condition.name, 36 if is_narrow(axes.figure) else 48))


def _draw(axis: Axes, time: Array, force: Array, static: float, colour: str) -> None:
    axis.plot(time, force / 1e3, color=colour, linewidth=0.9)
    axis.axhline(static / 1e3, color="#7F7F7F", linewidth=0.8, linestyle="--")


def _periods(run: ConditionRun) -> NDArray[np.bool_]:
    """Return which samples lie in the first mesh periods after the start; all settled ones at standstill."""
    time = run.history.time - run.settled_from
    inside = time >= 0
    if run.mesh_period < np.inf:
        inside &= time <= _SHOWN_PERIODS * run.mesh_period
    return np.asarray(inside)
