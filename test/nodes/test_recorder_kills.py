"""The recorder process killed at random moments: what it said was written is there, in order, and no more is claimed.

Eight kills by default; SEAT_GEAR_KILLS gives another number, SEAT_GEAR_KILLS_REPORT a file for the figures.
"""

import json
import os
import random
import signal
import struct
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic, time_ns

import pytest
import yaml
from harness import Peer, Processes

from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag

KILLS = int(os.environ.get("SEAT_GEAR_KILLS", "8"))
REPORT = os.environ.get("SEAT_GEAR_KILLS_REPORT", "")
AT_ONCE = 4
LONGEST = 3.0  # s that a recorder lives at most once its log is there
TOPIC = "/flow/count"

# Publishes 0, 1, 2 … a thousand times a second until it is ended.
PUBLISHER = """
import seat_gear_dynamics.nodes
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64
from time import monotonic, sleep
rclpy.init(args=[])
publisher = Node("flow").create_publisher(Float64, "/flow/count", QoSProfile(depth=10_000))
begin, k = monotonic(), 0
while True:
    publisher.publish(Float64(data=float(k)))
    k += 1
    if (ahead := begin + k / 1000 - monotonic()) > 0:
        sleep(ahead)
"""


@dataclass
class Life:
    """One recorder: when it is to be killed, and what it had said until then."""

    log: Path
    process: subprocess.Popen[bytes]
    told: int = 0
    end: float | None = None
    killed_ns: int = 0
    found: list[float] = field(default_factory=list)

    @property
    def name(self) -> str:
        return self.log.name

    def hear(self, peer: Peer) -> None:
        """Take note of how many messages it says are on the disk."""
        for array in peer.messages["/diagnostics"]:
            for status in array.status:
                if status.name == f"{self.name}: recording":
                    values = {v.key: v.value for v in status.values}
                    self.told = max(self.told, int(values.get(f"{TOPIC} written", 0)))


def live(processes: Processes, peer: Peer, folder: Path, source: random.Random, numbers: range) -> list[Life]:
    """Start recorders, and kill each at a random moment after its log has appeared."""
    limits = {"topics": TOPIC, "sync_interval": 0.1, "chunk_bytes": 4000, "split_seconds": 0.5, "snapshot_on": "never"}
    lives = []
    for number in numbers:
        log = folder / f"recorder{number}"
        process = processes.node("recorder", "-r", f"__node:={log.name}", output=log, **limits)
        lives.append(Life(log, process))

    def all_dead() -> bool:
        for life in lives:
            if life.end is None and life.log.exists():
                life.end = monotonic() + source.uniform(0.0, LONGEST)
            if life.end is not None and not life.killed_ns and monotonic() >= life.end:
                assert life.process.poll() is None, processes.words(life.process)
                life.process.send_signal(signal.SIGKILL)
                life.killed_ns = time_ns()
                life.process.wait()
                life.hear(peer)
        return all(life.killed_ns for life in lives)

    peer.wait(all_dead, "the last of the recorders to be killed")
    peer.messages["/diagnostics"].clear()
    return lives


def claimed(log: Path) -> int:
    path = log / "metadata.yaml"
    return int(yaml.safe_load(path.read_text())["rosbag2_bagfile_information"]["message_count"]) if path.exists() else 0


def check(life: Life) -> float | None:
    """Hold a log against what its recorder said; return the s by which it ends before the kill, None without any."""
    try:
        bag = Bag(life.log)
    except LogError:  # killed before its beginning was on the disk
        assert life.told == 0
        return None
    messages = list(bag.messages())
    life.found = [struct.unpack_from("<d", message.data, 4)[0] for message in messages]
    assert life.found == [life.found[0] + k for k in range(len(life.found))] if life.found else True
    assert max(life.told, claimed(life.log)) <= len(life.found)
    return (life.killed_ns - messages[-1].log_time_ns) * 1e-9 if messages else None


@pytest.fixture
def flow(processes: Processes) -> Iterator[None]:
    process = processes.start("-c", PUBLISHER)
    yield
    process.kill()
    process.wait()


@pytest.mark.timeout(120 + 15 * KILLS)
@pytest.mark.usefixtures("flow")
def test_a_node_killed_at_any_moment_leaves_what_it_said_was_written(
    processes: Processes, peer: Peer, tmp_path: Path
) -> None:
    source = random.Random(6)
    lives: list[Life] = []
    for first in range(0, KILLS, AT_ONCE):
        lives += live(processes, peer, tmp_path, source, range(first, min(first + AT_ONCE, KILLS)))
    missing = [check(life) for life in lives]
    held = [life for life in lives if life.found]
    # Most live long enough for a first sync a tenth of a second after their beginning.
    assert len(held) > KILLS // 4
    assert any(life.told > 0 for life in held)
    if REPORT:
        figures = {
            "kills": KILLS,
            "logs_with_messages": len(held),
            "had_told": sum(life.told > 0 for life in lives),
            "messages": sum(len(life.found) for life in lives),
            "seconds_before_the_kill": sorted(s for s in missing if s is not None),
        }
        Path(REPORT).write_text(json.dumps(figures))
