"""The trip signal does not wait for the model, nor for a timer."""

from pathlib import Path

from harness import Peer, Processes

OK, ERROR = 0, 2


def test_trip_and_warning_go_out_while_the_model_has_yet_to_move(
    processes: Processes, peer: Peer, tmp_path: Path
) -> None:
    go, program = tmp_path / "go", Path(__file__).with_name("halting_monitor.py")
    # No timer can answer: the model halts in the one thread that runs them.
    monitor = processes.start(str(program), str(go), "--ros-args", "-p", "debounce:=0.0")
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(900.0, lambda: peer.level() == OK, "OK at 900 r/min")
    fed = peer.messages["gear_monitor/input"]
    peer.drive(1800.0)
    trips = peer.messages["gear_monitor/in_forbidden_band"]
    peer.wait(lambda: trips[-1].data and peer.level() == ERROR, "trip and warning")
    assert "1800 r/min is inside the forbidden band" in peer.text()
    assert all(message.velocity[0] < 150 for message in fed), "the model has not been fed the sample"
    go.touch()
    peer.wait(lambda: fed[-1].velocity[0] > 150, "the model to move on")
    assert processes.end(monitor) == 0, processes.words(monitor)
