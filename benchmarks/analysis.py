"""What the analysis of a log costs: `python benchmarks/analysis.py [--foreign] [MINUTES …]`, a JSON object a length.

For each length a log at the default rates is made faster than real time, in a folder of its own that is removed
afterwards, and analysed as `seat-gear analyze` does, in a process of its own: seconds by the wall, processor time of it
and of the processes that it starts, and the peak of its memory and of the largest of theirs.
`python benchmarks/analysis.py [--foreign] --write DIRECTORY SECONDS` only makes such a log.

The log: the simulated bench plays up-down, one round of it goes through the monitor's session, and the round is written
again and again with its stamps moved on. Messages, rates and sizes are those of a bench; the motion starts anew at each
round, at standstill.

With `--foreign` it is another program's: speed in r/min and load under other names, nothing else, so that `analyze` has
to compute all outputs. There each round has noise of its own.
"""

import json
import os
import struct
import subprocess
import sys
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)

# isort: split
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64, Header

from seat_gear_dynamics import __version__
from seat_gear_dynamics.bench.drive import SimulatedBench
from seat_gear_dynamics.bench.profiles import Profile, profile
from seat_gear_dynamics.gears import GearTrain, load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.sensing import BandSource, Session

BEGIN_NS = 1_790_000_000_000_000_000
STEP_NS = 20_000_000  # 50 Hz: samples and forces
FIRST_NS = BEGIN_NS + STEP_NS
"""Stamp of the first sample, t = 0 of the monitor."""
EVERY_WARNING, EVERY_DIAGNOSTICS = 5, 50  # steps: 10 Hz and 1 Hz
FOREIGN_SPEED, FOREIGN_LOAD = "/rig/spindle_speed", "/rig/brake_torque"
FOREIGN_SOURCE = ["--speed-topic", FOREIGN_SPEED, "--load-topic", FOREIGN_LOAD, "--speed-unit", "r/min"]


class Written(NamedTuple):
    """A message of the round: topic, bytes, ns since the round's begin, and how its stamps are moved."""

    topic: str
    data: bytes
    offset_ns: int
    moved: str


def round_of(
    train: GearTrain,
    played: Profile,
    *,
    seed: int = 0,
    seconds: float | None = None,
    bands: BandSource | None = None,
) -> Iterator[Written]:
    """Yield what the bench and the monitor, on these bands, publish in a round of a profile or its first `seconds`."""
    bench = SimulatedBench(played, sample_time=STEP_NS * 1e-9, seed=seed)
    session = Session(train, bands=bands)
    for step in range(1, 1 + int((seconds or played.duration) * 1e9) // STEP_NS):
        sample = bench.step()
        now = BEGIN_NS + step * STEP_NS
        offset = step * STEP_NS
        joint = JointState(
            header=Header(stamp=messages.stamp(now)),
            name=["seat_height"],
            position=[],
            velocity=[sample.speed],
            effort=[sample.load],
        )
        yield written(topics.LOAD_TORQUE, Float64(data=sample.load), offset, "")
        yield written(topics.MOTOR_SPEED, Float64(data=sample.speed), offset, "")
        yield written(topics.JOINT_STATES, joint, offset, "stamp")
        change = session.feed((now - FIRST_NS) * 1e-9, sample.speed, sample.load)
        if change.changed or step % EVERY_WARNING == 0:
            text = messages.chaos_warning("gear_monitor: chaos warning", change.verdict, change.sample)
            yield written(topics.IN_FORBIDDEN_BAND, Bool(data=change.verdict.in_band), offset, "")
            yield written(topics.CHAOS_WARNING, text, offset, "")
        yield written(topics.MODEL_INPUT, messages.model_input(now, sample.speed, sample.load), offset, "stamp")
        windows = session.take_windows()
        if windows[0].duration:
            yield written(topics.MESH_FORCE, messages.mesh_force(now, windows), offset, "stamp")
            yield written(topics.MESH_STATE, messages.mesh_state(now, change.reading.contacts), offset, "stamp")
        if step % EVERY_WARNING == 0:
            yield written(topics.POINCARE, messages.poincare(now, session.section, FIRST_NS), offset, "cloud")
        if step % EVERY_DIAGNOSTICS == 0:
            status = messages.chaos_warning("gear_monitor: warning", change.verdict, change.sample)
            array = DiagnosticArray(header=Header(stamp=messages.stamp(now)), status=[status])
            yield written(topics.DIAGNOSTICS, array, offset, "stamp")


def written(topic: topics.Topic, message: Any, offset_ns: int, moved: str) -> Written:
    return Written(topic.absolute(), bytes(serialize_message(message)), offset_ns, moved)


def moved_on(message: Written, by_ns: int) -> bytes:
    """Return the message's bytes with its stamps `by_ns` later."""
    if not message.moved or not by_ns:
        return message.data
    data = bytearray(message.data)
    now = BEGIN_NS + message.offset_ns + by_ns
    struct.pack_into("<iI", data, 4, now // 10**9, now % 10**9)
    if message.moved == "cloud":
        width = struct.unpack_from("<I", data, len(data) - 1 - 4 - 20 * _width(data))[0] // 20
        layout = np.dtype({"names": ["t"], "formats": ["<f8"], "offsets": [12], "itemsize": 20})
        begin = len(data) - 1 - 20 * width
        points = np.frombuffer(data, layout, count=width, offset=begin)
        points["t"] += by_ns * 1e-9
    return bytes(data)


def _width(data: bytearray) -> int:
    """Return how many points a cloud holds: behind its stamp and its frame's name stand height and width."""
    length = struct.unpack_from("<I", data, 12)[0]
    behind = 16 + length
    behind += (4 - behind) % 4
    width: int = struct.unpack_from("<I", data, behind + 4)[0]
    return width


def write_log(
    directory: Path,
    seconds: float,
    *,
    played: str = "up-down",
    seed: int = 0,
    sync_interval: float = 1.0,
    bands: BandSource | None = None,
) -> int:
    """Write a log of `seconds` to `directory` and return its number of messages."""
    train, chosen = load_train(), profile(played)
    one = list(round_of(train, chosen, seed=seed, seconds=min(seconds, chosen.duration), bands=bands))
    length = 1 + one[-1].offset_ns // STEP_NS * STEP_NS
    count = 0
    with BagWriter(
        directory,
        system_text=train.text,
        system_hash=sha256(train.text.encode()).hexdigest(),
        software_version=__version__,
        sync_interval_s=sync_interval,
    ) as writer:
        for topic in topics.TOPICS:
            writer.add_topic(topic.absolute(), topic.type, topic.qos)
        for n in range(int(seconds * 1e9 // length) + 1):
            for message in one:
                at = message.offset_ns + n * (length - 1)
                if at > seconds * 1e9:
                    return count
                now = BEGIN_NS + at
                writer.write(message.topic, moved_on(message, n * (length - 1)), now, now)
                count += 1
    return count


def write_foreign_log(directory: Path, seconds: float, *, played: str = "up-down", seed: int = 0) -> int:
    """Write a log of speed and load alone with `rosbags`, and return its number of messages."""
    bench = SimulatedBench(profile(played), sample_time=STEP_NS * 1e-9, seed=seed)
    steps, types = int(seconds * 1e9) // STEP_NS, get_typestore(Stores.ROS2_JAZZY)
    with Writer(directory, version=Writer.VERSION_LATEST, storage_plugin=StoragePlugin.MCAP) as writer:
        of_speed, of_load = (
            writer.add_connection(name, topics.FLOAT64, typestore=types) for name in (FOREIGN_SPEED, FOREIGN_LOAD)
        )
        for step in range(steps):
            sample, now = bench.step(), BEGIN_NS + step * STEP_NS
            for connection, value in ((of_speed, sample.speed / RPM), (of_load, sample.load)):
                writer.write(connection, now, bytes(serialize_message(Float64(data=value))))
    return 2 * steps


def measure(minutes: float, *, foreign: bool) -> dict[str, Any]:
    """Return what the analysis of a log of `minutes` costs, without and with the model beside it."""
    found: dict[str, Any] = {"minutes": minutes, "foreign": foreign, "load_average": os.getloadavg()[0]}
    write, source = (write_foreign_log, FOREIGN_SOURCE) if foreign else (write_log, [])
    with TemporaryDirectory(prefix="seat_gear_analysis_") as folder:
        log = Path(folder) / "log"
        begin = perf_counter()
        found["messages"] = write(log, 60 * minutes)
        found["written_in_s"] = perf_counter() - begin
        found["megabytes"] = sum(path.stat().st_size for path in log.iterdir()) / 1e6
        for name, extra in (("log_alone", ["--no-model"]), ("whole", [])):
            asked = ["analyze", str(log), "--output", f"{folder}/{name}", "--json", *source, *extra]
            found[name] = in_a_process(asked)
    return found


def in_a_process(arguments: list[str]) -> dict[str, Any]:
    code = (
        "import sys, resource, contextlib, io, json; from seat_gear_dynamics.commands import main\n"
        "said = io.StringIO()\n"
        "with contextlib.redirect_stdout(said): code = main(sys.argv[1:])\n"
        "own, started = (resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))\n"
        "print(json.dumps({\n"
        "    'processor_s': own.ru_utime + own.ru_stime, 'of_children_s': started.ru_utime + started.ru_stime,\n"
        "    'peak_megabytes': own.ru_maxrss / 1024, 'largest_child_megabytes': started.ru_maxrss / 1024,\n"
        "    'stretches': json.loads(said.getvalue())['stretches']}))\n"
        "sys.exit(code)"
    )
    begin = perf_counter()
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return {"seconds": perf_counter() - begin, **json.loads(done.stdout)}


def main(arguments: list[str]) -> None:
    foreign = "--foreign" in arguments
    given = [argument for argument in arguments if argument != "--foreign"]
    if given[:1] == ["--write"]:
        print((write_foreign_log if foreign else write_log)(Path(given[1]), float(given[2])))
        return
    for minutes in given or ["5", "60"]:
        print(json.dumps(measure(float(minutes), foreign=foreign)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
