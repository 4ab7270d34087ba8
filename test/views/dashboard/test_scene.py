"""The bands shown are those that the monitor goes by, as its warning names them."""

import json
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes.regime_map import RegimeMap
from seat_gear_dynamics.sensing import Alarm, MapBands
from seat_gear_dynamics.views.dashboard.board import Board, Cursor
from seat_gear_dynamics.views.dashboard.scene import Scene

PUBLISHED = [pytest.approx([1349, 1359]), pytest.approx([1589, 2060])]


@pytest.fixture
def found(train: GearTrain) -> RegimeMap:
    """A map that needs no computing: chaos at 1000 and 1200 r/min at 300 N·m, at 1400 and 1600 at 500."""
    rpm = np.arange(800.0, 2001.0, 200.0)
    made = RegimeMap.compute(System(train), rpm * RPM, [300.0, 500.0], transient=2, periods=4)
    chaos = np.zeros((2, len(rpm)))
    chaos[0, 1:3] = chaos[1, 3:5] = 1.0
    return made.with_chaos(chaos, 0)


@pytest.fixture
def mapped(train: GearTrain, found: RegimeMap) -> Scene:
    """A scene with that map."""
    return Scene(train, found, map_name="m.npz", map_bands=MapBands(found, train))


def by_the_map(scene: Scene) -> dict[str, str]:
    """Return what a monitor that goes by the scene's map says of its bands."""
    assert scene._map_bands is not None
    return {"bands": scene._map_bands.label}


def test_a_monitor_that_goes_by_the_map_has_its_own_bands_shown(
    train: GearTrain, found: RegimeMap, mapped: Scene
) -> None:
    alarm = Alarm(MapBands(found, train))
    for load in (300.0, 350.0, 420.0, 500.0):
        shown = mapped.shown(load, by_the_map(mapped))
        # Rounded to 0.1 r/min.
        wanted = [pytest.approx([b.low / RPM, b.high / RPM], abs=0.05) for b in alarm.source.at(load)]
        assert shown.bands == wanted
        assert shown.source == "those of the map, at the present load"
    # Chaotic nodes at 1000 and 1200 r/min: crossings half a step of 200 farther, and half a step more for safety.
    assert mapped.shown(300.0, by_the_map(mapped)).bands == [[800.0, 1400.0]]


def test_outside_the_map_nothing_is_known(mapped: Scene) -> None:
    said = by_the_map(mapped)
    assert "900 N·m is outside the map (300 to 500 N·m)" in str(mapped.shown(900.0, said).outside)
    assert mapped.shown(900.0, said).bands == mapped.shown(None, said).bands == []
    assert mapped.shown(900.0, said).loads == "300 to 500 N·m"
    assert mapped.shown(500.4, said).outside is not None, "not rounded into the map"
    assert mapped.shown(400.0, said).outside is None


@pytest.mark.parametrize("said", [{}, {"bands": "published"}, {"bands": "published", "band (r/min)": "1589-2060"}])
def test_a_monitor_that_goes_by_the_published_bands_has_them_shown_at_every_load(
    mapped: Scene, scene: Scene, said: dict[str, str]
) -> None:
    for each in (mapped, scene):
        for load in (None, 300.0, 900.0):
            shown = each.shown(load, said)
            assert shown.bands == PUBLISHED
            assert shown.source == "published at 600 N·m, held at every load"
            assert shown.outside is None


@pytest.mark.parametrize(
    ("said", "bands"),
    [
        ({"bands": "map 0123456789ab", "band (r/min)": "1230-1405"}, [[1230.0, 1405.0]]),
        ({"bands": "map 0123456789ab", "band (r/min)": "unknown"}, []),
        ({"bands": "published", "band (r/min)": "700-900"}, [[700.0, 900.0]]),
        ({"band (r/min)": "700-900"}, [[700.0, 900.0]]),
        ({"bands": "x" * 400, "band (r/min)": ".-."}, []),
        ({"bands": "?", "band (r/min)": "1.2.3-4"}, []),
        ({"bands": "?", "band (r/min)": f"{'9' * 390}-1"}, []),
    ],
)
def test_of_bands_that_the_page_does_not_have_only_what_the_monitor_says_is_shown(
    mapped: Scene, said: dict[str, str], bands: list[list[float]]
) -> None:
    shown = mapped.shown(400.0, said)
    assert shown.bands == bands
    assert "which this page was not given" in shown.source
    assert len(shown.source) < 200


def test_a_machine_without_published_bands_says_so(make_train: Any) -> None:
    from dataclasses import replace

    bare = Scene(replace(make_train(), bands=()))
    assert bare.shown(600.0, {}).bands == []
    assert bare.shown(600.0, {}).source == "none are published of this machine"


def test_the_map_contradicts_advice_that_other_bands_gave(mapped: Scene, scene: Scene) -> None:
    said = {"bands": "published"}
    assert "1100 r/min is forbidden" in str(mapped.caution(-1100.0, 300.0, said))
    assert mapped.caution(1500.0, 300.0, said) is None, "clear by the map too"
    assert mapped.caution(1100.0, 900.0, said) is None, "the map says nothing there"
    assert mapped.caution(None, 300.0, said) is mapped.caution(1100.0, None, said) is None
    assert mapped.caution(1100.0, 300.0, by_the_map(mapped)) is None, "the monitor knows"
    assert scene.caution(1100.0, 300.0, said) is None


def test_the_advised_speed_is_checked_or_the_present_one_where_it_is_clear(bench: Any, mapped: Scene) -> None:
    board = Board(mapped)

    def caution(level: int, **values: str) -> str | None:
        bench.run(1800, load=300.0)
        bench.warn(level, "why", bands="published", **values)
        board.update(bench.now, 0.0)
        return json.loads(board.frame(Cursor())[0])["now"]["caution"]  # type: ignore[no-any-return]

    assert "1100 r/min" in str(caution(2, speed="1800", nearest="1100"))
    assert "1200 r/min" in str(caution(0, speed="1200", nearest="1200"))
    assert caution(0, speed="1800", nearest="1100") is None
    assert caution(3, speed="1200", nearest="1200") is None


def test_outside_the_map_the_page_promises_nothing(bench: Any, mapped: Scene) -> None:
    """The monitor's values there are those of a source that has no bands: the present speed as calm, none ahead."""
    board = Board(mapped)
    bench.run(700, load=900.0)
    bench.warn(3, "outside", speed="700", nearest="700", time="unknown", bands=by_the_map(mapped)["bands"])
    board.update(bench.now, 0.0)
    now = json.loads(board.frame(Cursor())[0])["now"]
    assert (now["entry"], now["calm"], now["calmWords"]) == ("unknown", None, "unknown")
    assert now["advice"] == "Nothing is known at this load: keep it from 300 to 500 N·m."


def test_the_map_is_described_for_the_page(mapped: Scene, scene: Scene) -> None:
    picture = mapped.description()["map"]
    assert len(picture["codes"]) == len(picture["loads"]) == 2
    assert picture["name"] == "m.npz, the nominal machine"
    assert scene.description()["map"] is None
