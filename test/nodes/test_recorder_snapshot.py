"""A warning that begins is kept with what led to it, and re-simulates from the snapshot alone."""

from pathlib import Path

import pytest
from harness import Peer, Processes
from recorder_control import Control

from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.logs.analysis.rerun import rerun
from seat_gear_dynamics.logs.reader import Bag

OK, ERROR = 0, 2


@pytest.fixture
def control(peer: Peer) -> Control:
    return Control(peer)


def test_a_warning_takes_a_snapshot_that_re_simulates_bit_for_bit(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    parameters: dict[str, object] = {"output": log, "snapshot_seconds": 3.0, "snapshot_after": 0.5}
    recorder = processes.node("recorder", **parameters)
    processes.node("monitor", state_period=0.5)
    peer.wait_for_subscriber("motor/speed")
    states = peer.messages["gear_monitor/model_state"]
    peer.drive_until(900.0, lambda: len(states) > 8 and peer.level() == OK, "4 s of states at a calm speed")
    peer.drive_until(1800.0, lambda: peer.level() == ERROR, "the alarm inside a band")
    peer.drive_until(1800.0, lambda: control.values().get("snapshots") == "1", "the snapshot")
    assert processes.end(recorder) == 0
    assert "a warning began" in processes.words(recorder)
    path = tmp_path / "run_snapshot1"
    bag = Bag(path)
    assert bag.closed
    assert (bag.end_ns - bag.start_ns) * 1e-9 <= 3.0
    assert bag.topics["/gear_monitor/in_forbidden_band"].count > 0
    result = rerun(path, load_train())
    assert result.begins == "model state"
    assert result.first_difference is None
    assert result.equal == result.messages > 20
    levels = [status.level for status in bag.statuses("gear_monitor/chaos_warning")]
    assert {OK, ERROR} <= set(levels), "the snapshot shows the calm before and the event"
    # The recorder may find the monitor's forces later than its inputs: then the first window begins before the log.
    whole = rerun(log, load_train())
    assert (whole.begins, whole.first_difference) == ("first input", None)
    assert whole.equal == whole.messages > 20
