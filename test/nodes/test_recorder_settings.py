"""Thresholds that were changed while the monitor ran stand in the recorder's log, and a replay follows them."""

from pathlib import Path

from harness import Peer, Processes
from monitored import Managed

from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.logs.analysis.rerun import rerun
from seat_gear_dynamics.logs.analysis.what_if import monitor_settings

OK, WARN = 0, 1


def test_a_changed_threshold_is_followed_by_the_replay(processes: Processes, peer: Peer, tmp_path: Path) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log, snapshot_on="never")
    peer.wait(lambda: peer.node.count_subscribers("/parameter_events") > 0, "the recorder to listen")
    processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    monitor = Managed(peer)
    # 1349 r/min begins a band: 1290 is 59 r/min from it, beyond the margin of 40, within one of 100.
    peer.drive_until(1290.0, lambda: peer.level() == OK, "a calm speed outside the margin")
    assert monitor.set(margin_rpm=100.0).successful
    peer.drive_until(1290.0, lambda: peer.level() == WARN, "the same speed inside the new margin")
    assert monitor.set(margin_rpm=40.0, hysteresis_rpm=2.0).successful
    peer.drive_until(1290.0, lambda: peer.level() == OK, "outside again")
    assert processes.end(recorder) == 0
    found = rerun(log, load_train())
    assert found.first_difference is None
    assert found.identical
    # Two sets; the start's declarations too, where the recorder knew of the monitor in time.
    assert found.setting_changes is not None
    assert found.setting_changes >= 2
    without = rerun(log, load_train(), monitor_settings({"margin_rpm": "40", "hysteresis_rpm": "4"}))
    assert without.threshold_words is not None
    assert without.equal == without.messages
