"""What the recorder process loses is counted, and what it has received is written before it ends."""

import signal
from pathlib import Path

import pytest
from harness import Peer, Processes
from recorder_control import Control
from ros import REAL_RCLPY

from seat_gear_dynamics.logs.reader import Bag

BURST = 5000
WARN = 1


@pytest.fixture
def control(peer: Peer) -> Control:
    return Control(peer)


def warned(peer: Peer) -> bool:
    return any(
        status.level[0] == WARN and "were overwritten before they were read" in status.message
        for array in peer.messages["/diagnostics"]
        for status in array.status
    )


@pytest.mark.skipif(REAL_RCLPY, reason="rclpy cannot tell what its queues overwrite")
def test_what_a_queue_overwrites_is_counted_in_the_file_the_diagnostics_and_the_log(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path
) -> None:
    log = tmp_path / "run"
    recorder = processes.node("recorder", output=log, queue_depth=5)
    peer.wait_for_subscriber("motor/speed")
    peer.wait_for_subscriber("load/torque")
    peer.drive(500.0)
    control.wait_received(1)
    # While the process stands still the system holds its datagrams; then they come sixty times faster than it looks.
    recorder.send_signal(signal.SIGSTOP)
    for _ in range(300):
        peer.drive(500.0)
    recorder.send_signal(signal.SIGCONT)

    def counted(topic: str) -> int:
        values = control.values()
        return int(values[f"{topic} received"]) + int(values[f"{topic} lost unread"])

    peer.wait(lambda: counted("motor/speed") == counted("load/torque") == 301, "each message to be counted")
    values = control.values()
    lost = int(values["motor/speed lost unread"])
    assert lost > 0
    assert int(values["lost unread"]) == lost + int(values["load/torque lost unread"])
    peer.wait(lambda: "lost before they were read" in processes.words(recorder), "the log to say so")
    peer.wait(lambda: warned(peer), "a status to warn of it")
    assert processes.end(recorder) == 0
    bag = Bag(log)
    assert int(bag.custom_data["lost unread of /motor/speed"]) == lost
    assert bag.topics["/motor/speed"].count == 301 - lost


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_burst_that_was_received_before_the_end_is_in_the_log(
    processes: Processes, peer: Peer, control: Control, tmp_path: Path, number: signal.Signals
) -> None:
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    log = tmp_path / "run"
    publisher = peer.node.create_publisher(Float64, "motor/speed", QoSProfile(depth=2 * BURST))
    recorder = processes.node("recorder", output=log)
    peer.wait(lambda: publisher.get_subscription_count() > 0, "the recorder to listen")
    publisher.publish(Float64(data=-1.0))
    control.wait_received(1)
    for k in range(BURST):
        publisher.publish(Float64(data=float(k)))
    # Acknowledged is what stands in the recorder's queue; that it has been read, nobody has said.
    assert publisher.wait_for_all_acked()
    assert processes.end(recorder, number) == 0, processes.words(recorder)
    bag = Bag(log)
    assert bag.closed
    assert bag.topics["/motor/speed"].count == BURST + 1
    assert "lost unread of /motor/speed" not in bag.custom_data


def test_the_datagrams_that_the_system_dropped_are_those_of_this_process() -> None:
    import socket

    from seat_gear_dynamics.nodes.recorder_datagrams import Datagrams, drops

    table = """   sl  local_address rem_address   st tx rx tr tm->when retrnsmt   uid  timeout inode ref pointer drops
  1: 00000000:1CE8 00000000:0000 07 00000000:00000000 00:00000000 00000000  0        0 77 2 0000000000000000 12
  2: 00000000:1CE9 00000000:0000 07 00000000:00000000 00:00000000 00000000  0        0 78 2 0000000000000000 30
"""
    assert drops(table, {"77"}) == 12
    assert drops(table, {"77", "78"}) == 42
    assert drops("", {"77"}) == 0
    counter = Datagrams()
    before = counter.dropped()
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as inlet,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out,
    ):
        inlet.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        inlet.bind(("127.0.0.1", 0))
        for _ in range(200):
            out.sendto(bytes(1000), inlet.getsockname())
        if not Path("/proc/self/net/udp").exists():
            pytest.skip("this system does not count dropped datagrams")
        dropped = counter.dropped() - before
        inlet.setblocking(False)
        kept = 0
        try:
            while inlet.recv(2000):
                kept += 1
        except BlockingIOError:
            pass
    assert 0 < dropped == 200 - kept
    assert counter.dropped() - before >= dropped, "a closed socket is not forgotten"
