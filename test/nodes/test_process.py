"""How a node's process ends: once told, further signals change nothing."""

import signal
from pathlib import Path

from harness import Peer, Processes
from recorder_control import Control

from seat_gear_dynamics.logs.reader import Bag


def test_signals_that_come_amid_the_end_do_not_cut_it_off(processes: Processes, peer: Peer, tmp_path: Path) -> None:
    recorder = processes.node("recorder", output=tmp_path / "run")
    control = Control(peer)
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(900.0, lambda: int(control.values().get("written", "0")) > 20, "something written")
    recorder.send_signal(signal.SIGINT)
    while recorder.poll() is None:  # as a launch file goes on, only faster
        recorder.send_signal(signal.SIGTERM)
        recorder.send_signal(signal.SIGINT)
    assert recorder.returncode == 0, processes.words(recorder)
    assert Bag(tmp_path / "run").closed
