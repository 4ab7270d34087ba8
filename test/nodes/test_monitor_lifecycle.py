"""The monitor as a managed node: what each transition does, what is silent when, and what cannot be."""

from pathlib import Path

import pytest
from harness import Peer, Processes
from monitored import Managed

OK, WARN, ERROR, STALE = range(4)


def told(peer: Peer) -> dict[str, int]:
    return {topic: len(messages) for topic, messages in peer.messages.items()}


def test_it_waits_to_be_told_is_silent_until_active_and_falls_silent_with_a_trip(
    processes: Processes, peer: Peer
) -> None:
    monitor = processes.node("monitor", autostart="false")
    node = Managed(peer)
    assert node.state() == "unconfigured"
    assert peer.node.count_publishers("gear_monitor/chaos_warning") == 0
    assert node.change("configure")
    assert node.state() == "inactive"
    peer.wait_for_subscriber("motor/speed")
    for _ in range(50):
        peer.drive(1800.0)
    assert node.state() == "inactive"  # an answer later than the samples
    assert not any(told(peer).values()), "an inactive monitor says nothing"

    assert node.change("activate")
    trips = peer.messages["gear_monitor/in_forbidden_band"]
    peer.wait(lambda: peer.level() == STALE and "no input yet" in peer.text(), "the first words")
    peer.drive_until(1800.0, lambda: peer.level() == ERROR and trips[-1].data, "the trip in a band")
    peer.drive_until(900.0, lambda: peer.level() == OK and not trips[-1].data, "calm")

    assert node.change("deactivate")
    peer.wait(lambda: trips[-1].data, "the trip that goes with the end of the watch")
    peer.wait(lambda: "deactivated" in peer.text(), "the last words")
    assert peer.level() == STALE
    before = told(peer)
    for _ in range(50):
        peer.drive(900.0)
    assert node.state() == "inactive"
    assert told(peer) == before

    assert node.change("activate")
    peer.drive_until(900.0, lambda: peer.level() == OK and not trips[-1].data, "OK again, from a fresh model")
    assert node.change("deactivate")
    assert node.change("cleanup")
    peer.wait(lambda: peer.node.count_publishers("gear_monitor/in_forbidden_band") == 0, "the topics to be given back")
    assert node.change("unconfigured_shutdown")
    assert node.state() == "finalized"
    assert processes.end(monitor) == 0, processes.words(monitor)


def test_a_bad_system_leaves_it_unconfigured_with_a_sentence_and_a_good_one_mends_it(
    processes: Processes, peer: Peer
) -> None:
    monitor = processes.node("monitor", autostart="false", system="/nowhere.yaml")
    node = Managed(peer)
    assert not node.change("configure")
    assert node.state() == "unconfigured"
    assert "/nowhere.yaml" in processes.words(monitor)
    assert "Traceback" not in processes.words(monitor)
    assert node.set(system="").successful
    assert node.change("configure")
    assert node.change("activate")
    peer.wait(lambda: peer.level() == STALE, "the first words")
    assert node.change("active_shutdown")
    peer.wait(lambda: "deactivated" in peer.text(), "the last words")
    assert node.state() == "finalized"
    assert processes.end(monitor) == 0, processes.words(monitor)


@pytest.mark.parametrize(
    ("map_text", "sentence"),
    [(None, "cannot be read"), (b"no map", "no regime map")],
)
def test_a_bad_map_is_one_sentence(processes: Processes, tmp_path: Path, map_text: bytes | None, sentence: str) -> None:
    path = tmp_path / "bad.npz"
    if map_text is not None:
        path.write_bytes(map_text)
    monitor = processes.node("monitor", map=path)
    assert monitor.wait(60) == 1
    words = processes.words(monitor)
    assert sentence in words
    assert str(path) in words
    assert "Traceback" not in words


def test_a_request_for_the_impossible_ends_nothing(processes: Processes, peer: Peer) -> None:
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState

    monitor = processes.node("monitor")
    peer.wait(lambda: bool(peer.warnings()), "the monitor")
    client = peer.node.create_client(ChangeState, "/gear_monitor/change_state")
    peer.wait(client.service_is_ready, "the service")
    client.call_async(ChangeState.Request(transition=Transition(id=Transition.TRANSITION_CONFIGURE)))
    peer.wait(lambda: "possible" in processes.words(monitor), "the complaint")
    assert Managed(peer).state() == "active"
    assert processes.end(monitor) == 0


def test_thresholds_change_while_it_runs_and_what_needs_a_new_model_does_not(processes: Processes, peer: Peer) -> None:
    processes.node("monitor", hold="0.0")
    node = Managed(peer)
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(1270.0, lambda: peer.level() == OK, "OK 79 r/min below a band")
    assert node.set(margin_rpm=100.0).successful
    peer.drive_until(1270.0, lambda: peer.level() == WARN, "WARN with a wider margin")
    refused = node.set(margin_rpm=40.0, hold=99.0)
    assert not refused.successful
    assert "hold" in refused.reason
    assert node.get("margin_rpm").double_value == 100.0
    refused = node.set(system="other.yaml")
    assert not refused.successful
    assert "deactivate it and clean it up first" in refused.reason
    assert node.set(margin_rpm=40.0, publish_rate=5.0, warning_rate=50.0).successful
    peer.drive_until(1270.0, lambda: peer.level() == OK, "OK again")

    def share() -> float:
        forces, warnings = (len(peer.messages[f"gear_monitor/{name}"]) for name in ("mesh_force", "chaos_warning"))
        return warnings / max(forces, 1)

    for kept in peer.messages.values():
        kept.clear()
    peer.drive_until(1270.0, lambda: len(peer.warnings()) > 100, "warnings at the new rate")
    assert share() > 3, "50 warnings to 5 forces a second; 10 to 50 before"


def test_a_map_gives_bands_that_follow_the_load(processes: Processes, peer: Peer) -> None:
    from seat_gear_dynamics.gears import load_train
    from seat_gear_dynamics.gears.units import RPM
    from seat_gear_dynamics.regimes.regime_map import RegimeMap
    from seat_gear_dynamics.sensing import MapBands, packaged_map

    train = load_train()
    with packaged_map().open("rb") as file:
        bands = MapBands(RegimeMap.load(file, train), train)
    light, heavy = 150.0, 600.0
    # Between the lower edges of the lowest bands: inside at the light load, well below every band at the heavy one.
    edges = [bands.at(load)[0].low for load in (light, heavy)]
    speed = (edges[0] + edges[1]) / 2
    assert edges[1] - speed > 60 * RPM
    assert any(band.low < speed < band.high for band in bands.at(light))
    processes.node("monitor", map="packaged")
    peer.wait_for_subscriber("motor/speed")
    trips = peer.messages["gear_monitor/in_forbidden_band"]
    peer.wait(lambda: bool(trips), "the first trip signal")
    peer.drive_until(speed / RPM, lambda: trips[-1].data, "the trip at the light load", load=light)
    said = {value.key: value.value for value in peer.warnings()[-1].values}
    assert said["bands"] == bands.label
    peer.drive_until(speed / RPM, lambda: not trips[-1].data, "its end at the heavy load", load=heavy)
