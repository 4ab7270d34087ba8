"""Makes the small bags beside this file with the project's own recorder: `python bags/make.py [NAME …]`.

The simulated bench plays a short run, the monitor's session follows it, and what the monitor would publish goes through
the recorder with the times of the run: no clock is read, so the same build makes the same bags.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)

# isort: split
from rclpy.serialization import serialize_message
from std_msgs.msg import Bool

from seat_gear_dynamics import __version__
from seat_gear_dynamics.bench.drive import SimulatedBench
from seat_gear_dynamics.bench.profiles import Points, Profile, path
from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.container import scan
from seat_gear_dynamics.logs.recording import Recording
from seat_gear_dynamics.logs.recovery import recover
from seat_gear_dynamics.logs.snapshot import EventTrigger
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.monitor_state import model_state
from seat_gear_dynamics.sensing import Session

HERE = Path(__file__).resolve().parent
BEGIN_NS = 1_795_500_000_000_000_000
STEP_NS = 20_000_000  # 50 Hz: samples and forces
STATE, WARNING = 25, 5  # steps: 2 Hz and 10 Hz
SECTION_POINTS = 64  # of the monitor's 256, for small files: more than come between two clouds
FORCES = (topics.MODEL_INPUT, topics.MESH_FORCE, topics.MODEL_STATE)
ALARM = (*FORCES, topics.CHAOS_WARNING, topics.IN_FORBIDDEN_BAND)
WHOLE = (*ALARM, topics.MESH_STATE, topics.POINCARE)


class Published(NamedTuple):
    """A message as it goes to the recorder."""

    topic: topics.Topic
    message: Any
    now_ns: int


def run_of(speeds: Points) -> Iterator[Published]:
    """Yield what the monitor publishes while the bench plays `speeds`, (s, r/min), at 600 N·m."""
    played = Profile("bag", "a run for a bag", speeds, path(600.0))
    bench, session = (
        SimulatedBench(played, sample_time=STEP_NS * 1e-9),
        Session(load_train(), section_points=SECTION_POINTS),
    )
    first_ns = BEGIN_NS + STEP_NS
    for step in range(1, 1 + int(played.duration * 1e9) // STEP_NS):
        sample, now = bench.step(), BEGIN_NS + step * STEP_NS
        change = session.feed((now - first_ns) * 1e-9, sample.speed, sample.load)
        if change.changed or step % WARNING == 0:
            yield Published(topics.IN_FORBIDDEN_BAND, Bool(data=change.verdict.in_band), now)
            warning = messages.chaos_warning("gear_monitor: chaos warning", change.verdict, change.sample)
            yield Published(topics.CHAOS_WARNING, warning, now)
        yield Published(topics.MODEL_INPUT, messages.model_input(now, sample.speed, sample.load), now)
        windows = session.take_windows()
        if windows[0].duration:
            yield Published(topics.MESH_FORCE, messages.mesh_force(now, windows), now)
            yield Published(topics.MESH_STATE, messages.mesh_state(now, change.reading.contacts), now)
        if step % STATE == 0:
            yield Published(topics.MODEL_STATE, model_state(now, first_ns, session), now)
        if step % WARNING == 0:
            yield Published(topics.POINCARE, messages.poincare(now, session.section, first_ns), now)


def recording(name: str, kept: tuple[topics.Topic, ...], ring: float = 0.0, **limits: Any) -> Recording:
    """Return a recorder of the topics `kept` that writes to the folder `name` beside this file."""
    text = load_train().text
    writer = partial(
        BagWriter,
        system_text=text,
        system_hash=sha256(text.encode()).hexdigest(),
        software_version=__version__,
        **limits,
    )
    trigger = EventTrigger(2, after=0.3, spacing=60.0, limit=1) if ring else None
    return Recording(
        HERE / name,
        writer,
        {topic.absolute(): (topic.type, topic.qos) for topic in kept},
        ring_seconds=ring,
        trigger=trigger,
        trigger_topic=topics.CHAOS_WARNING.absolute(),
    )


def play(speeds: Points, to: Recording) -> None:
    """Feed a run to a recorder as its node would, due snapshots included; the writer itself syncs every second."""
    for topic, message, now in run_of(speeds):
        if topic.absolute() in to.totals:
            to.receive(topic.absolute(), bytes(serialize_message(message)), now, now)
        to.take_due_snapshot(now)


def split_retained() -> None:
    """Seven files of a second, of which retention leaves the last three."""
    to = recording("split_retained", FORCES, max_duration_s=1.0, keep_files=3)
    to.start()
    play(path(1000.0, (1200.0, 6.9)), to)
    to.stop()


def band_snapshot1() -> None:
    """The last 1.5 s when the drive has entered the narrow band; the recorder itself was never started."""
    play(path(1250.0, (1354.0, 2.0), (1354.0, 1.5)), recording("band", ALARM, ring=1.5))


def killed() -> None:
    """A recorder that kills itself, as `kill -9` does, 0.3 s after its last sync: no summary, the end lost."""
    code = "import os, make; make.play(make.path(1000.0, (1100.0, 4.0)), make.killer())"
    done = subprocess.run([sys.executable, "-c", code], cwd=HERE, check=False)
    if done.returncode != -signal.SIGKILL:
        raise SystemExit(f"The recorder ended with {done.returncode}, expected to be killed.")


def killer() -> Recording:
    """Return a started recorder that ends its own process with its 150th input."""
    to = recording("killed", FORCES)
    to.start()
    receive, left = to.receive, iter(range(149, -1, -1))

    def counted(topic: str, data: bytes, log_ns: int, publish_ns: int) -> None:
        receive(topic, data, log_ns, publish_ns)
        if topic == topics.MODEL_INPUT.absolute() and next(left) == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    to.receive = counted  # type: ignore[method-assign]
    return to


def damaged() -> None:
    """One wrong byte in the third of four chunks, and what `seat-gear recover` makes of it."""
    to = recording("damaged", FORCES)
    to.start()
    play(path(1000.0, (1100.0, 4.0)), to)
    to.stop()
    file = HERE / "damaged" / "damaged_0.mcap"
    third = scan(file).blocks[2]
    content = bytearray(file.read_bytes())
    content[third.offset + third.length // 2] ^= 0x01
    file.write_bytes(content)
    recover(HERE / "damaged", HERE / "damaged_recovered", unchecked=False, version=__version__)


def ramp() -> None:
    """Run-up through both bands and run-down again, with a dwell at either end."""
    to = recording("ramp", WHOLE)
    to.start()
    play(path(1280.0, (1280.0, 1.0), (1700.0, 2.5), (1700.0, 1.2), (1280.0, 2.5), (1280.0, 1.0)), to)
    to.stop()


BAGS: dict[str, Callable[[], None]] = {
    each.__name__: each for each in (split_retained, band_snapshot1, killed, damaged, ramp)
}


def main(names: list[str]) -> None:
    """Make the bags of these names, or all, in place of those that are there."""
    for name in names or BAGS:
        for folder in HERE.glob(f"{name}*"):
            if folder.is_dir():
                shutil.rmtree(folder)
        BAGS[name]()
        size = sum(file.stat().st_size for file in HERE.glob(f"{name}*/*"))
        print(f"{name}: {size / 1000:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])
