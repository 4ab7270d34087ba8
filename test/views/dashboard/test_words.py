"""The warning in words: headline and advice for each level, from values as the monitor gives them."""

from typing import Any

import pytest

from seat_gear_dynamics.views.dashboard.words import (
    SteadyCalm,
    calm_words,
    entry_words,
    motion_words,
    recorder_picture,
    warning_words,
)

COVERED = 2101.6


def said(bench: Any) -> tuple[int, str, str]:
    words = warning_words(bench.now, COVERED)
    return words.level, words.headline, words.advice


def test_before_the_monitor_speaks(bench: Any) -> None:
    level, headline, advice = said(bench)
    assert (level, headline) == (3, "Waiting for the monitor")
    assert "seat-gear monitor" in advice


def test_clear(bench: Any) -> None:
    bench.run(700)
    bench.warn(0, "700 r/min is clear of the forbidden bands")
    assert said(bench) == (0, "Clear", "Nothing to do.")
    assert warning_words(bench.now, COVERED).reason == "700 r/min is clear of the forbidden bands"


@pytest.mark.parametrize(
    ("speed", "calm", "advice"),
    [
        ("1800", "1549", "Slow down to 1549 r/min, the nearest calm speed."),
        ("2050", "2100", "Speed up to 2100 r/min, the nearest calm speed."),
        ("-1800", "-1549", "Slow down to 1549 r/min, the nearest calm speed."),
        ("unknown", "1549", "Go to 1549 r/min."),
        ("1800", "unknown", "No calm speed is known at this load: stop the drive."),
        ("1800", "nan", "No calm speed is known at this load: stop the drive."),
    ],
)
def test_inside_a_band_the_advice_is_the_way_out(bench: Any, speed: str, calm: str, advice: str) -> None:
    bench.run(1800)
    bench.warn(2, "inside", in_band=True, speed=speed, nearest=calm)
    assert said(bench) == (2, "Inside a forbidden band", advice)


def test_chaos_outside_every_band_has_a_headline_of_its_own(bench: Any) -> None:
    bench.run(1100)
    bench.warn(2, "the motion is chaotic", distance="249")
    assert said(bench)[1] == "The drive rattles"


@pytest.mark.parametrize(
    ("time", "distance", "headline", "advice"),
    [
        (
            "0.8",
            "120",
            "A forbidden band is ahead",
            "Hold the speed, or slow down to 1549 r/min, the nearest calm speed.",
        ),
        ("unknown", "30", "Close to a forbidden band", "Slow down to 1549 r/min, the nearest calm speed."),
        ("300", "30", "Close to a forbidden band", "Slow down to 1549 r/min, the nearest calm speed."),
        ("unknown", "400", "Signs of rattle", "Hold the speed, or slow down to 1549 r/min, the nearest calm speed."),
        (
            "unknown",
            "unknown",
            "Signs of rattle",
            "Hold the speed, or slow down to 1549 r/min, the nearest calm speed.",
        ),
    ],
)
def test_a_warn_says_what_builds_up(bench: Any, time: str, distance: str, headline: str, advice: str) -> None:
    bench.run(1560)
    bench.warn(1, "why", time=time, distance=distance)
    assert said(bench) == (1, headline, advice)


@pytest.mark.parametrize(
    ("time", "distance", "advice"),
    [
        ("0.8", "120", "Hold the speed."),
        ("unknown", "400", "Watch it, and leave this speed if the level becomes ERROR."),
        ("unknown", "30", "Speed up to 1560 r/min, the nearest calm speed."),
    ],
)
def test_nobody_is_sent_to_the_speed_that_he_has(bench: Any, time: str, distance: str, advice: str) -> None:
    """The alarm names the present speed as calm where only its course, or its motion, warns."""
    bench.run(1550)
    bench.warn(1, "why", time=time, distance=distance, speed="1550", nearest="1560")
    assert said(bench)[2] == advice


def test_a_warn_without_a_calm_speed_still_says_what_to_do(bench: Any) -> None:
    bench.run(1560)
    bench.warn(1, "why", time="unknown", distance="30", nearest="unknown")
    assert said(bench)[2] == "Go no closer."


def test_stale_names_the_signal_that_is_missing(bench: Any) -> None:
    bench.run(700)
    bench.warn(3, "no speed for more than 0.5 s")
    bench.now.ages["speed"] = 2.0
    assert "motor/speed" in said(bench)[2]
    bench.now.ages["speed"] = 0.0
    del bench.now.ages["load"]
    assert "load/torque" in said(bench)[2]
    bench.now.ages["load"] = 0.0
    bench.warn(3, "beyond the studied range", speed="2400")
    assert said(bench)[2] == "Nothing is known at this speed: go below 2102 r/min."
    bench.warn(3, "outside the map", speed="1000")
    assert said(bench)[2] == "Rely on no verdict until the level changes; the reason is beside."
    advice = warning_words(bench.now, COVERED, "50 to 700 N·m").advice
    assert advice == "Nothing is known at this load: keep it from 50 to 700 N·m."


def test_a_monitor_that_fell_silent_is_stale_whatever_it_said(bench: Any) -> None:
    bench.run(700)
    bench.warn(0, "clear")
    bench.now.ages["warning"] = 9.0
    words = warning_words(bench.now, COVERED)
    assert (words.level, words.headline, words.reason) == (3, "The monitor is silent", "Its last word is 9 s old.")


@pytest.mark.parametrize("level", [4, 200, -1])
def test_a_level_that_is_none_counts_as_stale(bench: Any, level: int) -> None:
    bench.run(700)
    bench.warn(level, "what")
    assert said(bench)[0] == 3


@pytest.mark.parametrize(
    ("time", "distance", "found"),
    [
        ("0.84", "100", ("in 0.8 s", 0.84)),
        ("0", "-5", ("inside now", 0.0)),
        ("unknown", "0", ("inside now", 0.0)),
        ("42", "100", ("not within 10 s", None)),
        ("unknown", "100", ("not within 10 s", None)),
        ("words", "words", ("not within 10 s", None)),
    ],
)
def test_when_a_band_is_entered(time: str, distance: str, found: tuple[str, float | None]) -> None:
    assert entry_words({"time to band (s)": time, "distance to band (r/min)": distance}) == found


def test_motion() -> None:
    assert motion_words({"regime": "periodic", "period": "2"}) == "periodic, period 2"
    assert motion_words({"regime": "chaotic", "period": "unknown"}) == "chaotic"
    assert motion_words({}) == "undecided"


@pytest.mark.parametrize(
    ("level", "calm", "found"),
    [
        (0, "1805", "this one"),
        (0, "1700", "1700 r/min"),
        (1, "1805", "1805 r/min"),
        (2, "-1549", "1549 r/min"),
        (3, "unknown", "unknown"),
    ],
)
def test_the_nearest_calm_speed_is_the_present_one_where_the_drive_is_clear(level: int, calm: str, found: str) -> None:
    # 5 r/min apart is noise of a measured speed; the alarm's margin, which parts two speeds in earnest, is 40.
    assert calm_words({"speed (r/min)": "1800", "nearest calm speed (r/min)": calm}, level) == found


def test_in_the_middle_of_a_band_the_advice_does_not_swing_with_the_noise() -> None:
    """1309 and 1399 r/min are the calm speeds about the published band 1349-1359, each the margin of 40 away."""
    calm = SteadyCalm()

    def shown(speed: float, nearest: float, band: str = "1349-1359") -> str:
        values = {"speed (r/min)": f"{speed}", "nearest calm speed (r/min)": f"{nearest}", "band (r/min)": band}
        return calm.steady(values)["nearest calm speed (r/min)"]

    assert [shown(1353, 1309), shown(1355, 1399), shown(1353, 1309)] == ["1309", "1309", "1309"]
    assert shown(1365, 1399) == "1399", "56 and 34 r/min away: nearer in earnest"
    assert shown(1353, 1309) == "1399"
    assert shown(1353, 1309, band="1340-1366") == "1309", "another band, of another load: a new word"
    assert calm.steady({}) == {}
    assert shown(1355, 1399) == "1399", "nothing is kept over a silence"
    assert shown(1360, 1405) == "1405", "on the same side the monitor's word is taken as it is"


@pytest.mark.parametrize(
    ("state", "can"),
    [
        ("recording", ["stop", "snapshot"]),
        ("paused", ["stop", "snapshot"]),
        ("stopped", ["start", "snapshot"]),
        ("failed", ["start", "snapshot"]),
        ("what a later version says", ["start", "snapshot"]),
    ],
)
def test_what_the_recorder_can_do_in_a_state(bench: Any, state: str, can: list[str]) -> None:
    bench.record(state)
    assert recorder_picture(bench.now.recorder, 0.0)["can"] == can


def test_the_recorders_facts(bench: Any) -> None:
    bench.record("recording", dropped="0", last_snapshot="/logs/run_snapshot3")
    facts = dict(recorder_picture(bench.now.recorder, 0.5)["facts"])
    assert facts["file"] == "run_0.mcap"
    assert facts["written"] == "12\u2009345"
    assert facts["last snapshot"] == "run_snapshot3"
    assert facts["disk free"] == "75.5 GB"
    assert facts["full in"] == "10 h"


@pytest.mark.parametrize(("age", "text"), [(None, "No recorder is heard."), (9.0, "No word for 9 s.")])
def test_a_recorder_that_is_silent_can_be_asked_for_nothing(bench: Any, age: float | None, text: str) -> None:
    bench.record("recording")
    picture = recorder_picture(bench.now.recorder, age)
    assert (picture["state"], picture["text"], picture["can"]) == ("unknown", text, [])
