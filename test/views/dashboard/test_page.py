"""The page in a real browser: what it shows, to eye, ear and keyboard, on wall, desk and phone."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

LEAST_CAP_HEIGHT = 3000 * np.tan(np.radians(16 / 60))
"""mm: capitals of 16 minutes of arc at 3 m, the least that ISO 9241-303 has for text that must be read."""
PIXEL = 531.0 / 1920
"""mm: a screen of 24 inches across, 1920 pixels wide."""
CAP = 0.7  # height of a capital by the size of the type, of the fonts that the page asks for

CONTRAST = """
(() => {
  const parse = (text) => {
    const [r, g, b, a = 1] = text.match(/[0-9.]+/g).map(Number);
    return [r, g, b, a];
  };
  const over = ([r, g, b, a], [x, y, z]) => [r * a + x * (1 - a), g * a + y * (1 - a), b * a + z * (1 - a), 1];
  const light = (c) => {
    const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    const [r, g, b] = c.slice(0, 3).map((v) => linear(v / 255));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (e) => {
    const found = [];
    for (let at = e; at; at = at.parentElement) found.unshift(parse(getComputedStyle(at).backgroundColor));
    return found.reduce((below, colour) => over(colour, below), [255, 255, 255, 1]);
  };
  const bad = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const e = node.parentElement;
    if (!node.textContent.trim() || !e.checkVisibility() || e.closest('.unseen, .skip, script, noscript')) continue;
    const style = getComputedStyle(e);
    const below = ground(e);
    const [a, b] = [light(over(parse(e.namespaceURI.endsWith('svg') ? style.fill : style.color), below)), light(below)];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const size = parseFloat(style.fontSize);
    const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    if (ratio < (large ? 3 : 4.5)) bad.push([node.textContent.trim(), ratio.toFixed(2), style.color]);
  }
  return bad;
})()
"""


@pytest.fixture
def shown(serve: Any, bench: Any, page: Any) -> Any:
    """A page that looks on a bench in a forbidden band."""
    bench.run(1800)
    bench.warn(2, "1800 r/min is inside the forbidden band 1589-2060 r/min", in_band=True)
    bench.record("recording")
    bench.status("gear_monitor: input", 0, "50 samples a second")
    bench.status("gear_monitor: solver", 1, "12 deadlines missed")
    page.size(1440, 900)
    page.open(serve().url)
    page.wait("document.body.dataset.link === 'live'", "the page to be live")
    return page


def feed(bench: Any, seconds: float = 3.0) -> None:
    """Have the bench give samples, windows and a section once."""
    t = 1_700_000_000 + np.arange(0, seconds, 0.02)
    wave = np.sin(40 * t)
    windows = np.column_stack([t, *[c + 50 * wave for c in (200, -100, 900, 300, 400, 100, 800, 450)]])
    samples = np.column_stack([t, 1e-5 * wave, 2e-3 * wave, 300 + 100 * wave, 1e-5 * wave, 2e-3 * wave, 500 + wave])
    section = np.column_stack([np.cos(t * 9), np.sin(t * 9), t])
    bench.once(windows=windows, samples=samples, section=section)


def test_it_shows_values_warning_advice_and_what_it_does_not_know(shown: Any, bench: Any) -> None:
    assert shown.text("#dial .value") == "1800"
    assert shown.text("#load") == "600"
    assert shown.text("#level") == "ERROR"
    assert shown.text("#headline") == "Inside a forbidden band"
    assert shown.text("#reason") == "1800 r/min is inside the forbidden band 1589-2060 r/min"
    assert shown.text("#advice") == "Slow down to 1549 r/min, the nearest calm speed."
    assert shown.text("#entry") == "inside now"
    assert shown.text("#motion") == "chaotic"
    assert shown.value("document.querySelector('#trip').checkVisibility()") is True
    assert shown.text("#recorder-word") == "recording"
    assert "run_0.mcap" in shown.text("#recorder-facts")
    assert "12 deadlines missed" in shown.text("#health")
    assert shown.value("document.title") == "ERROR · 1800 r/min · Seat gear bench"
    assert shown.value("document.querySelectorAll('#dial .band').length") == 2
    bench.run(-700)
    bench.warn(0, "clear", distance="649", time="4.25", probability_of_chaos="0.03")
    shown.wait_text("#level", "OK")
    shown.wait_text("#dial .direction", "backward")
    assert shown.text("#dial .value") == "700"
    assert shown.text("#entry") == "in 4.3 s" or shown.text("#entry") == "in 4.2 s"
    assert "probability of chaos" in shown.text("#values")
    assert shown.value("document.querySelector('#trip').checkVisibility()") is False
    assert shown.console == []


def test_the_needle_points_at_the_speed_and_the_bands_lie_where_they_are(shown: Any, bench: Any) -> None:
    # 240 degrees for 2200 r/min, straight up in the middle.
    turned = shown.value("document.querySelector('#dial .needle').getAttribute('transform')")
    assert float(turned[7:-1]) == pytest.approx(-120 + 240 * 1800 / 2200, abs=0.01)
    bench.run(99_999)
    shown.wait("document.querySelector('#dial .needle').getAttribute('transform') === 'rotate(120.00)'", "the stop")


def test_all_pictures_are_drawn(shown: Any, bench: Any) -> None:
    feed(bench)
    inked = """(id) => { const c = document.querySelector(id); const d = c.getContext('2d').getImageData(0, 0, c.width,
        c.height).data; let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n; }"""
    for name in ("#map", "#phase", "#section", "#wave-0 canvas", "#wave-1 canvas", "#trend-0 canvas"):
        # A canvas that has just been given its size is empty until the next frame.
        shown.wait(f"({inked})('{name}') > 500", f"ink in {name}")
    shown.wait("document.querySelector('#section').ariaLabel.includes('150 points')", "the section's description")
    shown.wait("document.querySelector('#wave-0').ariaLabel.includes('rms')", "the force's description")


def test_no_request_leaves_for_another_host_and_the_console_is_silent(shown: Any, bench: Any) -> None:
    feed(bench)
    shown.wait("Number(document.querySelector('#rate').textContent.split(' ')[0]) > 0", "a count of updates")
    hosts = {url.split("/")[2] for url in shown.requests if not url.startswith("about:")}
    assert len(shown.requests) > 10
    assert len(hosts) == 1
    assert hosts.pop().startswith("127.0.0.1:")
    assert shown.console == []


def test_what_comes_from_the_bench_is_text_and_never_markup(shown: Any, bench: Any) -> None:
    evil = "<img src=x onerror=\"document.title='owned'\"><script>document.title='owned'</script>"
    bench.warn(1, evil, regime=evil, nearest=evil, **{evil: evil})
    bench.record(evil, file=evil)
    bench.status(evil, 99, evil)
    shown.wait_text("#level", "WARN")
    shown.wait_text("#reason", "<img src=x")
    shown.wait_text("#recorder-word", "<img")
    assert shown.value("document.querySelectorAll('main img, main script').length") == 0
    assert shown.value("document.title").startswith("WARN")
    assert shown.console == []


def test_the_page_holds_its_own_policy(shown: Any) -> None:
    shown.value(
        "const s = document.createElement('script'); s.textContent = 'window.owned = 1'; document.body.append(s)"
    )
    assert shown.value("window.owned ?? 0") == 0
    shown.wait("true", "a turn of the page")
    assert any("Content Security Policy" in line for line in shown.console)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_texts_stand_out_from_their_ground(shown: Any, bench: Any, dark: bool) -> None:
    """WCAG 2.2 AA: 4.5 to 1, large type 3 to 1."""
    shown.dark(dark)
    for level in range(4):
        bench.warn(level, "why", in_band=level == 2)
        bench.record(("recording", "paused", "stopped", "failed")[level], level)
        shown.wait(f"document.querySelector('#warning').dataset.level === '{level}'", f"level {level}")
        assert shown.value(CONTRAST) == []
    bench.warn(1, "why", time="1.0")
    shown.wait("document.querySelector('#entry-key').dataset.soon === 'true'", "the entry to be soon")
    assert shown.value(CONTRAST) == []


def test_the_theme_can_be_chosen_and_is_kept(shown: Any) -> None:
    ground = "getComputedStyle(document.documentElement).backgroundColor"
    shown.dark(False)
    light = shown.value(ground)
    for name in ("light", "dark"):
        shown.click("#theme")
        shown.wait_text("#theme", name)
    dark = shown.value(ground)
    assert dark != light
    shown.do("Page.reload")
    shown.wait("document.body.dataset.link === 'live'", "the page anew")
    assert shown.value(ground) == dark
    shown.value("localStorage.clear()")


def test_what_matters_can_be_read_at_three_metres(shown: Any, bench: Any) -> None:
    shown.size(1920, 1080)
    shown.wait("innerWidth === 1920", "the size")
    scale = shown.value("document.querySelector('#dial').getScreenCTM().a")
    heights = {
        "level": shown.value("parseFloat(getComputedStyle(document.querySelector('#level')).fontSize)") * CAP * PIXEL,
        "speed": shown.value("parseFloat(getComputedStyle(document.querySelector('#dial .value')).fontSize)")
        * scale * CAP * PIXEL,
    }  # fmt: skip
    assert min(heights.values()) >= LEAST_CAP_HEIGHT, heights


@pytest.mark.parametrize(("width", "height"), [(320, 640), (390, 844), (768, 1024), (1180, 800), (1920, 1080)])
def test_nothing_is_cut_off_or_has_to_be_pushed_sideways(shown: Any, bench: Any, width: int, height: int) -> None:
    bench.warn(2, "the motion is chaotic at 1800 r/min and 600 N·m: " + "exponent and section agree " * 4, in_band=True)
    shown.size(width, height, phone=width < 500)
    shown.wait(f"innerWidth === {width}", "the size")
    shown.wait_text("#reason", "agree")
    assert shown.value("document.documentElement.scrollWidth") <= width
    over = shown.value(
        "[...document.querySelectorAll('main section, main h2, main p, main dd, main button')]"
        ".filter((e) => e.checkVisibility() && (e.getBoundingClientRect().right > innerWidth + 1"
        " || e.scrollWidth > e.clientWidth + 2 && getComputedStyle(e).display !== 'inline'))"
        ".map((e) => e.id || e.className)"
    )
    assert over == []


def test_a_phone_has_room_for_fingers(serve: Any, bench: Any, page: Any, token: str) -> None:
    bench.run(700)
    bench.record("recording")
    page.size(390, 844, ratio=2, phone=True)
    page.open(f"{serve(token=token, control=True).url}#token={token}")
    page.wait("document.querySelector('#buttons').checkVisibility()", "the buttons")
    small = page.value(
        "[...document.querySelectorAll('main button, .choice span')].map((e) => e.getBoundingClientRect())"
        ".filter((b) => b.height < 40 || b.width < 40).length"
    )
    assert small == 0
    assert page.value("parseFloat(getComputedStyle(document.body).fontSize)") >= 16


def test_a_screen_reader_finds_landmarks_names_and_no_flood(shown: Any, bench: Any) -> None:
    nodes = shown.do("Accessibility.getFullAXTree")["nodes"]
    roles: dict[str, list[str]] = {}
    for node in nodes:
        if not node["ignored"]:
            roles.setdefault(node["role"]["value"], []).append(node.get("name", {}).get("value", ""))
    for landmark in ("banner", "main", "contentinfo"):
        assert len(roles[landmark]) == 1, landmark
    assert len(roles["region"]) >= 9
    for role in ("region", "button", "radio", "image", "heading", "link"):
        assert all(roles[role]), f"a {role} without a name: {roles[role]}"
    assert shown.value("document.documentElement.lang") == "en-GB"
    names = shown.value("[...document.querySelectorAll('[id]')].map((e) => e.id)")
    assert len(names) == len(set(names))


def test_a_warning_is_read_aloud_once_and_again_only_when_it_changes_in_kind(shown: Any, bench: Any) -> None:
    assert shown.text("#say-now").startswith("ERROR: Inside a forbidden band.")
    shown.value(
        "window.told = 0; for (const id of ['say', 'say-now']) new MutationObserver(() => window.told++)"
        ".observe(document.getElementById(id), { childList: true, characterData: true, subtree: true })"
    )
    bench.run(1801)
    bench.warn(2, "1801 r/min is inside the forbidden band 1589-2060 r/min", in_band=True)
    shown.wait_text("#reason", "1801")
    assert shown.value("window.told") == 0
    bench.warn(0, "clear", distance="300")
    shown.wait_text("#level", "OK")
    shown.wait_text("#say", "OK: Clear.")
    assert shown.text("#say-now") == ""
    live = "document.getElementById('say-now').getAttribute('aria-live')"
    assert shown.value(live) == "assertive"


def test_the_page_works_with_keys_alone(serve: Any, bench: Any, page: Any, token: str) -> None:
    bench.run(700)
    bench.record("recording")
    bench.answer = (True, "482 messages in /logs/run_snapshot1")
    page.size(1440, 900)
    page.open(f"{serve(token=token, control=True).url}#token={token}")
    page.wait("document.querySelector('#buttons').checkVisibility()", "the buttons")
    page.wait("document.querySelector('[data-press=snapshot]').ariaDisabled === 'false'", "the state")
    seen: list[str] = []
    focus = "document.activeElement.dataset.press ?? (document.activeElement.id || document.activeElement.className)"
    while "snapshot" not in seen:
        page.key("Tab", 9)
        seen.append(page.value(focus))
        assert len(seen) < 30, seen
        outlined = page.value(
            "(() => { const e = document.activeElement;"
            " const seen = e.matches('[type=radio]') ? e.nextElementSibling : e;"
            " return getComputedStyle(seen).outlineStyle !== 'none'; })()"
        )
        assert outlined, f"no focus is seen on {seen[-1]}"
    assert seen[0] == "skip"
    assert "theme" in seen
    page.key("Enter", 13, "\r")
    page.wait_text("#answer", "snapshot: 482 messages in /logs/run_snapshot1")
    assert bench.pressed == ["snapshot"]
    assert page.value(focus) == "snapshot", "the focus stays where it was"


def test_stop_asks_first(serve: Any, bench: Any, page: Any, token: str) -> None:
    bench.run(700)
    bench.record("recording")
    bench.answer = (True, "stopped")
    page.size(1440, 900)
    page.open(f"{serve(token=token, control=True).url}#token={token}")
    page.wait("document.querySelector('[data-press=stop]').ariaDisabled === 'false'", "the state")
    page.click("[data-press=stop]")
    page.wait("document.querySelector('#sure').open", "the question")
    page.key("Escape", 27)
    page.wait("!document.querySelector('#sure').open", "the question to go")
    assert bench.pressed == []
    page.click("[data-press=stop]")
    page.wait("document.querySelector('#sure').open", "the question")
    page.click("#sure [value=stop]")
    page.wait_text("#answer", "stop: stopped")
    assert bench.pressed == ["stop"]


def test_a_button_that_cannot_be_pressed_now_presses_nothing(
    serve: Any, bench: Any, page: Any, loop: Any, token: str
) -> None:
    bench.run(700)
    bench.record("recording")
    page.open(f"{serve(token=token, control=True).url}#token={token}")
    page.wait("document.querySelector('[data-press=start]').ariaDisabled === 'true'", "the state")
    page.click("[data-press=start]")
    bench.answer = (False, "the disk is full")
    page.click("[data-press=snapshot]")
    page.wait_text("#answer", "snapshot: not done, the disk is full")
    assert bench.pressed == ["snapshot"]


def test_a_page_that_may_only_watch_has_no_buttons_and_says_why(shown: Any) -> None:
    assert shown.value("document.querySelector('#buttons').checkVisibility()") is False
    assert "--allow-control" in shown.text("#read-only")


def test_the_token_is_asked_for_and_does_not_stay_in_the_address(serve: Any, bench: Any, page: Any, token: str) -> None:
    served = serve("0.0.0.0", token=token)
    bench.run(700)
    page.open(served.url)
    page.wait("document.querySelector('#door').checkVisibility()", "the door")
    assert page.value("document.querySelector('#main').checkVisibility()") is False
    assert page.value("document.activeElement.id") == "token"
    for letter in token:
        page.do("Input.insertText", text=letter)
    page.key("Enter", 13, "\r")
    page.wait("document.body.dataset.link === 'live'", "the page to be live")
    page.open("about:blank")
    page.open(f"{served.url}#token={token}")
    page.wait("document.body.dataset.link === 'live'", "the page to be live")
    assert token not in page.value("location.href")
    assert not any(token in url for url in page.requests if "#" not in url)


def test_a_connection_that_stands_but_says_nothing_is_shown_as_lost(serve: Any, bench: Any, page: Any) -> None:
    served = serve()
    bench.run(1800)
    page.open(served.url)
    page.wait("document.body.dataset.link === 'live'", "the page to be live")
    bench.fault = RuntimeError("no more ticks, but the connection stands")
    page.wait("document.body.dataset.link === 'lost'", "the loss to be shown")
    assert "What is shown is old" in page.text("#lost")
    assert page.text("#level") == "LOST", "an old verdict cannot be read from afar"
    assert "STALE" in page.text("#reason") or "ERROR" in page.text("#reason")
    assert page.value("document.title").startswith("No connection")
    assert page.value("document.querySelector('#lost').getAttribute('role')") == "alert"


def test_words_that_come_late_find_their_place(serve: Any, bench: Any, page: Any) -> None:
    page.open(serve().url)
    page.wait("document.querySelector('#no-health').checkVisibility()", "an empty bench")
    page.wait_text("#headline", "Waiting for the monitor")
    bench.run(700)
    bench.warn(0, "clear", distance="300")
    bench.status("gear_monitor: input", 0, "50 samples a second")
    bench.record("recording")
    feed(bench)
    page.wait_text("#health", "50 samples a second")
    page.wait("document.querySelector('#dial .value').textContent === '700'", "the speed")
    bench.say(health=(), recorder=None, warning=None, speed=None, ages={})
    page.wait("document.querySelector('#no-health').checkVisibility()", "an empty bench again")
    page.wait("document.querySelector('#dial .value').textContent === '–'", "no speed")
    assert page.console == []


def test_a_page_with_a_fault_does_not_look_alive(shown: Any, bench: Any) -> None:
    shown.value("document.querySelector('#headline').remove()")
    shown.wait("document.body.dataset.link === 'lost'", "the fault to be shown")
    assert "fault" in shown.text("#lost")


def test_what_fell_silent_is_shown_as_old(shown: Any, bench: Any) -> None:
    bench.now.ages.update(mesh=5.0, warning=9.0)
    shown.wait_text("#headline", "The monitor is silent")
    shown.wait("document.querySelector('.f1').dataset.old === 'true'", "the forces to be old")
    assert shown.value("document.querySelector('.speed').dataset.old") == "false"
    assert shown.value("document.querySelector('#trip').checkVisibility()") is False


def test_the_colours_are_those_of_every_view() -> None:
    from seat_gear_dynamics.views.colours import BAND, LEVEL_COLOURS, MESH_COLOURS
    from seat_gear_dynamics.views.dashboard.page import read_page
    from seat_gear_dynamics.views.figures.style import REGIME_COLOURS

    style = read_page()["/style.css"].body.decode()
    dark = read_page()["/dark.css"].body.decode()
    wanted = {f"level-{i}": colour for i, colour in enumerate(LEVEL_COLOURS)}
    wanted |= {f"mesh-{i}": colour for i, colour in enumerate(MESH_COLOURS)}
    wanted |= {f"regime-{name}": colour for name, colour in REGIME_COLOURS.items()}
    for name, colour in (wanted | {"band": BAND}).items():
        assert f"--{name}: {colour};" in style, name
    for name in {*wanted, "band"} - {"mesh-0"}:  # whose blue is too dark on a dark ground
        assert f"--{name}:" not in dark, name


def test_the_persons_wish_and_the_systems_give_the_same_dark_theme(shown: Any) -> None:
    colours = (
        "['ground', 'panel', 'ink', 'mesh-0', 'trail-rim'].map("
        "(name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim())"
    )
    found = {}
    for system in (False, True):
        shown.dark(system)
        for chosen in ("auto", "light", "dark"):
            shown.wait_text("#theme", chosen)
            found[system, chosen] = shown.value(colours)
            assert shown.value("getComputedStyle(document.documentElement).colorScheme") == (
                "dark" if chosen == "dark" or (system and chosen == "auto") else "light"
            )
            shown.click("#theme")
    light, dark = found[False, "auto"], found[True, "auto"]
    assert light != dark
    assert found[False, "light"] == found[True, "light"] == light
    assert found[False, "dark"] == found[True, "dark"] == dark
    shown.value("localStorage.clear()")


def test_pictures_in_the_docs_are_small() -> None:
    folder = Path(__file__).parents[3] / "docs" / "pictures"
    pictures = sorted(folder.glob("dashboard-*.png"))
    assert len(pictures) >= 5
    for picture in pictures:
        assert picture.stat().st_size < 150_000, picture.name


def test_a_map_is_drawn_under_the_point_with_its_regimes_named(
    serve: Callable[..., Any], bench: Any, page: Any, train: Any
) -> None:
    from seat_gear_dynamics.motion import System
    from seat_gear_dynamics.regimes.regime_map import RegimeMap
    from seat_gear_dynamics.sensing import MapBands
    from seat_gear_dynamics.views.dashboard.scene import Scene

    rpm = np.arange(800.0, 2001.0, 200.0)
    found = RegimeMap.compute(System(train), rpm * np.pi / 30, [300.0, 700.0], transient=20, periods=40)
    bench.run(1800, load=500.0)
    page.size(1440, 900)
    bands = MapBands(found, train)
    bench.warn(0, "clear", distance="300", bands=bands.label)
    page.open(serve(scene=Scene(train, found, map_name="mine.npz", map_bands=bands)).url)
    page.wait_text("#map-note", "mine.npz")
    names = set(page.value("[...document.querySelectorAll('#map-legend .key')].map((e) => e.textContent)"))
    present = {("periodic", "quasi-periodic", "chaotic", "undecided")[code] for code in np.unique(found.codes)}
    assert names == present | {"forbidden at the present load"}
    page.wait("document.querySelector('#map').ariaLabel.includes('1800 r/min, 500 N·m')", "the point in words")
    bench.run(1800, load=900.0)
    page.wait("document.querySelector('#map').ariaLabel.includes('outside the map')", "the end of the map in words")
    assert json.loads(page.value("JSON.stringify([...document.querySelectorAll('#dial .band')])")) == []
    assert page.console == []


def test_where_the_map_forbids_what_the_monitor_advises_the_page_says_so(
    serve: Callable[..., Any], bench: Any, page: Any, train: Any
) -> None:
    from seat_gear_dynamics.motion import System
    from seat_gear_dynamics.regimes.regime_map import RegimeMap
    from seat_gear_dynamics.sensing import MapBands
    from seat_gear_dynamics.views.dashboard.scene import Scene

    rpm = np.arange(800.0, 2001.0, 200.0)
    made = RegimeMap.compute(System(train), rpm * np.pi / 30, [300.0, 700.0], transient=2, periods=4)
    found = made.with_chaos(np.ones((2, len(rpm))), 24)
    bands = MapBands(found, train)
    bench.run(1800, load=500.0)
    bench.warn(2, "inside", in_band=True, bands="published")
    page.size(1440, 900)
    page.open(serve(scene=Scene(train, found, map_name="mine.npz", map_bands=bands)).url)
    page.wait_text("#caution", "By the map shown, 1549 r/min is forbidden")
    assert page.text("#advice") == "Slow down to 1549 r/min, the nearest calm speed."
    assert page.value(CONTRAST) == []
    page.wait("document.querySelectorAll('#dial .band').length === 2", "the published bands, which the monitor goes by")
    bench.warn(2, "inside", in_band=True, bands=bands.label)
    page.wait("document.querySelector('#caution').hidden", "no caution where the monitor goes by the map")
    page.wait("document.querySelectorAll('#dial .band').length === 1", "the map's band")
    bench.warn(2, "inside", in_band=True, bands="map <b>0123</b>", band="1700-1900")
    page.wait_text("#map-note", "(map <b>0123</b>), which this page was not given")
    page.wait("document.querySelector('#dial').ariaLabel.includes('1700 to 1900')", "the one band that is known")
    assert page.console == []
