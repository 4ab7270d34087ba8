"""The picture of a recorded run: speed against its forbidden bands with the warning, load, forces, Poincaré section."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.run import Run
from seat_gear_dynamics.views.colours import BAND, LEVEL_COLOURS, LEVEL_NAMES, LOAD, MESH_COLOURS, SPEED

Array = NDArray[np.float64]
Axes = Any  # matplotlib ships no types for what is used here


def write_report(run: Run, boxes: Array, path: Path, *, load_scale: float) -> None:
    """Draw `run` to a PNG file at `path`; raises OSError where it cannot be written.

    `boxes` (n, 4) say where |speed| is forbidden: begin and end in s, low and high in rad/s of s1.
    """
    figure = Figure(figsize=(13, 9.5), layout="constrained")
    FigureCanvasAgg(figure)
    parts: Axes = figure.subfigures(1, 2, width_ratios=(1.75, 1))
    left, right = parts
    speed, load, first, second = left.subplots(4, 1, sharex=True, height_ratios=(2, 1, 1.5, 1.5))
    _draw_speed(speed, run, boxes)
    _draw_load(load, run)
    _draw_force(first, run, "s1_s2", MESH_COLOURS[0], load_scale)
    _draw_force(second, run, "s3_s4", MESH_COLOURS[1], load_scale)
    second.set_xlabel("time since the log's start, s")
    section, text = right.subplots(2, 1)
    _draw_section(section, run)
    _draw_words(text, run)
    figure.suptitle(f"{run.path.name}: {run.duration:.1f} s on the bench", fontweight="bold")
    figure.savefig(path, dpi=110)


def level_spans(run: Run) -> list[tuple[float, float, int]]:
    """Return (begin s, end s, level) of each stretch of constant warning level."""
    spans: list[tuple[float, float, int]] = []
    for status in run.warnings:
        if spans and spans[-1][2] == status.level:
            spans[-1] = (spans[-1][0], status.time, status.level)
        else:
            if spans:
                spans[-1] = (spans[-1][0], status.time, spans[-1][2])
            spans.append((status.time, status.time, status.level))
    return spans


def time_by_level(run: Run) -> dict[str, float]:
    """Return how long each warning level stood, s, by its name."""
    total = dict.fromkeys(LEVEL_NAMES, 0.0)
    for begin, end, level in level_spans(run):
        total[LEVEL_NAMES[level]] += end - begin
    return total


def _draw_speed(axes: Axes, run: Run, boxes: Array) -> None:
    time, speed = run.speed
    rpm = speed / RPM
    draw_boxes(axes, boxes, backward=bool(len(rpm)) and rpm.min() < 0)
    axes.plot(time, rpm, color=SPEED, lw=1.2)
    axes.set_ylabel("speed of s1, r/min")
    low, high = axes.get_ylim()
    strip = low - 0.04 * (high - low)
    for begin, end, level in level_spans(run):
        axes.plot([begin, end], [strip, strip], color=LEVEL_COLOURS[level], lw=6, solid_capstyle="butt")
    handles = [axes.plot([], [], color=colour, lw=6)[0] for colour in LEVEL_COLOURS]
    _legend_above(axes, handles, LEVEL_NAMES, title="warning (strip); forbidden bands shaded")
    axes.grid(alpha=0.3)


def draw_boxes(axes: Axes, boxes: Array, *, backward: bool) -> None:
    """Shade what is forbidden, as `write_report` takes it, on axes of r/min over s; `backward` in reverse too."""
    corners = []
    for begin, end, low, high in boxes.tolist():
        for sign in (1, -1) if backward else (1,):
            edges = (sign * low / RPM, sign * high / RPM)
            corners.append([(begin, edges[0]), (begin, edges[1]), (end, edges[1]), (end, edges[0])])
    edge = 0.8 if len(corners) < 20 else 0.0  # keeps a narrow band visible; between many boxes it would be a hatch
    axes.add_collection(PolyCollection(corners, color=BAND, alpha=0.22, linewidths=edge, zorder=0.9))
    axes.autoscale_view()


def _draw_load(axes: Axes, run: Run) -> None:
    axes.plot(*run.load, color=LOAD, lw=0.8)
    low, high = float(run.load[1].min(initial=0.0)), float(run.load[1].max(initial=0.0))
    room = 0.08 * (high - low) or 1.0
    axes.set_ylim(low - room * (low < 0), high + room)
    axes.set_ylabel("load T4, N·m")
    axes.grid(alpha=0.3)


def _draw_force(axes: Axes, run: Run, mesh: str, colour: str, load_scale: float) -> None:
    axes.set_ylabel(f"{mesh} force, N")
    axes.grid(alpha=0.3)
    if run.force is None or not len(run.force.time):
        axes.text(0.5, 0.5, "the log has no mesh forces", transform=axes.transAxes, ha="center", color="grey")
        return
    effort = run.force.effort
    axes.fill_between(
        run.force.time, effort[f"{mesh}/min"], effort[f"{mesh}/max"], color=colour, alpha=0.25, lw=0, label="min to max"
    )
    axes.plot(run.force.time, effort[f"{mesh}/mean"], color=colour, lw=1.0, label="mean")
    _legend_above(axes, *axes.get_legend_handles_labels(), title=f"load scale {load_scale:.4g}")


def _legend_above(axes: Axes, handles: Any, labels: Any, *, title: str) -> None:
    """Put the legend above the axes in one line, where it hides no curve."""
    axes.set_title(title, loc="left", fontsize=8)
    axes.legend(handles, labels, ncols=4, fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)


def _draw_section(axes: Axes, run: Run) -> None:
    axes.set_title("Poincaré section of s1_s2", fontsize=10)
    axes.set_xlabel("δ / b_c")
    axes.set_ylabel("dimensionless rate of δ")
    axes.grid(alpha=0.3)
    if not len(run.section):
        axes.text(0.5, 0.5, "the log has no section points", transform=axes.transAxes, ha="center", color="grey")
        return
    rpm = np.interp(run.section[:, 2], run.speed[0], np.abs(run.speed[1]) / RPM)
    points = axes.scatter(run.section[:, 0], run.section[:, 1], c=rpm, s=1.5, cmap="viridis", lw=0)
    axes.figure.colorbar(points, ax=axes, label="|speed|, r/min", location="bottom")


def _draw_words(axes: Axes, run: Run) -> None:
    axes.axis("off")
    axes.text(
        0.0, 1.0, "\n".join(summary_lines(run)), va="top", fontsize=8, family="monospace", transform=axes.transAxes
    )


def summary_lines(run: Run) -> list[str]:
    """Return the run in words: warning time by level, forces, and each topic's count, period and longest gap."""
    lines = ["warning, time by level"]
    lines += [f"  {name:6s}{seconds:8.1f} s" for name, seconds in time_by_level(run).items()]
    if run.force is not None and len(run.force.time):
        lines.append("largest mesh force")
        lines += [f"  {mesh:6s}{np.nanmax(run.force.effort[f'{mesh}/max']):8.0f} N" for mesh in ("s1_s2", "s3_s4")]
    lines.append("topic (messages, period, gap in ms)")
    for flow in run.flows:
        name = flow.topic if len(flow.topic) <= 22 else "…" + flow.topic[-21:]
        lines.append(f"  {name:22s}{flow.count:6d}{1e3 * flow.period:6.0f}{1e3 * flow.longest_gap:6.0f}")
    if run.damage:
        lines.append(f"damage: {run.damage}")
    return lines
