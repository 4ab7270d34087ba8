"""What the recorder costs: `python benchmarks/recorder.py` prints one JSON object, its ratios within one run.

- `library_*`: the mcap library's own bare write loop, 12 topics of Float64, zstd, no sync: the measuring rod.
- `writer_over_library`: `BagWriter` with its syncs once a second of log time, over that loop, with the library's level
  of zstd; `presets`: the same for each preset, and bytes on disk a message.
- `recording_over_library`: the node's whole path behind the callback, with ring and counts, preset zstd_fast.
- `node`: the recorder as a process with 12 topics at `--rate` messages a second each for `--seconds`, published by
  another process over DDS: sent, written, lost, the share of one core that the recorder took, bytes on disk a second.
- `burst`: the recorder fed as fast as a publisher can: what it wrote a second while the publisher ran too.
- `ceiling_messages_per_processor_second`: what a core of its own could take, from the steady run; over the library's
  loop as `ceiling_over_library`. The node receives over DDS and calls back in Python, which the bare loop does not.
"""

import argparse
import json
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from mcap.writer import CompressionType, Writer

from seat_gear_dynamics.logs.presets import DEFAULT_LEVEL, PRESETS, Preset
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.recording import Recording
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.topics import FLOAT64, Qos
from seat_gear_dynamics.logs.writer import BagWriter

TOPICS = [f"/flow/t{i}" for i in range(12)]
COUNT = 240_000  # messages of a write loop: 20 s of the rate that is asked for
DATA = b"\0\1\0\0" + struct.pack("<d", 1.25)
STEP_NS = 83_333
MOST_BURST = 60_000

# Publishes at a steady rate by the clock, or one burst as fast as it can; prints when it begins and the s that it took.
PUBLISHER = """
import sys
from time import monotonic, sleep
import seat_gear_dynamics.nodes
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Float64
names, rate, count = sys.argv[1].split(","), float(sys.argv[2]), int(sys.argv[3])
rclpy.init(args=[])
node = Node("flow")
taken = []

def on_diagnostics(array):
    taken.extend(int(v.value) for s in array.status for v in s.values if v.key == "received")

node.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, 10)
publishers = [node.create_publisher(Float64, name, QoSProfile(depth=10_000)) for name in names]
while any(p.get_subscription_count() == 0 for p in publishers):
    rclpy.spin_once(node, timeout_sec=0.05)
print("begin", flush=True)
begin = monotonic()
for k in range(count):
    if rate and (wait := begin + k / rate - monotonic()) > 0:
        sleep(wait)
    for publisher in publishers:
        publisher.publish(Float64(data=float(k)))
spent = monotonic() - begin
for publisher in publishers:
    publisher.wait_for_all_acked()
# What has reached the recorder's queue is acknowledged; it counts once the recorder has taken it from there.
taken.clear()
while not taken or (taken[-1] < count * len(names) and taken[-3:] != taken[-1:] * 3):
    rclpy.spin_once(node, timeout_sec=0.05)
print(spent, flush=True)
node.destroy_node()
rclpy.try_shutdown()
"""


def timed(action: Callable[[], object]) -> tuple[float, float]:
    """Return messages a second of wall and of processor time of a loop of COUNT messages."""
    wall, processor = perf_counter(), process_time()
    action()
    return COUNT / (perf_counter() - wall), COUNT / (process_time() - processor)


def library_loop(folder: Path) -> None:
    """Write with the mcap library alone."""
    with (folder / "bare.mcap").open("wb") as file:
        writer: Any = Writer(file, chunk_size=1_000_000, compression=CompressionType.ZSTD)
        writer.start("ros2", "bare")
        text = schema(FLOAT64).text.encode()
        kind = writer.register_schema(FLOAT64, "ros2msg", text)
        channels = [writer.register_channel(name, "cdr", kind) for name in TOPICS]
        for i in range(COUNT):
            writer.add_message(channels[i % 12], i * STEP_NS, DATA, i * STEP_NS, i)
        writer.finish()


def writer_loop(directory: Path, packing: Preset) -> None:
    """Write with the bag writer, syncs and all."""
    with BagWriter(
        directory,
        system_text="",
        system_hash="",
        software_version="0",
        compression=packing.compression,
        level=packing.level,
        chunk_size=packing.chunk_size,
    ) as log:
        for name in TOPICS:
            log.add_topic(name, FLOAT64)
        for i in range(COUNT):
            log.write(TOPICS[i % 12], DATA, i * STEP_NS, i * STEP_NS)


def preset_run(directory: Path, packing: Preset, library: float) -> dict[str, float]:
    """Return a preset's rate over the library's, and what a message takes on disk."""
    rate, _ = timed(lambda: writer_loop(directory, packing))
    size = sum(path.stat().st_size for path in directory.glob("*.mcap"))
    return {"over_library": rate / library, "bytes_per_message": size / COUNT}


def recording_loop(folder: Path) -> None:
    """Hand messages to a recording, as the node does."""
    directory = folder / "recording"
    make = partial(BagWriter, system_text="", system_hash="", software_version="0", level=1)
    recording = Recording(directory, make, {name: (FLOAT64, Qos()) for name in TOPICS}, ring_seconds=10.0)
    recording.start()
    for i in range(COUNT):
        recording.receive(TOPICS[i % 12], DATA, i * STEP_NS, i * STEP_NS)
    recording.stop()


def processor_seconds(pid: int) -> float:
    """Return the processor time that a process has taken so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def node_run(folder: Path, name: str, rate: float, count: int) -> dict[str, float]:
    """Run recorder and publisher; return what came of it."""
    directory = folder / name
    parameters = {"output": directory, "topics": ",".join(TOPICS), "snapshot_on": "never"}
    flags = [part for key, value in parameters.items() for part in ("-p", f"{key}:={value}")]
    module = [sys.executable, "-m", "seat_gear_dynamics.nodes.recorder", "--ros-args", *flags]
    with subprocess.Popen(module, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as recorder:
        publisher = [sys.executable, "-c", PUBLISHER, ",".join(TOPICS), str(rate), str(count)]
        with subprocess.Popen(publisher, stdout=subprocess.PIPE, text=True) as sender:
            assert sender.stdout is not None
            sender.stdout.readline()
            before = processor_seconds(recorder.pid)
            spent = float(sender.stdout.readline())
            processor = processor_seconds(recorder.pid) - before
        recorder.send_signal(signal.SIGINT)
        recorder.wait()
    bag = Bag(directory)
    written = sum(bag.topics[topic].count for topic in TOPICS if topic in bag.topics)
    recorded = (bag.end_ns - bag.start_ns) * 1e-9
    size = sum(path.stat().st_size for path in bag.files)
    sent = 12 * count
    return {
        "sent": sent,
        "written": written,
        "lost": sent - written,
        "sent_per_second": sent / spent,
        "written_per_second": written / recorded,
        "recorder_share_of_a_core": processor / recorded,
        "bytes_on_disk_per_second": size / recorded,
        "bytes_on_disk_per_message": size / max(written, 1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=1000.0, help="messages a second on each of 12 topics")
    arguments = parser.parse_args()
    os.environ["ROS_DOMAIN_ID"] = str(random.SystemRandom().randrange(1, 200))
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        library = timed(lambda: library_loop(folder))
        presets = {name: preset_run(folder / name, packing, library[0]) for name, packing in PRESETS.items()}
        whole = timed(lambda: recording_loop(folder))
        ours = timed(lambda: writer_loop(folder / "ours", Preset("zstd", DEFAULT_LEVEL, 1_000_000)))
        steady = node_run(folder, "steady", arguments.rate, int(arguments.rate * arguments.seconds))
        burst = node_run(folder, "burst", 0.0, MOST_BURST // 12)
    ceiling = steady["written_per_second"] / steady["recorder_share_of_a_core"]
    print(
        json.dumps(
            {
                "library_messages_per_second": library[0],
                "library_messages_per_processor_second": library[1],
                "writer_over_library": ours[0] / library[0],
                "writer_over_library_processor": ours[1] / library[1],
                "presets": presets,
                "recording_over_library": whole[0] / library[0],
                "recording_over_library_processor": whole[1] / library[1],
                "node": steady,
                "burst": burst,
                "ceiling_messages_per_processor_second": ceiling,
                "ceiling_over_library": ceiling / library[1],
            }
        )
    )


if __name__ == "__main__":
    main()
