"""The dashboard as people start it, with a real monitor and a real recorder over DDS, in a real browser."""

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pytest
from harness import PATIENCE, Peer, Processes
from node_fixtures import domain_id, peer, processes

from seat_gear_dynamics.commands import main
from seat_gear_dynamics.logs.reader import Bag

__all__ = ["domain_id", "peer", "processes"]

DASHBOARD = ("-m", "seat_gear_dynamics", "dashboard")
SELECTORS = {"speed": "#dial .value"}


def started(processes: Processes, *arguments: str) -> tuple[subprocess.Popen[bytes], dict[str, Any]]:
    """Start a dashboard and return it with what it printed."""
    process = processes.start(*DASHBOARD, "--json", *arguments)
    begin = monotonic()
    while "\n" not in (said := processes.words(process)):
        assert process.poll() is None, said
        assert monotonic() - begin < PATIENCE, "no word of where the dashboard is"
        threading.Event().wait(0.05)
    return process, json.loads(said.splitlines()[0])


@contextmanager
def driven(peer: Peer, rpm: float, load: float = 600.0) -> Iterator[None]:
    """Drive in a thread of its own: a look at the page may take longer than the monitor waits for a sample."""
    done = threading.Event()

    def drive() -> None:
        while not done.wait(0.01):
            peer.drive(rpm, load)

    thread = threading.Thread(target=drive)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join(PATIENCE)


def wait_shown(page: Any, what: str, **texts: str) -> None:
    """Wait until elements, named by their ids, have these texts at one moment."""
    wanted = " && ".join(
        f"document.querySelector({json.dumps(SELECTORS.get(name, f'#{name}'))}).textContent === {json.dumps(text)}"
        for name, text in texts.items()
    )
    page.wait(wanted, what)


def test_speed_warning_and_a_snapshot_by_a_click_and_a_server_that_is_killed(
    processes: Processes, peer: Peer, page: Any, tmp_path: Path
) -> None:
    log, token = tmp_path / "run", tmp_path / "token"
    processes.node("recorder", output=log, snapshot_on="never")
    processes.node("monitor")
    dashboard, told = started(processes, "--port", "0", "--allow-control", "--token-file", str(token))
    assert token.stat().st_mode & 0o077 == 0, "nobody else may read the token"
    for topic in ("motor/speed", "load/torque"):
        peer.wait(lambda topic=topic: peer._publishers[topic].get_subscription_count() >= 3, f"all to hear {topic}")  # type: ignore[misc]
    page.size(1440, 900)
    page.open(told["url"])
    page.wait("document.body.dataset.link === 'live'", "the page to be live")
    reason = "1800 r/min is inside the forbidden band 1589-2060 r/min"
    with driven(peer, 1800.0):
        wait_shown(page, "the band", level="ERROR", headline="Inside a forbidden band", speed="1800", reason=reason)
        page.wait("document.querySelector('#wave-0').ariaLabel.includes('mean')", "forces")
        page.wait_text("#map-note", "published at 600 N·m")
        wait_shown(page, "the recorder's state", **{"recorder-word": "recording"})
        page.click("[data-press=snapshot]")
        page.wait_text("#answer", "messages in")
    folder = Path(page.text("#answer").rpartition(" in ")[2])
    assert folder == tmp_path / "run_snapshot1"
    bag = Bag(folder)
    assert bag.closed
    assert bag.topics["/motor/speed"].count > 0
    assert page.console == []

    dashboard.send_signal(signal.SIGKILL)
    dashboard.wait(PATIENCE)
    page.wait("document.body.dataset.link === 'lost'", "the loss to be shown")
    assert page.text("#lost").startswith("Connection lost at ")
    again, _ = started(processes, "--port", str(told["port"]), "--allow-control", "--token-file", str(token))
    # Both at one look: on a busy machine the page may lose the server again for a moment.
    page.wait("document.body.dataset.link === 'live' && document.querySelector('#lost').hidden", "the page to recover")
    with driven(peer, 700.0):
        wait_shown(page, "the page to move again", level="OK", headline="Clear", speed="700")
    assert processes.end(again) == 0


def test_the_bands_shown_are_those_of_the_map_that_the_monitor_goes_by(
    processes: Processes, peer: Peer, page: Any
) -> None:
    """At 300 N·m the packaged map forbids speeds that the published bands do not."""
    processes.node("monitor", map="packaged")
    _, told = started(processes, "--port", "0")
    page.open(told["url"])
    with driven(peer, 1200.0, load=300.0):
        page.wait_text("#map-note", "those of the map, at the present load")
        page.wait("document.querySelectorAll('#dial .band').length === 1", "its one band")
        wait_shown(page, "the monitor's verdict", level="ERROR", headline="Inside a forbidden band")
        page.wait("document.querySelector('#caution').hidden", "no word against the monitor's own map")


def test_sigterm_ends_it_cleanly_and_the_page_says_so(processes: Processes, page: Any) -> None:
    process, told = started(processes, "--port", "0")
    assert told["control"] is False
    assert told["token"] is None
    page.open(told["url"])
    page.wait_text("#headline", "Waiting for the monitor")
    assert processes.end(process, signal.SIGTERM) == 0
    page.wait("document.body.dataset.link === 'lost'", "the loss to be shown")
    words = processes.words(process)
    assert "Traceback" not in words
    assert len(words.splitlines()) == 1


def test_a_press_without_a_recorder_says_that_there_is_none(processes: Processes, page: Any, tmp_path: Path) -> None:
    _, told = started(processes, "--port", "0", "--allow-control")
    page.open(told["url"])
    page.wait_text("#recorder-text", "No recorder is heard.")
    page.wait("document.querySelector('#buttons').checkVisibility()", "the buttons")
    assert page.value("document.querySelectorAll('[data-press][aria-disabled=true]').length") == 3


def test_a_namespace_reaches_the_listener(processes: Processes, peer: Peer, page: Any) -> None:
    from std_msgs.msg import Float64

    from seat_gear_dynamics.gears.units import RPM

    publisher = peer.node.create_publisher(Float64, "/cell/motor/speed", 10)
    _, told = started(processes, "--port", "0", "--ros-args", "-r", "__ns:=/cell")
    page.open(told["url"])
    page.wait("document.body.dataset.link === 'live'", "the page to be live")
    peer.wait(lambda: publisher.get_subscription_count() > 0, "the dashboard to listen")

    def sent() -> bool:
        publisher.publish(Float64(data=1234 * RPM))
        return bool(page.text("#dial .value") == "1234")

    peer.wait(sent, "the page to show it")


def test_bench_serves_its_own(tmp_path: Path, domain_id: int, page: Any) -> None:
    command = [
        sys.executable,
        "-m",
        "seat_gear_dynamics",
        "bench",
        "--dashboard",
        "0",
        "--output",
        str(tmp_path / "run"),
    ]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ.copy()
    )
    try:
        assert process.stdout is not None
        url = process.stdout.readline().split()[1]
        page.open(url)
        page.wait("Number(document.querySelector('#dial .value')?.textContent) > 0", "the simulated bench's speed")
        page.wait_text("#recorder-word", "recording")
        assert page.value("document.querySelector('#buttons').checkVisibility()") is False
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == 0, errors
    assert "report:" in rest
    assert "Traceback" not in rest + errors
    assert Bag(tmp_path / "run").closed


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--host", "203.0.113.9"], "cannot listen on 203.0.113.9 port"),
        (["--map", "/nowhere.npz"], "No such file"),
        (["--system", "/nowhere.yaml"], "cannot be read"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str], domain_id: int
) -> None:
    assert main(["dashboard", "--port", "0", *arguments]) == 1
    error = capsys.readouterr().err
    assert sentence in error
    assert len(error.strip().splitlines()) == 1


def test_a_map_of_another_machine_or_none_at_all_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], train: Any
) -> None:
    from seat_gear_dynamics.motion import System
    from seat_gear_dynamics.regimes.regime_map import RegimeMap

    other = tmp_path / "other.npz"
    with other.open("wb") as file:
        RegimeMap.compute(System(train), np.array([100.0, 120.0]), [300.0], transient=2, periods=4).save(file)
    (tmp_path / "none.npz").write_bytes(b"no map")
    assert main(["dashboard", "--map", str(other)]) == 1
    assert main(["dashboard", "--map", str(tmp_path / "none.npz")]) == 1
    errors = capsys.readouterr().err
    assert "another machine" in errors
    assert "no regime map" in errors


def test_the_packaged_map_is_shown_of_the_packaged_machine_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from seat_gear_dynamics.commands.dashboard_run import Dashboard, Settings
    from seat_gear_dynamics.gears import packaged_description

    text = packaged_description().read_text(encoding="utf-8")
    own = tmp_path / "own.yaml"
    own.write_text(text.replace("backlash: {value: 20,", "backlash: {value: 30,"), encoding="utf-8")
    assert own.read_text(encoding="utf-8") != text
    packaged = Dashboard(Settings())._board.scene.description()["map"]
    assert packaged["name"].startswith("height_adjuster_map.npz, ")
    assert Dashboard(Settings(system=str(own)))._board.scene.description()["map"] is None
    assert main(["dashboard", "--map", "packaged", "--system", str(own)]) == 1
    assert "another machine" in capsys.readouterr().err


def test_a_token_file_that_holds_too_little_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "token").write_text("short\n")
    assert main(["dashboard", "--token-file", str(tmp_path / "token")]) == 1
    assert "expected at least 16" in capsys.readouterr().err


@pytest.mark.parametrize("port", ["-1", "65536", "http", "1e3", "٣"])
def test_a_port_that_is_none_is_wrong_use(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["dashboard", "--port", port])
    assert ended.value.code == 2
    assert "is no port" in capsys.readouterr().err


def test_without_aiohttp_a_sentence_says_what_to_install(domain_id: int) -> None:
    code = (
        "import sys; sys.modules['aiohttp'] = None\n"
        "from seat_gear_dynamics.commands import main; raise SystemExit(main(['dashboard', '--port', '0']))"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert ended.returncode == 1
    assert "pip install 'seat_gear_dynamics[dashboard]'" in ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1
