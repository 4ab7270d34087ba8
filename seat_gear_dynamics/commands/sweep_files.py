"""A sweep's two tables on disk, read back row by row: what is summed up and drawn is what was written."""

from array import array
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from seat_gear_dynamics.regimes.sweep import Row
    from seat_gear_dynamics.regimes.sweep_plan import Plan

MOST_DRAWN = 2_000_000
"""Section points that a picture is drawn from at most: beyond, some values are left out of it."""


def points_path(table: Path) -> Path:
    """Return where the section points of the sweep in `table` go."""
    return table.with_name(f"{table.stem}_points.csv")


def read_rows(table: Path) -> "Iterator[Row]":
    """Yield the rows of `table`, in their order, without section points."""
    from seat_gear_dynamics.regimes.sweep_table import parse

    with table.open(newline="", encoding="ascii") as file:
        next(file)
        yield from map(parse, file)


def thinning(plan: "Plan") -> int:
    """Return every how many-th value of a sweep is drawn."""
    return -(-plan.rows * plan.periods // MOST_DRAWN)


def drawn_rows(table: Path, plan: "Plan") -> "Iterator[Row]":
    """Yield the rows to draw with their section points: of every value, or of some where that were too many.

    A value of a sweep of both directions is kept in both or in none.
    """
    every = thinning(plan)
    with points_path(table).open(newline="", encoding="ascii") as points:
        next(points)
        for number, row in enumerate(read_rows(table)):
            turn, way = divmod(number, len(plan.ways))
            place = plan.points - 1 - turn if plan.ways[way] == "down" else turn
            whole = _with_section(row, points, plan.periods, wanted=place % every == 0)
            if whole is not None:
                yield whole


def coexisting(table: Path, plan: "Plan") -> Iterator[float]:
    """Yield the values, increasing, at which up and down of a sweep of both end on different motions.

    Holds two sections at a time, the rows without theirs, and where the section of each row begins.
    """
    from dataclasses import replace

    from seat_gear_dynamics.regimes.sweep import differ
    from seat_gear_dynamics.regimes.sweep_table import parse_section

    if plan.direction != "both":
        return
    rows = list(read_rows(table))
    starts = _section_starts(rows, points_path(table), plan.periods)
    with points_path(table).open("rb") as points:

        def whole(number: int) -> "Row":
            points.seek(starts[number])
            count = plan.periods if rows[number].force else 0
            return replace(rows[number], section=parse_section(line.decode() for line in islice(points, count)))

        for turn in range(plan.points):
            # Up meets a value in this turn, down in the turn that is as far from the end.
            first, second = whole(2 * turn), whole(2 * (plan.points - 1 - turn) + 1)
            if differ(first, second):
                yield first.value


def _with_section(row: "Row", points: TextIO, periods: int, *, wanted: bool) -> "Row | None":
    """Take the row's lines from `points`; return the row with its section if it is wanted."""
    from dataclasses import replace

    from seat_gear_dynamics.regimes.sweep_table import parse_section

    own = islice(points, periods if row.force else 0)
    if wanted:
        return replace(row, section=parse_section(own))
    for _ in own:
        pass
    return None


def _section_starts(rows: "list[Row]", path: Path, periods: int) -> "array[int]":
    """Return where in the table of section points the lines of each row begin, bytes."""
    starts = array("q")
    with path.open("rb") as points:
        place = len(next(points))
        for row in rows:
            starts.append(place)
            place += sum(len(line) for line in islice(points, periods if row.force else 0))
    return starts
