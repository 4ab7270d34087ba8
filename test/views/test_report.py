"""The report's picture and words, from runs made here."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.run import Flow, Run, read_run
from seat_gear_dynamics.logs.series import JointSeries, Status
from seat_gear_dynamics.views.report import level_spans, summary_lines, write_report

BAG = Path(__file__).parents[2] / "bags" / "third_party_bench"


def made() -> Run:
    time = np.linspace(0.0, 10.0, 101)
    names = [f"{mesh}/{s}" for mesh in ("s1_s2", "s3_s4") for s in ("mean", "min", "max", "rms")]
    effort = {name: np.sin(time) + i for i, name in enumerate(names)}
    return Run(
        path=Path("made"),
        duration=10.0,
        speed=(time, 150 * RPM * time),
        load=(time, np.full(101, 600.0)),
        force=JointSeries(time, (time * 1e9).astype(np.int64), {}, {}, effort),
        warnings=[Status(float(t), 0 if t < 4 else 2, "", {}) for t in range(10)],
        section=np.random.default_rng(0).normal(size=(50, 3)),
        flows=[Flow("/motor/speed", 101, 0.1, 0.1)],
        damage=None,
        software_version="0",
        system_text=None,
    )


def test_level_spans_join_equal_levels_and_leave_no_gap() -> None:
    assert level_spans(made()) == [(0.0, 4.0, 0), (4.0, 9.0, 2)]


def test_the_summary_counts_time_by_level_and_names_every_topic() -> None:
    text = "\n".join(summary_lines(made()))
    assert "OK         4.0 s" in text
    assert "ERROR      5.0 s" in text
    assert "/motor/speed" in text


@pytest.mark.parametrize("what", ["full", "foreign", "empty"])
def test_a_picture_comes_of_a_full_a_foreign_and_an_empty_run(what: str, tmp_path: Path) -> None:
    run = made()
    if what == "foreign":
        run = read_run(BAG)
        assert run.force is None
    if what == "empty":
        nothing = (np.empty(0), np.empty(0))
        run = replace(run, speed=nothing, load=nothing, force=None, warnings=[], section=np.empty((0, 3)), flows=[])
    path = tmp_path / "report.png"
    boxes = np.array([(0.0, run.duration, band.low, band.high) for band in load_train().bands])
    write_report(run, boxes, path, load_scale=0.5)
    data = path.read_bytes()
    assert data.startswith(b"\x89PNG")
    assert len(data) > 20_000
