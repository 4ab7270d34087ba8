"""`seat-gear quality` and its figure: what is printed, written and drawn, and wrong use."""

import argparse
import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.commands import quality
from seat_gear_dynamics.gears import GearTrain, load_train
from seat_gear_dynamics.regimes import MapError, RegimeMap
from seat_gear_dynamics.sensing import MapBands, PublishedBands, packaged_map
from seat_gear_dynamics.studies.warning_quality.assess import Assessment
from seat_gear_dynamics.studies.warning_quality.job import band_source
from seat_gear_dynamics.studies.warning_quality.score import Tally, rates
from seat_gear_dynamics.views.figures.style import save
from seat_gear_dynamics.views.figures.warning_quality import warning_quality_figure


def parse(words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("--system")
    parser.add_argument("--json", action="store_true")
    quality.add_arguments(parser)
    return parser.parse_args(shlex.split(words))


def assessment() -> Assessment:
    label = np.arange(100) >= 50
    curves = {name: rates(np.linspace(0, 1, 100), label) for name in ("danger", "place", "motion", "map")}
    whole = Tally(runs=2, seconds=20.0, delays=[0.03, 0.05], notices=[(200.0, 0.9), (200.0, 1.1), (50.0, 1.0)])
    return Assessment(whole, {"ramp": whole}, {**curves, "ahead": curves["danger"]}, curves)


def test_two_runs_are_scored_written_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written, drawn = tmp_path / "q.json", tmp_path / "q.png"
    assert quality.run(parse(f"--runs 2 --seed 1 --workers 1 --json --output {written} --plot {drawn}")) == 0
    said = capsys.readouterr()
    assert said.err == ""
    printed = json.loads(said.out)
    assert json.loads(written.read_text(encoding="utf-8")) == printed
    assert (printed["bands"], printed["seed"], printed["whole"]["runs"]) == ("map", [1], 2)
    assert set(printed["families"]) == {"ramp", "inside"}
    assert printed["whole"]["missed"] == 0
    assert drawn.read_bytes().startswith(b"\x89PNG")


def test_the_text_names_every_score() -> None:
    values = quality._summary(parse("--seed 1 2"), assessment())
    text = "\n".join(quality._lines(values))
    for part in ("missed", "false ERROR", "WARN without cause", "on the edge", "median 0.04 s", "200 r/min/s 1.00 s"):
        assert part in text
    assert "400 r/min/s" not in text
    assert values["whole"]["false_errors_per_hour_upper_95"] == pytest.approx(2.9957 * 180, rel=1e-4)


@pytest.mark.parametrize("words", ["--runs 0", "--seed -1", "--workers 0", "--bands none", "--output q.txt"])
def test_wrong_use_ends_with_two(words: str) -> None:
    with pytest.raises(SystemExit) as ended:
        quality.run(parse(words))
    assert ended.value.code == 2


def test_sources_are_named(train: GearTrain) -> None:
    with packaged_map().open("rb") as file:
        nominal = RegimeMap.load(file)
    assert isinstance(band_source("map", load_train(), nominal), MapBands)
    assert isinstance(band_source("published", train, nominal), PublishedBands)
    with pytest.raises(MapError, match="of another machine"):
        band_source("map", train, nominal)
    with pytest.raises(ValueError, match="'none', expected map or published"):
        band_source("none", train, nominal)


def test_the_figure_has_units_on_its_axes_and_survives_a_lack_of_curves(tmp_path: Path) -> None:
    found = assessment()
    figure = warning_quality_figure(found)
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert labels[2:] == [
        "notice before entry, s (longest counted: 2)",
        "from the edge to ERROR, ms (0: it stood before)",
    ]
    assert len(figure.axes[0].get_lines()) == 6
    save(warning_quality_figure(Assessment(Tally(), {}, {}, {})), tmp_path / "empty.png")
    assert (tmp_path / "empty.png").stat().st_size > 0
