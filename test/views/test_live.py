"""The live view: what it shows in 80 by 24, and its plain form."""

import pytest
from rich.console import Console

from seat_gear_dynamics.views.live import plain_line, render
from seat_gear_dynamics.views.live_state import LiveState, MeshStatistics


def state(**changes: object) -> LiveState:
    made = LiveState("bench", ((1349.0, 1359.0), (1589.0, 2060.0)), 2200.0, 0.0166)
    for name, value in changes.items():
        setattr(made, name, value)
    return made


def shown(of: LiveState) -> list[str]:
    console = Console(width=80, height=24, record=True, file=open("/dev/null", "w"), color_system=None)  # noqa: SIM115
    console.print(render(of))
    return console.export_text().splitlines()


FULL = state(
    duration=60.0,
    elapsed=30.0,
    speed_rpm=-1354.0,
    load=600.0,
    meshes={"s1_s2": MeshStatistics(188.0, -20.0, 900.0, 250.0), "s3_s4": MeshStatistics(1.0, 2.0, 3.0, 4.0)},
    level=2,
    reason="1354 r/min is inside the forbidden band 1349-1359 r/min, and this sentence is much longer than the line is",
    in_band=True,
    details={"nearest calm speed (r/min)": "1309", "regime": "periodic", "period": "2"},
    recorder={"state": "recording", "received": "1234", "dropped": "5"},
    solver="model: 16 times real time",
)


@pytest.mark.parametrize("what", [state(), FULL], ids=["nothing heard yet", "everything at once"])
def test_it_fits_80_by_24(what: LiveState) -> None:
    lines = shown(what)
    assert len(lines) <= 23, "one line is left for the shell"
    assert max(map(len, lines)) <= 80


def test_it_shows_speed_load_forces_warning_advice_recorder_and_time_left() -> None:
    text = "\n".join(shown(FULL))
    for expected in (
        "-1354 r/min",
        "running backward",
        "600 N·m",
        "188 N",
        "900 N",
        "ERROR",
        "TRIP",
        "nearest calm speed 1309 r/min",
        "periodic, period 2",
        "5 dropped",
        "00:30 left",
        "load scale 0.0166",
    ):
        assert expected in text, expected


def test_the_marker_stands_over_the_band_that_the_speed_is_in() -> None:
    lines = shown(state(speed_rpm=1800.0))
    row = next(i for i, line in enumerate(lines) if "▼" in line)
    assert lines[row + 1][lines[row].index("▼")] == "█"
    lines = shown(state(speed_rpm=1450.0))
    row = next(i for i, line in enumerate(lines) if "▼" in line)
    assert lines[row + 1][lines[row].index("▼")] == "─"


def test_a_speed_beyond_the_scale_stays_on_it() -> None:
    assert max(map(len, shown(state(speed_rpm=99999.0)))) <= 80


def test_the_plain_line_says_the_same() -> None:
    line = plain_line(FULL)
    assert "-1354 r/min" in line
    assert "ERROR: 1354 r/min is inside" in line
    assert plain_line(state()).count("–") == 2


def test_of_a_monitor_on_a_map_the_band_it_names_is_shown_and_not_the_published_ones() -> None:
    said = {"bands": "map 0123456789ab", "band (r/min)": "700-800"}
    line = next(line for line in shown(state(details=said, speed_rpm=650.0)) if "Speed" in line)
    assert "nearest band on the map 700-800" in line
    assert "1349" not in line
    line = next(line for line in shown(state(details={"bands": "map 0123456789ab"})) if "Speed" in line)
    assert "nearest band on the map none" in line
