"""The work-precision diagram: error of each integrator against what it costs."""

from math import isnan
from typing import Any

from seat_gear_dynamics.studies.work_precision import WorkPrecision
from seat_gear_dynamics.views.figures.style import LINE_COLOURS, Axes, chosen, in_style, legend_columns, new_figure

_MARKS = "osD^vPX<>"


@in_style
def work_precision_figure(found: WorkPrecision) -> Any:
    """Return the figure: a column for each case, above over evaluations and below, where measured, over time.

    Lines that end lower on the left are better. The grey band is the uncertainty of the reference, in which no error
    can be told.
    """
    timed = any(not isnan(m.seconds) for m in found.measurements)
    rows, columns = (2 if timed else 1), len(found.cases)
    figure, axes = new_figure(
        rows, columns, width=3.4 * columns + 1.8, height=3.0 * rows + 0.4, sharey=True, squeeze=False
    )
    solvers = list(dict.fromkeys(m.solver for m in found.measurements))
    for column, (case, end) in enumerate(zip(found.cases, found.references, strict=True)):
        for row in range(rows):
            _draw(axes[row, column], found, case.name, solvers, in_time=row == 1)
            axes[row, column].axhspan(0, max(end.uncertainty, 1e-16), color="#DDDDDD", zorder=0)
        point = case.system.operating_point
        axes[0, column].set_title(f"{case.name}\nΩ {point.frequency:g}, {point.load:g} N·m, {end.changes} changes")
    for row in range(rows):
        axes[row, 0].set_ylabel("error of the final state, b_c")
    axes[0, -1].legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
    return figure


def plot_work_precision(axes: Axes, found: WorkPrecision, *, case: str = "", in_time: bool = False) -> None:
    """Draw one case, by default the first, over evaluations or, where it was measured, `in_time`.

    Raises ValueError for another case, and for time where none was taken.
    """
    references = {each.name: end for each, end in zip(found.cases, found.references, strict=True)}
    case = case or next(iter(references), case)
    end = chosen(case, references)
    if in_time and all(isnan(m.seconds) for m in found.measurements):
        raise ValueError("The study holds no times, expected seconds; run it with a clock, or draw over evaluations.")
    solvers = list(dict.fromkeys(m.solver for m in found.measurements))
    _draw(axes, found, case, solvers, in_time=in_time)
    axes.axhspan(0, max(end.uncertainty, 1e-16), color="#DDDDDD", zorder=0)
    axes.set(ylabel="error of the final state, b_c")
    columns = legend_columns(axes.figure, most=4)
    axes.legend(title=case, loc="lower left", bbox_to_anchor=(-0.1, 1.0), ncols=columns)


def _draw(axes: Axes, found: WorkPrecision, case: str, solvers: list[str], *, in_time: bool) -> None:
    for n, solver in enumerate(solvers):
        own = [m for m in found.measurements if (m.case, m.solver) == (case, solver)]
        cost = [1e3 * m.seconds if in_time else m.evaluations for m in own]
        axes.loglog(
            cost,
            [m.error for m in own],
            marker=_MARKS[n % len(_MARKS)],
            markersize=3.5,
            linestyle="-" if n < len(LINE_COLOURS) else "--",
            color=LINE_COLOURS[n % len(LINE_COLOURS)],
            label=solver,
        )
    axes.set_xlabel("time, ms" if in_time else "evaluations of the right-hand side")
    axes.set_ylim(1e-12, 10)
