"""The dashboard as people start it, with a real monitor and a real recorder over DDS, in a real browser."""

import json
import os
import signal
import subprocess
import sys
import threading
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


def started(processes: Processes, *arguments: str) -> tuple[subprocess.Popen[bytes], dict[str, Any]]:
    """Start a dashboard and return it with what it printed."""
    process = processes.start(*DASHBOARD, "--json", *arguments)
    begin = monotonic()
    while "\n" not in (said := processes.words(process)):
        assert process.poll() is None, said
        assert monotonic() - begin < PATIENCE, "no word of where the dashboard is"
        threading.Event().wait(0.05)
    return process, json.loads(said.splitlines()[0])


def shown(page: Any) -> list[str]:
    """Return level, headline, speed and reason as they stand at one moment."""
    names = json.dumps(["#level", "#headline", "#dial .value", "#reason"])
    return list(page.value(f"{names}.map((name) => document.querySelector(name).textContent)"))


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
    # All at one look: a bench that is not driven for half a second is STALE.
    wanted = ["ERROR", "Inside a forbidden band", "1800", "1800 r/min is inside the forbidden band 1589-2060 r/min"]
    peer.drive_until(1800.0, lambda: shown(page) == wanted, "the page to show the band")
    peer.drive_until(1800.0, lambda: "mean" in page.value("document.querySelector('#wave-0').ariaLabel"), "forces")
    peer.drive_until(1800.0, lambda: page.text("#recorder-word") == "recording", "the recorder's state")
    page.click("[data-press=snapshot]")
    peer.drive_until(1800.0, lambda: "messages in" in page.text("#answer"), "the recorder's answer")
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
    page.wait("document.body.dataset.link === 'live'", "the page to recover by itself")
    assert page.value("document.querySelector('#lost').hidden") is True
    peer.drive_until(700.0, lambda: shown(page)[:3] == ["OK", "Clear", "700"], "the page to move again")
    assert processes.end(again) == 0


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
