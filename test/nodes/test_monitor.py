"""The monitor as a process: what it publishes, what it refuses, how it starts and ends."""

import math
import signal
from pathlib import Path

import numpy as np
import pytest
from harness import Peer, Processes

from seat_gear_dynamics.gears.units import RPM

OK, WARN, ERROR, STALE = range(4)


def values(status: object) -> dict[str, str]:
    return {value.key: value.value for value in status.values}  # type: ignore[attr-defined]


def input_report(peer: Peer) -> dict[str, str]:
    for array in reversed(peer.messages["/diagnostics"]):
        for status in array.status:
            if status.name.endswith(": input"):
                return values(status)
    return {}


def test_it_is_stale_without_input_ok_with_it_and_stale_again_when_the_input_ends(
    processes: Processes, peer: Peer
) -> None:
    monitor = processes.node("monitor")
    peer.wait(lambda: peer.level() == STALE and "no speed received yet" in peer.text(), "the first warnings")
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(900.0, lambda: peer.level() == OK, "OK at 900 r/min")
    peer.wait(lambda: peer.level() == STALE, "STALE after the input ended")
    assert "no speed for more than 0.5 s" in peer.text()
    assert processes.end(monitor) == 0


def test_a_load_that_falls_silent_is_stale_and_stays_so_while_speeds_go_on(processes: Processes, peer: Peer) -> None:
    from std_msgs.msg import Float64

    processes.node("monitor", load_timeout=0.5)
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(900.0, lambda: peer.level() == OK, "OK at 900 r/min")

    def speed_alone() -> int | None:
        peer.publish("motor/speed", Float64(data=900 * RPM))
        return peer.level()

    peer.wait(lambda: speed_alone() == STALE, "STALE without a load")
    assert "no load for more than 0.5 s" in peer.text()
    heard = len(peer.warnings())
    peer.wait(lambda: speed_alone() is not None and len(peer.warnings()) > heard + 10, "a second of warnings")
    assert {warning.level[0] for warning in peer.warnings()[heard:]} == {STALE}
    assert int(input_report(peer)["speeds without a load"]) > 0


def test_the_trip_signal_reaches_a_late_subscriber_and_follows_the_band(processes: Processes, peer: Peer) -> None:
    processes.node("monitor")
    trips = peer.messages["gear_monitor/in_forbidden_band"]
    peer.wait(lambda: bool(trips), "the latched trip signal")
    assert trips[-1].data is False
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(1800.0, lambda: trips[-1].data, "the trip signal inside a band")
    peer.drive_until(1800.0, lambda: peer.level() == ERROR, "the warning that goes with it")
    said = values(peer.warnings()[-1])
    assert said["band (r/min)"] == "1589-2060"
    assert float(said["distance to band (r/min)"]) == pytest.approx(-211, abs=2)
    assert float(said["nearest calm speed (r/min)"]) == pytest.approx(1549, abs=2)
    peer.drive_until(900.0, lambda: not trips[-1].data, "the trip signal's end")


def test_every_output_is_published_with_the_contracts_fields(processes: Processes, peer: Peer) -> None:
    processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(900.0, lambda: all(peer.messages.values()), "every output")
    state, force = peer.messages["gear_monitor/mesh_state"][-1], peer.messages["gear_monitor/mesh_force"][-1]
    assert list(state.name) == ["s1_s2", "s3_s4"]
    assert len(state.position) == len(state.velocity) == len(state.effort) == 2
    assert list(force.name) == [f"{mesh}/{s}" for mesh in ("s1_s2", "s3_s4") for s in ("mean", "min", "max", "rms")]
    mean, low, high, rms = force.effort[:4]
    assert low <= mean <= high
    assert rms >= abs(mean)
    cloud = peer.messages["gear_monitor/poincare"][-1]
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "t"]
    assert len(cloud.data) == cloud.width * cloud.point_step
    times = np.frombuffer(bytes(cloud.data), dtype=[("xyz", "<3f4"), ("t", "<f8")])["t"]
    assert abs(times[-1] - cloud.header.stamp.sec) < 2.0, "points carry the time of the stamp's clock"
    assert np.allclose(np.diff(times), 60 / 900 / 17, rtol=0.2), "a mesh period of 17 teeth at 900 r/min apart"
    fed = peer.messages["gear_monitor/input"][-1]
    assert fed.velocity[0] == pytest.approx(900 * RPM)
    assert fed.effort[0] == 600.0
    assert fed.header.stamp.sec > 0


@pytest.mark.parametrize(
    ("speed", "load", "key"),
    [
        (math.nan, 600.0, "refused, not finite"),
        (math.inf, 600.0, "refused, not finite"),
        (100.0, math.nan, "refused, not finite"),
        (1e6, 600.0, "refused, absurd"),
        (100.0, -1e9, "refused, absurd"),
    ],
)
def test_bad_input_is_refused_counted_and_reported_and_good_input_goes_on(
    processes: Processes, peer: Peer, speed: float, load: float, key: str
) -> None:
    from std_msgs.msg import Float64

    monitor = processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(900.0, lambda: peer.level() == OK, "OK at 900 r/min")
    peer.publish("load/torque", Float64(data=load))
    peer.publish("motor/speed", Float64(data=speed))
    peer.drive_until(900.0, lambda: int(input_report(peer).get(key, "0")) > 0, f"the count of {key!r}")
    peer.drive_until(1800.0, lambda: peer.level() == ERROR, "the alarm after bad input")
    assert monitor.poll() is None


def test_joint_states_drive_it_when_asked_to(processes: Processes, peer: Peer) -> None:
    from sensor_msgs.msg import JointState

    processes.node("monitor", input="joint_states", joint="seat")
    peer.wait_for_subscriber("joint_states")
    fed = peer.messages["gear_monitor/input"]
    stamp = 100

    def send() -> bool:
        nonlocal stamp
        stamp += 1
        message = JointState(name=["other", "seat"], velocity=[1.0, 90.0], effort=[2.0, 500.0])
        message.header.stamp.sec, message.header.stamp.nanosec = stamp // 100, stamp % 100 * 10_000_000
        peer.publish("joint_states", message)
        return len(fed) > 5

    peer.wait(send, "samples from joint states")
    assert (fed[-1].velocity[0], fed[-1].effort[0]) == (90.0, 500.0)
    assert fed[-1].header.stamp.nanosec % 10_000_000 == 0, "the joint state's own stamp is used"


def test_namespace_and_remapping_apply(processes: Processes, peer: Peer) -> None:
    processes.node("monitor", "-r", "__ns:=/cell3", "-r", "motor/speed:=/drive/speed")
    expected = {"/cell3/gear_monitor/mesh_force", "/cell3/load/torque", "/drive/speed", "/diagnostics"}
    peer.wait(lambda: expected <= {name for name, _ in peer.node.get_topic_names_and_types()}, "the remapped topics")


def test_reset_is_a_service(processes: Processes, peer: Peer) -> None:
    from std_srvs.srv import Trigger

    processes.node("monitor")
    client = peer.node.create_client(Trigger, "/gear_monitor/reset")
    peer.wait(client.service_is_ready, "the reset service")
    future = client.call_async(Trigger.Request())
    peer.wait(future.done, "the answer")
    assert future.result().success


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_cleanly_on(processes: Processes, peer: Peer, number: signal.Signals) -> None:
    monitor = processes.node("monitor")
    peer.wait(lambda: bool(peer.warnings()), "the monitor")
    assert processes.end(monitor, number) == 0, processes.words(monitor)
    assert "Traceback" not in processes.words(monitor)


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"system": "/nowhere.yaml"}, "cannot be read"),
        ({"input": "bus"}, "expected 'topics' or 'joint_states'"),
        ({"publish_rate": "-5.0"}, "expected a number with a point from 1 to 1000, such as 50.0"),
        ({"publish_rate": "fast"}, "expected a number with a point from 1 to 1000, such as 50.0"),
        ({"section_points": "1.5"}, "expected a whole number from 1 to 10000, such as 256"),
    ],
)
def test_a_start_that_cannot_be_is_one_sentence(
    processes: Processes, parameters: dict[str, str], sentence: str
) -> None:
    monitor = processes.node("monitor", **parameters)
    assert monitor.wait(60) == 1
    words = processes.words(monitor)
    assert sentence in words
    assert "Traceback" not in words


def test_a_system_of_ones_own_moves_the_bands(processes: Processes, peer: Peer, tmp_path: Path) -> None:
    from seat_gear_dynamics.gears import packaged_description

    text = (
        packaged_description().read_text().replace("value: 1349,", "value: 700,").replace("value: 1359,", "value: 800,")
    )
    own = tmp_path / "own.yaml"
    own.write_text(text)
    processes.node("monitor", system=own)
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(750.0, lambda: peer.level() == ERROR, "ERROR inside the moved band")
    assert values(peer.warnings()[-1])["band (r/min)"] == "700-800"
