"""What the recorder costs: `python benchmarks/recorder.py` prints one JSON object, its ratios within one run.

- `library_*`: the mcap library's own bare write loop, 12 topics of Float64, zstd, no sync: the measuring rod.
- `writer_over_library`: `BagWriter` with its syncs once a second of log time, over that loop, message by message and in
  batches as the bundled runtime gives them, with the library's level of zstd; `presets`: the same for each preset,
  message by message, and bytes on disk a message.
- `recording_over_library`: all that is behind the callback, with ring and counts, preset zstd_fast, in both ways; and
  the seconds that a snapshot of the ring takes.
- `steady`: the recorder as a process with 12 topics at `--rate` messages a second each for `--seconds`, published by
  another process over DDS: sent, written, lost, the share of one core that the recorder took and by which thread, bytes
  on disk a second.
- `flood`: the recorder fed by `--senders` processes as fast as they can: what it took a second of its processor time
  (both threads) and of the wall, while they had the same cores; what was lost, and what of it the recorder counted.
- `whole_node_over_library`: of the flood, by processor time and by the wall.
- `kills`: with `--kills N` the recorder process killed at N random moments, by the test that does so.

Loops are run three times in turn, and the best counts: other work makes them slower, never faster.
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

import numpy as np
from mcap.writer import CompressionType, Writer

from seat_gear_dynamics.logs.batch import Batch
from seat_gear_dynamics.logs.presets import DEFAULT_LEVEL, PRESETS, Preset
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.recording import Recording
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.topics import FLOAT64, Qos
from seat_gear_dynamics.logs.writer import BagWriter

ROOT = Path(__file__).resolve().parents[1]
TOPICS = [f"/flow/t{i}" for i in range(12)]
COUNT = 240_000  # messages of a write loop: 20 s of the rate that is asked for
PIECE = 240  # messages of a batch: what 12 000 a second are in a fiftieth of one
DATA = b"\0\1\0\0" + struct.pack("<d", 1.25)
STEP_NS = 83_333
ROUNDS = 3
FLOOD = 600_000  # messages of all senders
PATIENCE = 60.0  # s that a sender waits for the recorder to have taken everything

# Publishes at a steady rate by the clock, or as fast as it can; prints when it begins and the s that it took, and ends
# when the recorder's counts have ceased to grow.
PUBLISHER = """
import sys
from time import monotonic, sleep
import seat_gear_dynamics.nodes
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Float64
names, rate, count, patience = sys.argv[1].split(","), float(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4])
rclpy.init(args=[])
node = Node("flow")
taken = []

def on_diagnostics(array):
    for status in array.status:
        values = {v.key: v.value for v in status.values}
        if "lost unread" in values:
            taken.append((values["received"], values["lost unread"]))

node.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, 10)
publishers = [node.create_publisher(Float64, name, QoSProfile(depth=10_000)) for name in names]
while any(p.get_subscription_count() == 0 for p in publishers):
    rclpy.spin_once(node, timeout_sec=0.05)
before = monotonic()
while monotonic() < before + 2.0:  # the recorder has to know of these publishers, too
    rclpy.spin_once(node, timeout_sec=0.05)
message = serialize_message(Float64(data=1.25))
print("begin", flush=True)
begin = monotonic()
for k in range(count):
    if rate and (wait := begin + k / rate - monotonic()) > 0:
        sleep(wait)
    for publisher in publishers:
        publisher.publish(message)
spent = monotonic() - begin
for publisher in publishers:
    publisher.wait_for_all_acked()
# What has reached the recorder's queue is acknowledged; it counts once the recorder has taken it from there.
taken.clear()
while monotonic() < begin + spent + patience and (len(taken) < 3 or len(set(taken[-3:])) > 1):
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


def best(folder: Path, loops: dict[str, Callable[[Path], object]]) -> dict[str, tuple[float, float]]:
    """Run loops in turn, each into a new place; return each one's best rates, of wall and of processor time."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in loops}
    for k in range(ROUNDS):
        for name, loop in loops.items():
            found[name].append(timed(partial(loop, folder / f"{name}{k}")))
    return {name: (max(wall for wall, _ in rates), max(cpu for _, cpu in rates)) for name, rates in found.items()}


def library_loop(path: Path) -> None:
    """Write with the mcap library alone."""
    with path.open("wb") as file:
        writer: Any = Writer(file, chunk_size=1_000_000, compression=CompressionType.ZSTD)
        writer.start("ros2", "bare")
        text = schema(FLOAT64).text.encode()
        kind = writer.register_schema(FLOAT64, "ros2msg", text)
        channels = [writer.register_channel(name, "cdr", kind) for name in TOPICS]
        for i in range(COUNT):
            writer.add_message(channels[i % 12], i * STEP_NS, DATA, i * STEP_NS, i)
        writer.finish()


def new_writer(directory: Path, packing: Preset) -> BagWriter:
    return BagWriter(
        directory,
        system_text="",
        system_hash="",
        software_version="0",
        compression=packing.compression,
        level=packing.level,
        chunk_size=packing.chunk_size,
    )


def writer_loop(directory: Path, packing: Preset) -> None:
    """Write with the bag writer, syncs and all."""
    with new_writer(directory, packing) as log:
        for name in TOPICS:
            log.add_topic(name, FLOAT64)
        for i in range(COUNT):
            log.write(TOPICS[i % 12], DATA, i * STEP_NS, i * STEP_NS)


def batches() -> list[Batch]:
    """Return the messages of a write loop in pieces as the bundled runtime hands them over."""
    names, data = tuple(TOPICS), np.frombuffer(DATA * PIECE, np.uint8)
    place = np.arange(PIECE)
    topic, offset, size = place % 12, place * len(DATA), np.full(PIECE, len(DATA))
    times = [(first + place) * STEP_NS for first in range(0, COUNT, PIECE)]
    return [Batch(names, topic, offset, size, when, when, data.copy()) for when in times]


def writer_batches(directory: Path, packing: Preset) -> None:
    """Write the same in batches."""
    with new_writer(directory, packing) as log:
        for name in TOPICS:
            log.add_topic(name, FLOAT64)
        for batch in batches():
            log.write_batch(batch)


def preset_run(directory: Path, packing: Preset, library: float) -> dict[str, float]:
    """Return a preset's rate over the library's, and what a message takes on disk."""
    rate, _ = timed(lambda: writer_loop(directory, packing))
    size = sum(path.stat().st_size for path in directory.glob("*.mcap"))
    return {"over_library": rate / library, "bytes_per_message": size / COUNT}


def new_recording(directory: Path) -> Recording:
    make = partial(BagWriter, system_text="", system_hash="", software_version="0", level=1)
    recording = Recording(directory, make, {name: (FLOAT64, Qos()) for name in TOPICS}, ring_seconds=10.0)
    recording.start()
    return recording


def recording_loop(directory: Path) -> None:
    """Hand messages to a recording, as the node does on rclpy."""
    recording = new_recording(directory)
    for i in range(COUNT):
        recording.receive(TOPICS[i % 12], DATA, i * STEP_NS, i * STEP_NS)
    recording.stop()


def recording_batches(directory: Path) -> None:
    """Hand batches to a recording, as the node does on the bundled runtime."""
    recording = new_recording(directory)
    for batch in batches():
        recording.receive_batch(batch)
    recording.stop()


def snapshot_seconds(directory: Path) -> float:
    """Return what a snapshot of 10 s at 12 000 messages a second takes."""
    recording = new_recording(directory)
    for batch in batches():
        recording.receive_batch(batch)
    begin = perf_counter()
    recording.snapshot()
    spent = perf_counter() - begin
    recording.stop()
    return spent


def processor_seconds(pid: int) -> dict[str, float]:
    """Return the processor time that each thread of a process has taken so far, s; threads of one name together."""
    found: dict[str, float] = {}
    for task in Path(f"/proc/{pid}/task").iterdir():
        name, _, rest = (task / "stat").read_text().partition("(")[2].rpartition(")")
        fields = rest.split()
        found[name] = found.get(name, 0.0) + (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return found


def node_run(directory: Path, rate: float, count: int, senders: int) -> dict[str, Any]:
    """Run a recorder and so many publishers of `count` messages on each topic; return what came of it."""
    parameters = {"output": directory, "topics": ",".join(TOPICS), "snapshot_on": "never"}
    flags = [part for key, value in parameters.items() for part in ("-p", f"{key}:={value}")]
    module = [sys.executable, "-m", "seat_gear_dynamics.nodes.recorder", "--ros-args", *flags]
    publisher = [sys.executable, "-c", PUBLISHER, ",".join(TOPICS), str(rate), str(count), str(PATIENCE)]
    with subprocess.Popen(module, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as recorder:
        sending = [subprocess.Popen(publisher, stdout=subprocess.PIPE, text=True) for _ in range(senders)]
        for sender in sending:
            assert sender.stdout is not None
            sender.stdout.readline()
        before = processor_seconds(recorder.pid)
        spent = max(float(sender.stdout.readline()) for sender in sending if sender.stdout is not None)
        after = processor_seconds(recorder.pid)
        for sender in sending:
            sender.communicate()
        recorder.send_signal(signal.SIGINT)
        recorder.wait()
    processor = {name: after[name] - before.get(name, 0.0) for name in after}
    return {**outcome(Bag(directory), processor, 12 * count * senders), "sent_per_second": 12 * count * senders / spent}


def outcome(bag: Bag, processor: dict[str, float], sent: int) -> dict[str, Any]:
    """Return the figures of a log that `sent` messages were meant for."""
    written = sum(bag.topics[topic].count for topic in TOPICS if topic in bag.topics)
    recorded, total = (bag.end_ns - bag.start_ns) * 1e-9, sum(processor.values())
    size = sum(path.stat().st_size for path in bag.files)
    counted = sum(int(text) for key, text in bag.custom_data.items() if key.startswith("lost unread of "))
    return {
        "sent": sent,
        "written": written,
        "lost": sent - written,
        "lost_and_counted": counted,
        "datagrams_dropped": int(bag.custom_data.get("datagrams dropped by the system", "0")),
        "written_per_second": written / recorded,
        "written_per_processor_second": written / total,
        "recorder_share_of_a_core": total / recorded,
        "processor_microseconds_per_message": {n: 1e6 * s / written for n, s in processor.items() if s > 0},
        "bytes_on_disk_per_second": size / recorded,
        "bytes_on_disk_per_message": size / max(written, 1),
    }


def kills(number: int) -> dict[str, Any]:
    """Kill the recorder process so often, by the test of that name; return what it found."""
    with tempfile.TemporaryDirectory() as made:
        report = Path(made) / "report.json"
        environment = {"SEAT_GEAR_KILLS": str(number), "SEAT_GEAR_KILLS_REPORT": str(report)}
        test = [sys.executable, "-m", "pytest", "-q", "test/nodes/test_recorder_kills.py"]
        subprocess.run(test, cwd=ROOT, env={**os.environ, **environment}, check=True, stdout=subprocess.DEVNULL)
        found: dict[str, Any] = json.loads(report.read_text())
    spans = found.pop("seconds_before_the_kill")
    return {**found, "log_ends_before_kill_median_s": spans[len(spans) // 2], "log_ends_before_kill_most_s": spans[-1]}


def loops_run(folder: Path) -> tuple[dict[str, Any], tuple[float, float]]:
    """Run the loops without a node; return the figures, and the library's rates of wall and processor time."""
    level = Preset("zstd", DEFAULT_LEVEL, 1_000_000)
    rates = best(
        folder,
        {
            "library": library_loop,
            "writer": partial(writer_loop, packing=level),
            "writer_batches": partial(writer_batches, packing=level),
            "recording": recording_loop,
            "recording_batches": recording_batches,
        },
    )
    library = rates.pop("library")
    presets = {name: preset_run(folder / name, packing, library[0]) for name, packing in PRESETS.items()}
    ratios = {
        f"{name}_over_library{kind}": rate[k] / library[k]
        for name, rate in rates.items()
        for k, kind in enumerate(("", "_processor"))
    }
    figures = {
        "library_messages_per_second": library[0],
        "library_messages_per_processor_second": library[1],
        **ratios,
        "presets": presets,
        "snapshot_of_ten_seconds_s": snapshot_seconds(folder / "snapshot"),
    }
    return figures, library


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=1000.0, help="messages a second on each of 12 topics")
    parser.add_argument("--senders", type=int, default=2, help="processes that flood the recorder")
    parser.add_argument("--kills", type=int, default=0, help="kill the recorder process so often, too")
    arguments = parser.parse_args()
    os.environ["ROS_DOMAIN_ID"] = str(random.SystemRandom().randrange(1, 100))
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        figures, library = loops_run(folder)
        steady = node_run(folder / "steady", arguments.rate, int(arguments.rate * arguments.seconds), 1)
        flood = node_run(folder / "flood", 0.0, FLOOD // 12 // arguments.senders, arguments.senders)
    figures |= {"steady": steady, "flood": flood}
    figures["whole_node_over_library"] = {
        "processor": flood["written_per_processor_second"] / library[1],
        "wall": flood["written_per_second"] / library[0],
        "processor_at_the_steady_rate": steady["written_per_processor_second"] / library[1],
    }
    if arguments.kills:
        figures["kills"] = kills(arguments.kills)
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
