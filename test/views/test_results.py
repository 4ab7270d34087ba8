"""Every result draws itself into the axes it is given, with units, and gives its numbers away unchanged."""

import csv
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis.order_spectrum import OrderSpectrum
from seat_gear_dynamics.motion import OperatingPoint, System, Window
from seat_gear_dynamics.plotting import Plottable, PlottingError
from seat_gear_dynamics.regimes import MeshForce, Regime, RegimeMap, simulate
from seat_gear_dynamics.regimes.attractors import LOST, Attractor
from seat_gear_dynamics.regimes.basins import Basins
from seat_gear_dynamics.regimes.sweep import Row, Sweep, Way
from seat_gear_dynamics.studies.calibration.sensitivity import Drift, Drifts
from seat_gear_dynamics.studies.contact_verification import (
    CONDITIONS,
    Assumptions,
    ConditionRun,
    ForceHistory,
    Statistics,
)
from seat_gear_dynamics.studies.harmonic_balance import response_curve
from seat_gear_dynamics.studies.identification.confidence import Confidence
from seat_gear_dynamics.studies.identification.fit import Solution
from seat_gear_dynamics.studies.identification.identify import Estimate, Fitted
from seat_gear_dynamics.studies.identification.model_observables import Drives, Predicted
from seat_gear_dynamics.studies.identification.observables import Observed, names_for
from seat_gear_dynamics.studies.identification.parameters import chosen
from seat_gear_dynamics.studies.identification.waveform import Sensor
from seat_gear_dynamics.studies.taguchi import Factor, run_study
from seat_gear_dynamics.studies.warning_quality.assess import Assessment
from seat_gear_dynamics.studies.warning_quality.score import Roc, Tally
from seat_gear_dynamics.studies.work_precision import Case, Measurement, Reference, WorkPrecision
from seat_gear_dynamics.views.figures.style import COLUMN, PAGE, SMALLEST_TYPE, new_figure, preset, save

FORCE = MeshForce(0.1, 0.0, 2 / 3, 1.1, 0.0, 1.0)


def made_sweep() -> Sweep:
    regimes: dict[Way, Regime] = {
        "up": Regime("periodic", 1, 0.01, 0.002, ""),
        "down": Regime("chaotic", None, 0.1, 0.002, ""),
    }
    rows = [
        Row(value, way, regimes[way], FORCE, np.full((3, 2), value / 3)) for value in (100.0, 200.0) for way in regimes
    ]
    lost = Row(300.0, "up", Regime("undecided", None, None, None, "diverged"), None, np.empty((0, 2)))
    return Sweep("speed_rpm", (*rows, lost))


def made_map() -> RegimeMap:
    chaos = np.array([[0.0, 1.0, 1.0], [0.0, 0.0, 1 / 3]])
    codes = np.where(chaos > 0.5, 2, 0).astype(np.int64)
    axes = RPM * np.array([100.0, 200.0, 300.0]), np.array([300.0, 600.0])
    return RegimeMap(*axes, codes, codes, chaos / 7, chaos, 100.0 + chaos, chaos, 0, "made", 1, 48)


def made_basins() -> Basins:
    regimes = Regime("periodic", 2, 0.0, 0.0, ""), Regime("chaotic", None, 0.0, 0.0, "")
    window = Window(duration=10.0, separated=4.5)
    motions = tuple(Attractor(regime, np.full((4, 2), 0.5), window, np.zeros(24)) for regime in regimes)
    labels = np.array([[0, 0, 1], [0, LOST, 1]])
    return Basins(np.array([0.0, 1 / 3, 2.0]), np.array([-1.0, 1.0]), labels, motions)


def made_work(train: GearTrain) -> WorkPrecision:
    case = Case("smooth", System(train, OperatingPoint(0.5, 600.0)), 3)
    measured = tuple(Measurement("smooth", "fourth", 1 / n, (100 / n) ** 4, n, nan) for n in (100, 300, 1000))
    return WorkPrecision((case,), (Reference(np.zeros(24), 1e-13, 0),), measured)


def made_condition() -> ConditionRun:
    time = np.linspace(0.0, 5.0, 101)
    force = 5652.0 + 100 * np.sin(2 * np.pi * time)
    made = ForceHistory(time, force, 2 * force, 0 * force, force / 7)
    statistics = Statistics.of(force)
    return ConditionRun(CONDITIONS[5], Assumptions(), 5652.0, 1.0, made, 1.0, statistics, statistics)


def made_fit(train: GearTrain) -> Fitted:
    """Four dwells, one of which was left out; nothing is told of the second parameter."""
    drives = Drives(np.full(4, 50.0), np.array([20.0, 20.0, 300.0, 300.0]), (1, 1, 0, 1))
    value = np.array([100.0, 20.0, 70.0, 130.0, 25.0])
    observed = tuple(
        Observed(names_for(n), value[: 4 + n], np.eye(4 + n), np.ones((10, 4 + n)), 1.0) for n in drives.orders
    )
    measured = np.concatenate([each.value for each in observed])
    before, after = (Predicted(factor * measured, np.ones(4, dtype=bool)) for factor in (1.2, 0.99))
    parameters = chosen(["damping", "backlash"])
    estimates = (
        Estimate(parameters[0], 0.07, 0.08, (0.07, 0.09), (0.07, 0.09), False, ()),
        Estimate(parameters[1], 2e-5, 2e-5, None, None, True, ("damping",)),
    )
    correlation = np.array([[1.0, np.nan], [np.nan, np.nan]])
    sure = Confidence(
        np.array([0.1, np.inf]), np.zeros((2, 2)), np.array([True, False]), correlation, np.ones(2), np.ones(2), 1.0
    )
    solution = Solution(np.zeros(1), 0.5, np.ones((19, 1)), np.zeros(19), 1, 1)
    left_out = ("", "irregular in the record", "", "")
    return Fitted(
        Sensor(), drives, observed, before, after, left_out, estimates, sure, solution, (1, 1), train, 1.0
    )  # fmt: skip


def experiment(setting: Mapping[str, float]) -> dict[str, float]:
    return {"y": setting["A"] * setting["B"] ** -0.5}


TALLY = Tally(delays=[0.01, 0.05], notices=[(50.0, 0.7), (100.0, 0.6)])
ROC = Roc(np.array([1.0, 0.5, 0.0]), np.array([0.0, 0.9, 1.0]), np.array([0.0, 1 / 3, 1.0]), 10, 20)
DRIFTS = Drifts(
    (Drift("backlash", 2e-5, 0.05, 0.1, ("C3",), ()), Drift("error phase", 0.4, 0.5, 0.0, (), ("C1", "C2")))
)
FACTORS = [Factor("A", "N·m", (1.0, 2.0, 4.0)), Factor("B", "µm", (1.0, 2.0, 4.0)), Factor("C", "1", (1.0, 2.0, 4.0))]

MAKERS: dict[str, Callable[[GearTrain], Plottable]] = {
    "simulation": lambda train: simulate(System(train), frequency=0.5, load=600.0, transient=40, periods=48),
    "response": lambda train: simulate(System(train), frequency=0.5, transient=40, periods=48).response,
    "history": lambda train: simulate(System(train), frequency=0.5, transient=40, periods=48).history(periods=2),
    "sweep": lambda train: made_sweep(),
    "map": lambda train: made_map(),
    "basins": lambda train: made_basins(),
    "response curve": lambda train: response_curve(System(train).at(load=100.0), 0.6, 0.66, harmonics=8),
    "taguchi": lambda train: run_study(FACTORS, experiment, ["y"]),
    "work precision": made_work,
    "order spectrum": lambda train: OrderSpectrum(np.arange(5) / 8, np.array([0.0, 1 / 3, 2.0, 1.0, 0.1]), 4),
    "drifts": lambda train: DRIFTS,
    "condition": lambda train: made_condition(),
    "assessment": lambda train: Assessment(TALLY, {}, {"danger": ROC}, {}),
    "roc": lambda train: ROC,
    "fit to a bench": made_fit,
}
PANELS = {
    "history": ("time", "portrait", "force", "section"),
    "sweep": ("section", "exponent"),
    "map": ("regimes", "chaos"),
    "response curve": ("rms", "contact_loss", "force_max"),
    "condition": ("run", "settled"),
    "assessment": ("roc", "machine_roc", "notices", "delays"),
    "fit to a bench": ("ranges", "spreads", "residuals", "correlation"),
}
UNIT = re.compile(r", (r/min|N·m|N|kN|µm|%|s|ms|dB|1/τ)\b|, %| of the force, N$|b_c|τ|Ω")
PURE = (
    "largest exponent",
    "order: events per revolution",
    "false positive rate",
    "true positive rate",
    "evaluations",
    "error of the final state",
    "level of the factor; above: its unit",
    "harmless drift",
    "parameter",
    "ramps",
    "notice before entry, s",
    "stays in a band",
    "from the edge to ERROR, ms",
)
"""What labels of counts, rates, names and dimensionless quantities begin with."""


@pytest.fixture(scope="module")
def results(train: GearTrain) -> dict[str, Plottable]:
    return {name: make(train) for name, make in MAKERS.items()}


def plots(results: dict[str, Plottable]) -> Iterator[tuple[str, Callable[..., Any]]]:
    for name, result in results.items():
        for panel in PANELS.get(name, ("",)):
            options = {"panel": panel} if panel else {}
            yield (
                f"{name} {panel}",
                lambda ax=None, result=result, options=options: result.plot(ax, **options),
            )


def test_every_result_makes_axes_with_units_and_something_in_them(
    results: dict[str, Plottable], tmp_path: Path
) -> None:
    for number, (name, plot) in enumerate(plots(results)):
        axes = plot()
        assert axes.has_data() or "machine_roc" in name, name
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert label, name
            assert UNIT.search(label) or label.startswith(PURE), f"{name}: {label!r} names no unit"
        path = tmp_path / f"{number}.png"
        save(axes.figure, path)
        assert path.read_bytes().startswith(b"\x89PNG"), name
        assert path.stat().st_size < 200_000, name


def test_every_result_draws_into_the_axes_it_is_given_and_nowhere_else(results: dict[str, Plottable]) -> None:
    for name, plot in plots(results):
        figure, (left, right) = new_figure(1, 2)
        assert plot(right) is right, name
        assert not left.has_data(), name
        assert right.figure is figure


def test_csv_holds_the_tables_numbers_to_the_last_bit(results: dict[str, Plottable], tmp_path: Path) -> None:
    for name, result in results.items():
        table = result.table()
        path = tmp_path / "result.csv"
        result.to_csv(path)
        with path.open(newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        assert head == [column.title for column in table], name
        assert rows, name
        for column, cells in zip(table, zip(*rows, strict=True), strict=True):
            assert len(column.values) == len(cells), name
            for value, cell in zip(column.values, cells, strict=True):
                assert same(value, cell), f"{name}, {column.name}: {value!r} became {cell!r}"


def same(value: Any, cell: str) -> bool:
    if value is None:
        return cell == ""
    if isinstance(value, (str, bool, np.bool_)):
        return str(value) == cell
    return float(cell) == float(value) or (np.isnan(float(cell)) and np.isnan(float(value)))


def test_tables_hold_the_results_numbers_with_their_units() -> None:
    speeds = made_map().table().column("speed_rpm")
    assert speeds.unit == "r/min"
    assert np.asarray(speeds.values) == pytest.approx([100, 200, 300] * 2, rel=1e-15)  # there and back: rounding
    assert made_map().table().column("regime").values == ["periodic", "chaotic", "chaotic", *["periodic"] * 3]
    rows = made_sweep().table()
    assert rows.column("value").title == "value [r/min]"
    assert rows.column("force_max").title == "force_max [N]"
    assert rows.column("force_max").values == [2 / 3] * 4 + [None]
    assert len(made_sweep().table(points=True).column("delta").values) == 4 * 3
    assert list(made_basins().table().column("motion").values) == [0, 0, 1, 0, LOST, 1]
    assert DRIFTS.table().column("lost_up").values == ["", "C1 C2"]


def test_a_simulations_table_is_its_forces_and_its_points_the_section(results: dict[str, Plottable]) -> None:
    found: Any = results["simulation"]
    assert found.table().column("max").values == [force.max for force in found.meshes.values()]
    assert (np.asarray(found.table(points=True).column("delta").values) == found.response.section[:, 0]).all()


def test_a_history_goes_on_where_the_simulation_ended(results: dict[str, Plottable]) -> None:
    found: Any = results["simulation"]
    begin = found.history(periods=1)
    system = found.response.system
    delta, rate = (float(each[0]) for each in system.deflections(0.0, found.response.state))
    # To rounding: the march takes δ from its table of the excitation, `deflections` from the series.
    assert (begin.delta[0, 0], begin.rate[0, 0]) == pytest.approx((delta, rate), rel=1e-6, abs=1e-9)


def test_what_was_drawn_is_what_the_table_holds(results: dict[str, Plottable]) -> None:
    history = results["history"]
    (line,) = history.plot(panel="force", mesh=1).get_lines()
    assert list(line.get_ydata()) == list(history.table().column("s3_s4/force").values)
    (line,) = results["order spectrum"].plot().get_lines()
    assert list(line.get_xdata()) == list(results["order spectrum"].table().column("order").values)
    (line,) = results["work precision"].plot().get_lines()
    assert list(line.get_ydata()) == list(results["work precision"].table().column("error").values)


@pytest.mark.parametrize("name", [*PANELS])
def test_a_panel_that_is_not_there_is_named_with_those_that_are(results: dict[str, Plottable], name: str) -> None:
    with pytest.raises(ValueError, match=f"no panel 'nonsense'.*{PANELS[name][0]}"):
        results[name].plot(panel="nonsense")


def test_what_was_not_measured_is_refused(results: dict[str, Plottable]) -> None:
    with pytest.raises(ValueError, match="holds no times"):
        results["work precision"].plot(in_time=True)
    with pytest.raises(ValueError, match=r"no panel 'z'.*expected one of y"):
        results["taguchi"].plot(response="z")


def test_without_matplotlib_a_sentence_says_what_to_do(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for module in [each for each in sys.modules if each.startswith("seat_gear_dynamics.views.figures")]:
        monkeypatch.delitem(sys.modules, module)
    for module in [each for each in sys.modules if each.partition(".")[0] == "matplotlib"]:
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(PlottingError, match=r"needs the package matplotlib.*pip install"):
        made_map().plot()
    made_map().to_csv(tmp_path / "map.csv")


def test_results_and_their_tables_bring_no_matplotlib() -> None:
    program = (
        "import sys\nimport seat_gear_dynamics.regimes, seat_gear_dynamics.studies.taguchi\n"
        "from seat_gear_dynamics.views.tables import motions, regimes, studies\n"
        "print('matplotlib' in sys.modules)"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "False"


def type_sizes(figure: Any) -> set[float]:
    from matplotlib.text import Text

    return {text.get_fontsize() for text in figure.findobj(Text) if text.get_text() and text.get_visible()}


def test_in_print_figures_are_a_column_wide_and_letters_can_be_read(results: dict[str, Plottable]) -> None:
    with preset("print"):
        for name, plot in plots(results):
            figure = plot().figure
            figure.draw_without_rendering()
            assert figure.get_size_inches()[0] == COLUMN, name
            assert min(type_sizes(figure)) >= SMALLEST_TYPE, name
        assert new_figure(1, 3, width=10.5)[0].get_size_inches()[0] == PAGE
    assert new_figure(1, 3, width=10.5)[0].get_size_inches()[0] == 10.5


def test_an_unknown_preset_is_refused() -> None:
    with pytest.raises(ValueError, match=r"no preset 'dark'.*screen, print"), preset("dark"):  # type: ignore[arg-type]
        pass


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_the_same_figure_gives_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    written = []
    for number in (1, 2):
        path = tmp_path / f"{number}.{suffix}"
        save(made_map().plot().figure, path)
        written.append(path.read_bytes())
    assert written[0] == written[1]
    # A year of this century stands in a date; the numbers of a drawing have a point or come in pairs.
    assert b"CreationDate" not in written[0]
    assert b"<dc:date>" not in written[0]


def test_the_callers_settings_come_back(results: dict[str, Plottable]) -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    results["map"].plot()
    assert dict(matplotlib.rcParams) == before
