"""The layouts for Foxglove and PlotJuggler: every path in them is a topic and field of the contract."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.sensing.virtual_sensor import SENSOR_STATE_NAMES

ROOT = Path(__file__).parents[2]
LAYOUTS = ROOT / "config" / "layouts"
TOPICS = {topic.absolute(): topic for topic in topics.TOPICS}
# Panels of Foxglove (and of Lichtblick, whose list packages/suite-base/src/panels/index.ts is public) used here.
PANELS = {"3D", "DiagnosticStatusPanel", "DiagnosticSummary", "Indicator", "Plot", "RawMessages", "StateTransitions"}
STATISTICS = ("mean", "min", "max", "rms")
JOINTS = {
    "/gear_monitor/input": ("s1",),
    "/joint_states": ("s1",),
    "/gear_monitor/mesh_state": messages.MESHES,
    "/gear_monitor/mesh_force": tuple(f"{mesh}/{each}" for mesh in messages.MESHES for each in STATISTICS),
    "/gear_monitor/model_state": (*SENSOR_STATE_NAMES, *topics.ORIGIN_NAMES),
}
"""The names that the JointState messages of each topic carry, in their order."""


def fields(kind: str) -> dict[str, str]:
    """Return the fields of a message type, name -> type as its definition spells it."""
    own = schema(kind).text.split("=" * 80)[0]
    return {name: of for of, name in re.findall(r"^([\w/\[\]<=]+) (\w+)\s*(?:#.*)?$", own, re.MULTILINE)}


@pytest.fixture(scope="module")
def foxglove() -> Any:
    return json.loads((LAYOUTS / "foxglove_bench.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def plotjuggler() -> ElementTree.Element:
    return ElementTree.parse(LAYOUTS / "plotjuggler_bench.xml").getroot()


@pytest.fixture(scope="module")
def diagnostics() -> dict[str, set[str]]:
    """Status name -> its keys, as a recorded bench says them."""
    found: dict[str, set[str]] = {}
    for message in Bag(ROOT / "bags" / "bench_dwell").decoded(["/diagnostics"]):
        for status in message.message.status:
            found.setdefault(f"{status.hardware_id}/{status.name}", set()).update(each.key for each in status.values)
    return found


def texts(panel: dict[str, Any]) -> Iterator[str]:
    """Yield every message path and topic of a Foxglove panel."""
    yield from (panel[key] for key in ("path", "topicPath", "topicToRender") if key in panel)
    yield from (each["value"] for each in panel.get("paths", ()))
    yield from panel.get("topics", ())
    if "xAxisPath" in panel:
        yield panel["xAxisPath"]["value"]


def leaves(node: Any) -> Iterator[str]:
    """Yield the panels of a mosaic, and check its form on the way."""
    if isinstance(node, str):
        yield node
        return
    assert set(node) == {"first", "second", "direction", "splitPercentage"}
    assert node["direction"] in ("row", "column")
    assert 0 < node["splitPercentage"] < 100
    yield from leaves(node["first"])
    yield from leaves(node["second"])


def test_foxglove_places_every_panel_once_and_knows_its_kind(foxglove: Any) -> None:
    assert {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"} == set(foxglove)
    tabs = foxglove["configById"][foxglove["layout"]]["tabs"]
    placed = [panel for tab in tabs for panel in leaves(tab["layout"])]
    assert sorted([*placed, foxglove["layout"]]) == sorted(foxglove["configById"])
    assert {panel.partition("!")[0] for panel in placed} <= PANELS


def test_foxglove_has_what_the_readers_refuse_to_do_without(foxglove: Any) -> None:
    """What Lichtblick's `validateLayoutData` (packages/suite-base/src/util/layout.ts) asks of a file."""
    assert isinstance(foxglove["configById"], dict)
    assert isinstance(foxglove["globalVariables"], dict)
    assert isinstance(foxglove["userNodes"], dict)
    assert isinstance(foxglove["playbackConfig"]["speed"], (int, float))
    assert isinstance(foxglove["layout"], str)


def test_every_panel_has_its_title_in_both_programs(foxglove: Any) -> None:
    """They differ in the key: Lichtblick does not read Foxglove's."""
    for name, panel in foxglove["configById"].items():
        if not name.startswith("Tab!"):
            assert panel["foxglovePanelTitle"] == panel["lichtblickPanelTitle"] != "", name


def test_every_path_in_foxglove_is_a_field_of_its_topic(foxglove: Any) -> None:
    paths = [path for panel in foxglove["configById"].values() for path in texts(panel)]
    assert paths
    for path in paths:
        name, _, rest = path.partition(".")
        assert name in TOPICS, f"{path} is on no topic of the contract"
        if not rest:
            continue
        match = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", rest)
        assert match, f"{path} is no message path"
        kind = fields(TOPICS[name].type).get(match[1])
        assert kind is not None, f"{path}: {TOPICS[name].type} has no {match[1]}"
        assert (match[2] is None) == (not kind.endswith("[]")), f"{path}: {match[1]} is {kind}"
        if match[2] is not None:
            assert int(match[2]) < len(JOINTS[name]), path


def test_the_labels_in_foxglove_name_the_element_that_is_drawn(foxglove: Any) -> None:
    named = [
        (path["label"], JOINTS[topic][int(index)])
        for panel in foxglove["configById"].values()
        for path in panel.get("paths", ())
        for topic, index in re.findall(r"^(/gear_monitor/mesh_\w+)\.\w+\[(\d+)\]$", path["value"])
    ]
    assert len(named) >= 8 + 2
    assert all(label == element for label, element in named)


def test_every_curve_in_plotjuggler_is_a_series_that_it_makes(
    plotjuggler: ElementTree.Element, diagnostics: dict[str, set[str]]
) -> None:
    for series in curves(plotjuggler):
        name = next((each for each in TOPICS if series.startswith(f"{each}/")), "")
        assert name, f"{series} is on no topic of the contract"
        rest = series.removeprefix(f"{name}/")
        kind = TOPICS[name].type
        if kind == topics.DIAGNOSTIC_ARRAY:
            status, _, key = rest.rpartition("/")
            assert key in {"level"} | diagnostics[status], f"{series} is said by nobody"
        elif kind == topics.JOINT_STATE:
            joint, _, field = rest.rpartition("/")
            assert joint in JOINTS[name], series
            assert field in ("position", "velocity", "effort"), series
        else:
            of = fields(kind).get(rest, "")
            assert re.fullmatch(r"bool|byte|u?int\d+|float\d+", of), f"{series}: {kind} has no number {rest}"


def curves(root: ElementTree.Element) -> list[str]:
    """Return the series of every curve; those of two series give both."""
    found = []
    for curve in root.iter("curve"):
        found += [curve.attrib[key] for key in ("curve_x", "curve_y") if key in curve.attrib] or [curve.attrib["name"]]
    return found


def test_plotjuggler_splits_into_what_stands_there(plotjuggler: ElementTree.Element) -> None:
    """What its reader takes for granted: it indexes sizes and widgets by `count`, unchecked."""
    assert plotjuggler.tag == "root"
    (widget,) = plotjuggler.findall("tabbed_widget")
    assert widget.attrib == {"parent": "main_window", "name": "Main Window"}
    for tab in widget.findall("Tab"):
        assert [each.tag for each in tab] == ["Container"] * int(tab.attrib["containers"])
        assert all([each.tag for each in container] == ["DockSplitter"] for container in tab)
    for splitter in widget.iter("DockSplitter"):
        sizes = [float(size) for size in splitter.attrib["sizes"].split(";")]
        assert len(splitter) == len(sizes) == int(splitter.attrib["count"])
        assert splitter.attrib["orientation"] in ("|", "-")
        assert {each.tag for each in splitter} <= {"DockSplitter", "DockArea"}
        assert sum(sizes) == pytest.approx(1, abs=1e-5)  # six decimals are written
    for plot in widget.iter("plot"):
        assert plot.attrib["mode"] == ("XYPlot" if any("curve_x" in c.attrib for c in plot) else "TimeSeries")
        assert plot.attrib.get("style", "Lines") in ("Lines", "Dots", "LinesAndDots", "Sticks", "Steps", "StepsInv")


def test_each_topic_of_the_contract_is_shown_in_both(foxglove: Any, plotjuggler: ElementTree.Element) -> None:
    shown = {path.partition(".")[0] for panel in foxglove["configById"].values() for path in texts(panel)}
    assert set(TOPICS) == shown
    assert set(TOPICS) == {name for name in TOPICS for series in curves(plotjuggler) if series.startswith(f"{name}/")}


def test_the_names_of_the_meshes_are_those_of_the_machine() -> None:
    assert tuple(mesh.name for mesh in load_train().meshes) == messages.MESHES
