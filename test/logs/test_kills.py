"""Two hundred kills at random moments: what was reported as synced is there, in order, and no more is claimed."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import yaml

from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag

ROOT = Path(__file__).resolve().parents[2]
KILLS = 200

# Forks a writer for each kill, so that imports are paid once; the writer tells through a pipe what is safe.
SCRIPT = """
import json, os, random, select, signal, sys, time
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.writer import BagWriter
folder, kills, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
schema("std_msgs/msg/Float64")
source = random.Random(seed)

def write(directory, pipe, seed):
    data = random.Random(seed)
    log = BagWriter(directory, system_text="", system_hash="", software_version="0", chunk_size=4_000,
                    sync_interval_s=0.02, max_duration_s=0.2, keep_files=None)
    log.add_topic("/a", "std_msgs/msg/Float64")
    safe, i = 0, 0
    while True:
        log.write("/a", i.to_bytes(8, "little") + data.randbytes(200), 1 + i * 1_000_000, 0)
        i += 1
        if log.counters["/a"].written != safe:
            safe = log.counters["/a"].written
            os.write(pipe, safe.to_bytes(8, "little"))

found = []
for k in range(kills):
    inlet, outlet = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(inlet)
        try:
            write(f"{folder}/log{k}", outlet, k)
        finally:
            os._exit(3)
    os.close(outlet)
    if k % 2:  # every other one lives until its first sync at least, however slow the machine is
        select.select([inlet], [], [], 60.0)
    time.sleep(source.uniform(0.0, 0.06))
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    told = b""
    while part := os.read(inlet, 65536):
        told += part
    os.close(inlet)
    safe = int.from_bytes(told[-8:], "little") if told else 0
    found.append((safe, os.waitstatus_to_exitcode(status)))
print(json.dumps(found))
"""


def test_two_hundred_kills_lose_nothing_that_was_synced(tmp_path: Path) -> None:
    command = [sys.executable, "-c", SCRIPT, str(tmp_path), str(KILLS), "20"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=250)
    assert done.returncode == 0, done.stderr
    outcomes = json.loads(done.stdout)
    assert len(outcomes) == KILLS
    held = beyond = 0
    for k, (safe, code) in enumerate(outcomes):
        assert code == -9, "the writer ended by itself"
        directory = tmp_path / f"log{k}"
        try:
            found = [int.from_bytes(message.data[:8], "little") for message in Bag(directory).messages()]
        except LogError:  # killed before its beginning was on the disk
            assert safe == 0
            continue
        assert len(found) >= safe
        assert found == list(range(len(found)))
        assert safe <= claimed(directory) <= len(found)
        held += safe > 0
        beyond += len(found) > safe
    # Moments spread over the whole life of a writer: some before the first sync, most behind it.
    assert held > KILLS // 4
    assert beyond > 0


def claimed(directory: Path) -> int:
    path = directory / "metadata.yaml"
    if not path.exists():
        return 0
    return int(yaml.safe_load(path.read_text())["rosbag2_bagfile_information"]["message_count"])
