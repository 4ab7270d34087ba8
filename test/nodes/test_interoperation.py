"""The monitor among programs that are not this project's: plain DDS on the wire, and a bag that rosbag2 recorded."""

import json
from pathlib import Path

import numpy as np
from harness import Peer, Processes
from monitored import Health

from seat_gear_dynamics.gears import packaged_description
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.nodes.input_health import REASONS

BAG = Path(__file__).parents[2] / "bags" / "third_party_bench"
OK, WARN, ERROR = range(3)


def test_a_program_of_plain_cyclonedds_sees_warn_before_and_error_inside_a_band(
    processes: Processes, domain_id: int, tmp_path: Path
) -> None:
    # Well damped, the model is calm at every speed: what is warned of is the band, whatever the calibration.
    calm = tmp_path / "calm.yaml"
    text = packaged_description().read_text(encoding="utf-8")
    assert text.count("damping_ratio: {value: 0.07,") == 2
    calm.write_text(text.replace("damping_ratio: {value: 0.07,", "damping_ratio: {value: 0.5,"), encoding="utf-8")
    processes.node("monitor", system=calm)
    bench = processes.start(str(Path(__file__).with_name("plain_dds_bench.py")), str(domain_id))
    assert bench.wait(120) == 0, processes.words(bench)
    found = json.loads(processes.words(bench).splitlines()[-1])
    levels = [level for _, level in found["warnings"]]
    assert WARN in levels
    assert ERROR in levels
    assert levels.index(WARN) < levels.index(ERROR)
    at_warn = found["warnings"][levels.index(WARN)][0]
    at_error = found["warnings"][levels.index(ERROR)][0]
    assert 1200 < at_warn < 1349 <= at_error + 1.0
    assert set(levels[levels.index(ERROR) :]) == {ERROR}, "the dwell inside the band stays an error"
    assert found["names"] == [f"{mesh}/{s}" for mesh in ("s1_s2", "s3_s4") for s in ("mean", "min", "max", "rms")]
    assert np.isfinite([found["smallest"], found["largest"]]).all()
    assert found["largest"] > 0


def test_a_bag_recorded_by_rosbag2_gives_forces_warnings_and_a_log(
    processes: Processes, peer: Peer, tmp_path: Path
) -> None:
    log = tmp_path / "log"
    recorder = processes.node("recorder", output=log)
    monitor = processes.node("monitor")
    peer.wait(lambda: bool(peer.warnings()), "the monitor's first warning")
    player = processes.start(str(Path(__file__).with_name("play_bag.py")), str(BAG))
    peer.wait(lambda: player.poll() is not None, "the end of the bag", patience=150)
    assert player.returncode == 0, processes.words(player)
    assert processes.end(monitor) == 0
    assert processes.end(recorder) == 0

    bag = Bag(log)
    assert bag.closed
    assert bag.damage is None
    speed = bag.scalars("motor/speed")[1]
    sent = Bag(BAG).scalars("motor/speed")[1]
    assert len(speed) >= 0.99 * len(sent)
    # All that the monitor heard; on a starved machine its queue may have overwritten what waited for seconds.
    health = Health(peer)
    assert sum(health.value(f"refused, {reason}") for reason in REASONS) == 0
    assert health.value("samples accepted") >= 0.99 * health.value("speed messages") > 1000
    assert bag.topics["/gear_monitor/input"].count >= health.value("samples accepted")
    forces = bag.joint("gear_monitor/mesh_force")
    assert np.isfinite(forces.effort["s1_s2/mean"]).all()
    statuses = bag.statuses("gear_monitor/chaos_warning")
    told = [status.values["speed (r/min)"] for status in statuses]
    said = np.array([np.nan if text == "unknown" else abs(float(text)) for text in told])
    level = np.array([status.level for status in statuses])
    # Of what was published when: a busy recorder takes topics late, and not each by as much. The ramps of 200 r/min a
    # second change by 20 between two warnings; half of the warnings come with the sample that they judge.
    at = np.array([each.publish_time_ns for each in bag.messages("gear_monitor/chaos_warning")])
    sent_at = np.array([each.publish_time_ns for each in bag.messages("motor/speed")])
    measured = np.interp(at, sent_at, np.abs(speed) * 60 / (2 * np.pi))
    driven = (at > sent_at[0]) & (at < sent_at[-1])
    assert np.nanmedian(np.abs(said - measured)[driven]) < 20
    deep = driven & (said > 1700) & (said < 1950)
    assert deep.sum() > 50
    assert (level[deep] == ERROR).mean() > 0.98
    creeping = driven & (said > 1320) & (said < 1345)
    assert np.isin(level[creeping], (WARN, ERROR)).mean() > 0.9
    texts = [status.message for status, there in zip(statuses, driven & (said > 2125), strict=True) if there]
    # No band is known beyond the studied range; only the running model may still find the motion chaotic there.
    assert texts
    assert all("beyond the studied range" in text or "chaotic" in text or "holding" in text for text in texts)
