"""The report of an analysis: one file that asks nobody for anything, every figure, honest about what is missing."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis, ModelSettings, analyse
from seat_gear_dynamics.logs.analysis.tables import tables
from seat_gear_dynamics.regimes import RegimeMap
from seat_gear_dynamics.sensing import MapBands, packaged_map
from seat_gear_dynamics.views.analysis import figures, page, summary, summary_lines
from seat_gear_dynamics.views.analysis.page import Picture
from seat_gear_dynamics.views.analysis.words import stretch_words
from seat_gear_dynamics.views.figures.style import save

ROOT = Path(__file__).parents[2]
SMALL = ModelSettings(dwells=2, sweep_points=3, map_speeds=3, transient=20, periods=50)
VOID = {"meta", "img", "br", "link"}


class Outline(HTMLParser):
    """Checks that tags are closed in order and keeps what points elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.pointers: list[str] = []
        self.ids: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.pointers += [value or "" for key, value in attrs if key in ("src", "href", "srcset", "action")]
        self.ids += [value or "" for key, value in attrs if key == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def found() -> Analysis:
    return analyse(ROOT / "bags" / "bench_dwell", load_train(), model=SMALL)


@pytest.fixture(scope="module")
def pictures(found: Analysis, tmp_path_factory: pytest.TempPathFactory) -> list[Picture]:
    folder = tmp_path_factory.mktemp("figures")
    written = []
    for drawn in figures(found):
        path = folder / f"{drawn.name}.png"
        save(drawn.figure, path)
        written.append(Picture(path, drawn.section, drawn.caption, drawn.tables))
    return written


def test_the_page_is_whole_and_asks_no_host(found: Analysis, pictures: list[Picture]) -> None:
    text = page(found, pictures, version="1.2.3")
    outline = Outline()
    outline.feed(text)
    assert outline.open == []
    assert not {"script", "link", "iframe"} & outline.tags
    for pointer in outline.pointers:
        assert pointer.startswith(("data:image/png;base64,", "tables/", "#")), pointer[:60]
    assert not re.search(r"url\(|@import|https?://", text.split("</style>")[0])
    anchors = [pointer[1:] for pointer in outline.pointers if pointer.startswith("#")]
    assert sorted(anchors) == sorted(outline.ids)
    assert text.count("data:image/png") == len(pictures)


def test_every_link_to_a_table_has_its_table(found: Analysis, pictures: list[Picture]) -> None:
    links = set(re.findall(r'href="tables/([^"]+)\.csv"', page(found, pictures, version="0")))
    assert links <= set(tables(found))
    assert {name for picture in pictures for name in picture.tables} == links


def test_the_page_carries_the_provenance(found: Analysis, pictures: list[Picture]) -> None:
    text = page(found, pictures, version="1.2.3")
    for _, _, digest in found.provenance.files:
        assert digest in text
    assert found.provenance.system_hash in text
    assert "1.2.3" in text
    assert "forces, section points and warnings as logged" in text
    assert "prefers-color-scheme: dark" in text


def test_names_from_a_log_cannot_break_out_of_the_page(found: Analysis) -> None:
    evil = replace(found.provenance, log=Path("<script>alert(1)</script>"), drive_topics=("/<b>",))
    text = page(replace(found, provenance=evil, damage="<i>torn</i>"), [], version="0")
    assert "<script>" not in text
    assert "<b>" not in text.replace("<b>", "", text.count('"><b>') + text.count("<div><b>"))
    assert "&lt;i&gt;torn&lt;/i&gt;" in text


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    """An analysis of a log with topics and no message."""
    from seat_gear_dynamics.logs import topics
    from seat_gear_dynamics.logs.writer import BagWriter

    path = tmp_path_factory.mktemp("bare") / "log"
    with BagWriter(path, system_text="", system_hash="", software_version="0") as writer:
        for topic in (topics.MOTOR_SPEED, topics.LOAD_TORQUE):
            writer.add_topic(topic.absolute(), topic.type)
    return analyse(path, load_train(), model=SMALL)


@pytest.fixture(scope="module")
def on_a_map() -> Analysis:
    """The analysis of a log that was recorded on the published bands, held against the packaged map."""
    train = load_train()
    with packaged_map().open("rb") as file:
        bands = MapBands(RegimeMap.load(file, train), train)
    return analyse(ROOT / "bags" / "bench_dwell", train, bands=bands)


def test_bands_that_follow_the_load_are_drawn_as_they_do(on_a_map: Analysis) -> None:
    drawn = {each.name: each for each in figures(on_a_map)}
    boxes = drawn["histories"].figure.axes[0].collections[-1].get_paths()
    load = on_a_map.drive.mean("load")
    known = [on_a_map.judged_by.at(at) for at in load[np.isfinite(load)].tolist()]
    assert len(boxes) == sum(len(bands) for bands in known) > 0
    low = min(path.vertices[:, 1].min() for path in boxes)
    assert low == pytest.approx(min(band.low for bands in known for band in bands) / RPM)
    assert len(drawn["trajectory"].figure.axes[0].collections) >= 3, "the dots, the hatch and its edge"
    names = [label.get_text() for label in drawn["bands"].figure.axes[0].get_yticklabels()]
    assert names == [stretch_words(stay) for stay in on_a_map.bands]
    assert any("(forbidden) at 600 N·m" in name for name in names)
    assert f"the bands at {on_a_map.load:.0f} N·m" in drawn["bifurcation"].caption


def test_the_page_says_by_which_bands_and_that_the_monitor_had_others(on_a_map: Analysis) -> None:
    text, label = page(on_a_map, [], version="0"), on_a_map.judged_by.label
    assert f"bands of the {label}, which follow the load" in text
    notice = f"judged by the published bands; here they are held against the bands of the {label}."
    stated = replace(on_a_map, stated_bands=("published",))
    assert notice in page(stated, [], version="0")
    assert notice in "\n".join(summary_lines(stated))
    assert "bands changed while the log ran" in page(
        replace(stated, stated_bands=("published", label)), [], version="0"
    )
    assert "judged by the bands of" not in page(replace(stated, stated_bands=(label,)), [], version="0")
    assert summary(stated)["judged_by"] == label


def test_a_map_that_is_not_here_is_asked_for(found: Analysis) -> None:
    text = "\n".join(summary_lines(replace(found, stated_bands=("map 0123",))))
    assert "give its file with --map" in text


def test_a_log_without_a_message_gives_a_page_and_figures_that_say_so(bare: Analysis, tmp_path: Path) -> None:
    for drawn in figures(bare):
        save(drawn.figure, tmp_path / f"{drawn.name}.png")
        assert (tmp_path / f"{drawn.name}.png").read_bytes().startswith(b"\x89PNG")
    assert "never stood long enough" in page(bare, [Picture(tmp_path / "bands.png", "Dwells", "", ())], version="0")
    assert not any("missed" in line or "ERROR" in line for line in summary_lines(bare)), "there is no warning at all"
    assert summary(bare)["bands"][0]["forces"]["s1_s2"]["mean"] is None


def test_figures_of_histories_and_bifurcation_show_the_analysis_own_numbers(found: Analysis) -> None:
    drawn = {each.name: each.figure for each in figures(found)}
    speed = drawn["histories"].axes[0]
    lines = [line for line in speed.lines if len(line.get_xdata()) > 50]
    assert len(lines) == 1
    assert max(lines[0].get_ydata()) == pytest.approx(1350, abs=10)
    recorded = drawn["bifurcation"].axes[0].lines[0]
    assert len(recorded.get_xdata()) == len(found.cloud.points(1))
    for name, figure in drawn.items():
        for axes in figure.axes:
            labels = axes.get_xlabel() + axes.get_ylabel()
            assert labels or not axes.has_data() or len(figure.axes) > 1, f"{name} has axes without a quantity"


def test_the_summary_counts_what_the_analysis_found(found: Analysis) -> None:
    values = summary(found)
    assert values["duration"] == found.duration
    spans = [span for span, _, _ in found.levels.spans]  # the recorder hears the first warning later than other topics
    assert sum(values["warning_time"].values()) == pytest.approx(spans[-1].end - spans[0].begin)
    assert values["detection"]["stays"] == len(found.detection.episodes) > 0
    assert values["topics"]["/gear_monitor/input"]["count"] == 810
    text = "\n".join(summary_lines(found))
    assert "1349-1359 r/min (forbidden)" in text
    assert "as logged" in text


def test_a_killed_log_without_warnings_says_both_and_calls_nothing_missed() -> None:
    found = analyse(ROOT / "bags" / "killed", load_train())
    text, words, values = page(found, [], version="0"), "\n".join(summary_lines(found)), summary(found)
    for said in (text, words):
        assert "the log has no section points and no warnings" in said
        assert "recorder was killed or still writes" in said
        assert "missed" not in said
    assert (values["closed"], values["warned"], values["detection"]) == (False, False, None)
    assert "detection" not in {drawn.name for drawn in figures(found)} | set(tables(found))


def test_the_page_says_what_the_recorder_noted() -> None:
    found = analyse(ROOT / "bags" / "split_retained", load_train())
    assert "retention let go of the first 4" in page(found, [], version="0")
    more = replace(found.provenance, notes=(("failure", "the <disk> is full"), ("lost unread of /a", "17")))
    text = page(replace(found, provenance=more), [], version="0")
    assert "ended the log early: the &lt;disk&gt; is full" in text
    assert "17 messages of /a were lost before" in text
    assert "retention" not in text
