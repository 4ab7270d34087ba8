"""How results draw and export themselves without any room looking up: each class names its figure and its table."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from os import PathLike
from typing import Any, ClassVar

from numpy.typing import NDArray

_VIEWS = "seat_gear_dynamics.views"


class PlottingError(RuntimeError):
    """A result that cannot be drawn here; the text says what to do."""


@dataclass(frozen=True, eq=False)
class Column:
    """One column of a table."""

    name: str
    unit: str
    """As printed: `N`, `r/min`, `1/τ`, `b_c`; empty for words, counts and pure numbers."""
    values: Sequence[Any] | NDArray[Any]
    """None where nothing is said."""

    @property
    def title(self) -> str:
        """Name and unit as in the first line of a CSV file, `force_max [N]`."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


class Table(tuple[Column, ...]):
    """Columns of equal length."""

    def column(self, name: str) -> Column:
        """Return the column called `name`; raises KeyError where there is none."""
        for each in self:
            if each.name == name:
                return each
        raise KeyError(f"The table has no column {name!r}; it has {', '.join(each.name for each in self)}.")

    @classmethod
    def of_rows(cls, rows: Sequence[Mapping[str, Any]], units: Mapping[str, str]) -> "Table":
        """Return the table of rows that all have the keys of `units`, which maps a column's name to its unit."""
        return cls(Column(name, unit, [row[name] for row in rows]) for name, unit in units.items())


class Plottable:
    """A result that draws itself and exports its numbers.

    A class says where, `class Sweep(Plottable, figure="bifurcation:plot_sweep", table="sweeps:sweep_table")`: a
    function of a module in `views/figures` that takes (axes, result, options), and one of a module in `views/tables`
    that takes (result, options). Both are imported when they are called. This is the one way in which a room reaches
    what lies above it, and it goes by name.
    """

    _figure: ClassVar[str]
    _table: ClassVar[str]

    def __init_subclass__(cls, *, figure: str = "", table: str = "", **options: Any) -> None:
        super().__init_subclass__(**options)
        if figure:
            cls._figure = figure
        if table:
            cls._table = table

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the result into `ax`, or into new axes in the project's style, and return these axes.

        What `options` there are says the function that the class names (`panel=` for most). New axes belong to no
        window: save them with `ax.figure.savefig`, or give axes of `matplotlib.pyplot.subplots()` to see them. Raises
        PlottingError where matplotlib is not installed, ValueError for a panel that the result does not have.
        """
        draw = _drawing(f"{_VIEWS}.figures.{self._figure}")
        styled = _drawing(f"{_VIEWS}.figures.style:in_style")
        if ax is None:
            _, ax = _drawing(f"{_VIEWS}.figures.style:new_figure")()
        styled(draw)(ax, self, **options)
        return ax

    def table(self, **options: Any) -> Table:
        """Return the numbers behind the plot as columns with units; `options` as the class's table function has them.

        Needs no matplotlib.
        """
        found: Table = _function(f"{_VIEWS}.tables.{self._table}")(self, **options)
        return found

    def to_csv(self, path: str | PathLike[str], **options: Any) -> None:
        """Write `table` to `path` as CSV in UTF-8: a line of names with units, then the rows.

        Numbers are written so that they read back to the last bit; what is not said is empty. Raises OSError where
        the file cannot be written.
        """
        columns = self.table(**options)
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([column.title for column in columns])
            writer.writerows(zip(*(map(_plain, column.values) for column in columns), strict=True))


def _plain(value: Any) -> Any:
    """Return NumPy's numbers as Python's, whose text reads back to the last bit."""
    return value.item() if hasattr(value, "item") else value


def _function(name: str) -> Any:
    module, _, function = name.partition(":")
    return getattr(import_module(module), function)


def _drawing(name: str) -> Any:
    try:
        return _function(name)
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] != "matplotlib":
            raise
        raise PlottingError(
            "Drawing needs the package matplotlib, which is not installed: pip install matplotlib. "
            "The numbers are there without it: use table() or to_csv()."
        ) from missing
