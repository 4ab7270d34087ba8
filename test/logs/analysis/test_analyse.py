"""Whole analyses: of a log of ours, of a foreign bag, of what is hardly a log; their tables, and the model beside."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.commands import main
from seat_gear_dynamics.gears import GearTrain, load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis import Analysis, ModelSettings, Source, analyse
from seat_gear_dynamics.logs.analysis import tables as tables_module
from seat_gear_dynamics.logs.analysis.batches import Batch
from seat_gear_dynamics.logs.analysis.estimate import Estimate
from seat_gear_dynamics.logs.analysis.model import force_along
from seat_gear_dynamics.logs.analysis.order_spectrum import order_spectrum
from seat_gear_dynamics.logs.analysis.overview import overview
from seat_gear_dynamics.logs.analysis.side_by_side import Stretches
from seat_gear_dynamics.logs.analysis.stream import Stream
from seat_gear_dynamics.logs.analysis.tables import tables, write_tables
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.run import read_run
from seat_gear_dynamics.motion import System, integrate
from seat_gear_dynamics.regimes import RegimeMap
from seat_gear_dynamics.sensing import MapBands, Session, packaged_map

SMALL = ModelSettings(dwells=1, sweep_points=3, map_speeds=3, transient=20, periods=50)


@pytest.fixture(scope="module")
def found(log: Path) -> Analysis:
    return analyse(log, load_train(), model=SMALL)


def test_an_analysis_of_our_log_agrees_with_the_arrays_of_the_reader(found: Analysis, log: Path) -> None:
    run = read_run(log)
    assert not found.provenance.estimated
    assert run.force is not None
    largest = max(stay.forces["s1_s2"].max for stay in found.bands if stay.seconds)
    assert largest == run.force.effort["s1_s2/max"].max()
    assert sum(stay.seconds for stay in found.bands) == pytest.approx(found.occupancy.total)
    assert found.occupancy.total == pytest.approx(12.0, abs=0.05)
    assert found.cloud.seen <= len(run.section)
    levels = found.levels.spans
    assert next(level for _, level, _ in levels if level != 3) == next(w.level for w in run.warnings if w.level != 3)


def test_the_run_enters_both_bands_and_is_warned(found: Analysis) -> None:
    # 1349 to 1359 r/min at 200 r/min a second, then 1589 r/min to the end of the log.
    assert len(found.detection.episodes) == 2
    last = found.detection.episodes[-1]
    assert last.delay is not None
    # One sample to enter, the alarm's debounce of 30 ms, one to publish: 20 ms each.
    assert 0 <= last.delay <= 0.07 + 1e-9
    assert last.lead is not None
    assert last.lead > 0.5


def test_dwells_are_those_of_the_profile(found: Analysis) -> None:
    speeds = [round(dwell.speed / RPM, -1) for dwell in found.dwells.rows if dwell.begin > 1]
    assert 600 in speeds
    assert 1300 in speeds


def test_the_provenance_names_the_log_by_its_hash(found: Analysis, log: Path) -> None:
    import hashlib

    (name, size, digest), *rest = found.provenance.files
    data = (log / name).read_bytes()
    assert not rest
    assert (size, digest) == (len(data), hashlib.sha256(data).hexdigest())
    assert found.provenance.log_system_hash == found.provenance.system_hash


def test_the_overview_draws_what_the_reader_reads(found: Analysis, log: Path) -> None:
    short, run = overview(found), read_run(log)
    assert short.force is not None
    assert run.force is not None
    assert short.force.effort["s1_s2/max"].max() == run.force.effort["s1_s2/max"].max()
    assert short.speed[1].max() == pytest.approx(run.speed[1].max(), rel=0.02)
    assert np.isin(short.section[:, 0], run.section[:, 0]).all()
    assert {w.level for w in short.warnings} == {w.level for w in run.warnings}


def test_a_foreign_bag_is_estimated_and_says_so(third_party: Path) -> None:
    told: set[str] = set()
    found = analyse(third_party, load_train(), tell=lambda stage, done, total: told.add(stage))
    assert found.provenance.estimated
    assert found.sweep is None
    assert found.map is None
    assert told == {"messages, through the model"}
    assert found.stretches == Stretches(count=1), "too short to be cut"
    # What bags/README.md says of it: dwells at 1200, 2150 and −900 r/min.
    speeds = {round(dwell.speed / RPM, -1) for dwell in found.dwells.rows}
    assert {1200, 2150, -900} <= speeds
    assert found.duration == pytest.approx(63.32, abs=0.01)
    assert overview(found).force is None, "what was computed here was not recorded"


def test_a_map_judges_stays_and_warnings_of_a_log_and_is_a_second_truth(
    log: Path, made_map: Callable[..., RegimeMap]
) -> None:
    train = load_train()
    bands = MapBands(made_map(train, [500.0, 700.0], [[(1450, 2100)]] * 2), train)
    found = analyse(log, train, bands=bands)
    assert found.map is bands.map
    assert (found.judged_by, found.stated_bands) == (bands, ("published",))
    # Up to 1800 r/min at 200 r/min a second, then a dwell: in danger from 1400, half a node beyond the crossing.
    (stay,) = found.detection.episodes
    seconds = {(s.stretch.forbidden, s.stretch.load): s.seconds for s in found.bands}
    assert seconds[True, 500.0] + seconds.get((True, 700.0), 0.0) == pytest.approx(stay.end - stay.begin, abs=0.03)
    assert sum(seconds.values()) == pytest.approx(found.occupancy.total)
    assert found.map_detection is not None
    (episode,) = found.map_detection.episodes  # the node at 1450 is nearest from 1425 r/min on
    assert 0.05 < episode.begin - stay.begin < 0.2
    assert found.detection.errors > len(found.detection.false), "the logged warnings are those of the published bands"


def test_a_foreign_log_is_warned_of_by_the_bands_of_the_map(
    third_party: Path, made_map: Callable[..., RegimeMap]
) -> None:
    train = load_train()
    bands = MapBands(made_map(train, [100.0, 400.0, 700.0], [[(1000, 1300)]] * 3), train)
    found = analyse(third_party, train, bands=bands)
    # The same drive through a session on these bands.
    session, verdicts = Session(train, bands=bands), []
    for batch in Stream(Bag(third_party), train)._recorded(None):
        verdicts += [session.feed(*row).verdict for row in batch.drive[:, :3].tolist()]
    shown = [verdict.level for verdict in verdicts]
    changes = [int(level) for n, level in enumerate(shown) if n == 0 or level != shown[n - 1]]
    assert [level for _, level, _ in found.levels.spans] == changes
    texts = {text for _, _, text in found.levels.spans}
    assert any("inside the forbidden band 950-1350" in text for text in texts), texts
    assert not any("band 1349-1359" in text for text in texts)
    assert found.judged_by.label == bands.label
    assert found.stated_bands == (), "the log itself has no warnings"
    assert any(stay.stretch.outside and stay.seconds > 1 for stay in found.bands), "2150 r/min is beyond the map"


def test_a_log_of_a_monitor_on_a_map_names_it(
    generator: Any, tmp_path: Path, made_map: Callable[..., RegimeMap]
) -> None:
    train = load_train()
    bands = MapBands(made_map(train, [500.0, 700.0], [[(400, 700)]] * 2), train)
    generator.write_log(tmp_path / "log", 5.0, bands=bands)
    found = analyse(tmp_path / "log", train, bands=bands)
    assert found.stated_bands == (bands.label,)
    (stay,) = found.detection.episodes
    assert stay.delay is not None, "danger and warning are of the same bands"
    other = analyse(tmp_path / "log", train)
    assert other.detection.episodes == ()
    assert other.judged_by.label == "published"


def test_a_log_of_a_monitor_on_the_packaged_map_is_judged_by_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], generator: Any
) -> None:
    train = load_train()
    with packaged_map().open("rb") as file:
        bands = MapBands(RegimeMap.load(file, train), train)
    generator.write_log(tmp_path / "log", 8.5, bands=bands)
    assert main(["analyze", str(tmp_path / "log"), "--output", str(tmp_path / "out"), "--no-model", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert (values["judged_by"], values["stated_bands"]) == (bands.label, [bands.label])
    assert {band["load"] for band in values["bands"] if not band["outside_map"]} <= set(bands.map.loads.tolist())
    # 1300 r/min at about 600 N·m: in no published band, and in one of the map.
    assert sum(band["seconds"] for band in values["bands"] if band["forbidden"]) > 1.0
    assert values["detection"]["missed"] == 0


def test_a_log_without_speed_or_with_nothing_in_it(tmp_path: Path, new_log: Callable[..., Any]) -> None:
    with new_log(tmp_path / "none") as writer:
        writer.add_topic("/diagnostics", topics.DIAGNOSTIC_ARRAY)
    with pytest.raises(LogError, match="no topic 'motor/speed'"):
        analyse(tmp_path / "none", load_train())
    with new_log(tmp_path / "empty") as writer:
        for topic in (topics.MOTOR_SPEED, topics.LOAD_TORQUE):
            writer.add_topic(topic.absolute(), topic.type)
    found = analyse(tmp_path / "empty", load_train(), model=SMALL)
    assert found.dwells.count == 0
    assert found.sweep is None
    assert np.isnan(found.load)
    assert all(isinstance(table, dict) for table in tables(found).values())


def test_every_figure_has_its_numbers_as_csv(found: Analysis, tmp_path: Path) -> None:
    written = tables(found)
    paths = write_tables(written, tmp_path)
    assert {path.stem for path in paths} == set(written)
    assert {"histories", "trajectory", "regime_map", "bands", "detection", "bifurcation", "bifurcation_model"} <= set(
        written
    )
    assert {"dwell_1_portrait", "dwell_1_section", "dwell_1_order_spectrum", "dwells", "topics"} <= set(written)
    for path in paths:
        with path.open(newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        table = written[path.stem]
        assert head == list(table)
        assert {len(column) for column in table.values()} == {len(rows)}
    with (tmp_path / "bands.csv").open(encoding="utf-8") as file:
        named = list(csv.DictReader(file))
    assert [float(row["time (s)"]) for row in named] == [stay.seconds for stay in found.bands]
    assert named[-1]["to (r/min)"] == ""


def test_parquet_holds_the_same_numbers(found: Analysis, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    written = {"bands": tables(found)["bands"]}
    paths = write_tables(written, tmp_path, parquet=True)
    assert [path.suffix for path in paths] == [".csv", ".parquet"]
    table = parquet.read_table(paths[1]).to_pydict()
    assert table["time (s)"] == list(written["bands"]["time (s)"])


def test_parquet_without_pyarrow_is_refused_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(tables_module, "import_module", missing)
    with pytest.raises(LogError, match="pip install pyarrow"):
        write_tables({"a": {"x": [1]}}, tmp_path / "out", parquet=True)
    assert not (tmp_path / "out").exists()


def test_an_estimate_does_not_depend_on_how_the_drive_is_cut(train: GearTrain) -> None:
    time = 0.01 * np.arange(150)
    drive = np.column_stack([time, np.linspace(80, 100, 150), np.full(150, 600.0), np.ones(150)])
    results = []
    for parts in (1, 4):
        estimate, forces, sections = Estimate(train), [], []
        for rows in np.array_split(drive, parts):
            batch = Batch(drive=rows)
            estimate.extend(batch)
            forces.append(batch.force)
            sections.append(batch.section)
        results.append((np.concatenate(forces), np.concatenate(sections)))
    np.testing.assert_array_equal(results[0][0], results[1][0])
    np.testing.assert_array_equal(results[0][1][:, :3], results[1][1][:, :3])
    assert len(results[0][0]) == pytest.approx(1.49 / 0.02, abs=1)


def test_the_models_force_along_a_steady_drive_has_its_lines_at_the_mesh_orders(train: GearTrain) -> None:
    speed, load = 60.0, 600.0  # Ω = 0.55: period-1 of the fixed train
    response = integrate(System(train).at(speed=speed, load=load), transient=200, periods=50)
    drive = np.array([[0.0, speed, load], [5.0, speed, load]])
    time, angle, force = force_along(train, drive, response.state)
    np.testing.assert_allclose(angle, speed * time)
    unit = response.force_unit
    # The mean of s1_s2 over whole periods is the response's own, but for sampling 34 times a period.
    assert force[:, 0].mean() == pytest.approx(response.windows[0].mean * unit, rel=1e-2)
    found = order_spectrum(angle, force[:, 0], highest=60)
    strongest = found.orders[np.argsort(found.amplitude)[-1]]
    assert strongest % 17 == pytest.approx(0, abs=1 / 8)
    between = (found.orders > 3) & (np.abs(found.orders % 17 - 8.5) < 6)
    # Away from the lines there is the interpolation's error alone: steps of 1/34 of a period, kinks where teeth part.
    assert found.amplitude[between].max() < 0.005 * found.amplitude.max()


def test_a_drive_of_one_sample_gives_no_force(train: GearTrain) -> None:
    assert [len(each) for each in force_along(train, np.array([[0.0, 60.0, 600.0]]), np.zeros(24))] == [0, 0, 0]


def test_a_made_foreign_log_has_speed_and_load_alone_in_its_own_unit(generator: Any, tmp_path: Path) -> None:
    assert generator.write_foreign_log(tmp_path / "log", 4.0) == 400
    bag = Bag(tmp_path / "log")
    assert set(bag.topics) == {generator.FOREIGN_SPEED, generator.FOREIGN_LOAD}
    found = analyse(
        bag.path, load_train(), source=Source(generator.FOREIGN_SPEED, generator.FOREIGN_LOAD, None, "r/min")
    )
    assert found.provenance.estimated
    assert found.provenance.log_version is None
    # Up-down: 600 r/min after 3 s, and a dwell there.
    assert np.nanmax(found.drive.most("speed")) / RPM == pytest.approx(600, abs=15)
