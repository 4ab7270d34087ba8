"""Damages copies of real logs at random and holds what is recovered against what was written; prints JSON.

`python trials.py FOLDER truncation|corruption FIRST COUNT`: so many trials, each seeded by its number.
The judgement uses the mcap library's reader on the undamaged log and shares no code with the recovery.
"""

from __future__ import annotations

import hashlib
import json
import random
import re
import shutil
import sys
import tracemalloc
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk

from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.recovery import recover
from seat_gear_dynamics.logs.writer import BagWriter

THIRD_PARTY = Path(__file__).resolve().parents[3] / "bags" / "third_party_bench"
TEXT = "name: test\n"
MESSAGES = 2400  # 4 s of three topics at 200 Hz

Row = tuple[str, int, int, int, bytes]  # topic, sequence, log time, publish time, data


@dataclass
class Stretch:
    """A chunk of an undamaged file: where it lies, its messages, the topics it declares."""

    begin: int
    end: int
    rows: list[Row] = field(default_factory=list)
    declares: set[str] = field(default_factory=set)


@dataclass
class Original:
    """An undamaged file: its chunks, and where its summary begins (its size when it has none)."""

    size: int
    summary: int
    chunks: list[Stretch]


def write_log(directory: Path, *, compression: str, closed: bool, split_s: float | None, count: int = MESSAGES) -> None:
    """Record real messages again with this project's writer; not `closed`: as a killed recorder leaves it."""
    source = Bag(THIRD_PARTY)
    writing = directory if closed else directory.with_name(directory.name + "_open")
    log = BagWriter(
        writing,
        system_text=TEXT,
        system_hash=hashlib.sha256(TEXT.encode()).hexdigest(),
        software_version="0.1.0",
        chunk_size=15_000,
        compression=compression,
        sync_interval_s=0.4,
        max_duration_s=split_s,
    )
    for name, info in source.topics.items():
        log.add_topic(name, info.type)
    last = 0
    for message in islice(source.messages(), count):
        log.write(message.topic, message.data, message.log_time_ns, message.publish_time_ns)
        last = message.log_time_ns
    log.sync(last)
    if not closed:
        shutil.copytree(writing, directory)
        for path in directory.glob("*.mcap"):
            path.rename(directory / path.name.replace(writing.name, directory.name))
        text = (directory / "metadata.yaml").read_text().replace(writing.name, directory.name)
        (directory / "metadata.yaml").write_text(text)
    log.close()


def read_original(path: Path) -> Original:
    """Read an undamaged file with the mcap library."""
    data = path.read_bytes()
    channels: dict[int, str] = {}
    chunks: list[Stretch] = []
    with open(path, "rb") as file:
        for record in StreamReader(file, emit_chunks=True).records:
            if not isinstance(record, Chunk):
                continue
            begin = data.index(record.data, chunks[-1].end if chunks else 0) - 40 - len(record.compression) - 9
            stretch = Stretch(begin, begin + 49 + len(record.compression) + len(record.data))
            for inner in breakup_chunk(record, validate_crc=True):
                if isinstance(inner, Channel):
                    channels[inner.id] = inner.topic
                    stretch.declares.add(inner.topic)
                elif isinstance(inner, Message):
                    topic = channels[inner.channel_id]
                    stretch.rows.append((topic, inner.sequence, inner.log_time, inner.publish_time, inner.data))
            chunks.append(stretch)
    summary = int.from_bytes(data[-28:-20], "little")
    return Original(len(data), summary or len(data), chunks)


def rows_of(directory: Path) -> Iterator[Row]:
    """Yield the messages of a bag with the mcap library."""
    for path in sorted(directory.glob("*.mcap")):
        channels: dict[int, str] = {}
        with open(path, "rb") as file:
            for record in StreamReader(file, validate_crcs=True).records:
                if isinstance(record, Channel):
                    channels[record.id] = record.topic
                elif isinstance(record, Message):
                    yield (
                        channels[record.channel_id],
                        record.sequence,
                        record.log_time,
                        record.publish_time,
                        record.data,
                    )


def surely_kept(original: Original, place: int, truncated: bool, others: bool) -> list[Row]:
    """Return the messages of the chunks that the damage has not touched, of topics whose declaration it has spared.

    The byte `place` is wrong or, `truncated`, the file ends there. `others`: whole files of the same bag are left.
    """
    intact = [c for c in original.chunks if c.end <= place or (not truncated and c.begin > place)]
    named = {topic for chunk in intact for topic in chunk.declares}
    has_summary = original.summary < original.size and not truncated and place < original.summary
    return [row for chunk in intact for row in chunk.rows if others or has_summary or row[0] in named]


def prepare(folder: Path) -> list[tuple[Path, dict[str, Original]]]:
    """Write the logs that are damaged: three codecs, finished or killed, one file or several."""
    kinds = [
        (compression, closed, split)
        for compression in ("zstd", "lz4", "none")
        for closed in (True, False)
        for split in (None, 1.5)
    ]
    logs = []
    for number, (compression, closed, split) in enumerate(kinds):
        directory = folder / f"log{number}"
        write_log(directory, compression=compression, closed=closed, split_s=split)
        logs.append((directory, {path.name: read_original(path) for path in directory.glob("*.mcap")}))
    return logs


def trial(folder: Path, log: Path, originals: dict[str, Original], kind: str, number: int) -> dict[str, Any]:
    """Damage a copy of a log, recover it, and return what is wrong with the result."""
    chance = random.Random(f"{kind} {number}")
    damaged, output = folder / "damaged", folder / "damaged_recovered"
    shutil.copytree(log, damaged)
    victim = chance.choice(sorted(damaged.glob("*.mcap")))
    original = originals[victim.name]
    data = bytearray(victim.read_bytes())
    place = chance.randrange(len(data))
    if kind == "truncation":
        del data[place:]
    else:
        data[place] ^= chance.randrange(1, 256)
    victim.write_bytes(data)
    if chance.random() < 0.3:
        (damaged / "metadata.yaml").unlink()
    before = {path.name: path.read_bytes() for path in damaged.iterdir()}
    least = Counter(surely_kept(original, place, kind == "truncation", len(originals) > 1))
    for name, other in originals.items():
        if name != victim.name:
            least.update(row for chunk in other.chunks for row in chunk.rows)
    written = Counter(row for other in originals.values() for chunk in other.chunks for row in chunk.rows)
    wrong: list[str] = []
    kept: Counter[Row] = Counter()
    refused = False
    try:
        result = recover(damaged)
        kept = Counter(rows_of(output))
        if result.verified_by != ("seat_gear_dynamics", "mcap", "rosbags"):
            wrong.append(f"verified by {result.verified_by} only: {result.notes}")
        if result.messages != kept.total():
            wrong.append(f"{result.messages} messages told, {kept.total()} written")
    except LogError:
        refused = True
    if kept - written:
        wrong.append(f"{(kept - written).total()} messages that were never written")
    if least - kept:
        wrong.append(f"{(least - kept).total()} messages of intact chunks missing")
    if before != {path.name: path.read_bytes() for path in damaged.iterdir()}:
        wrong.append("the damaged log was touched")
    shutil.rmtree(damaged)
    shutil.rmtree(output, ignore_errors=True)
    if left := [path.name for path in folder.iterdir() if path.name.startswith(".")]:
        wrong.append(f"left behind: {left}")
    return {"wrong": wrong, "refused": refused, "kept": kept.total(), "written": written.total(), "place": place}


def peak_resident() -> int:
    """Return the most memory this program held, bytes; getrusage would count what its parent held before the exec."""
    found = re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text(encoding="ascii"))
    assert found
    return int(found[1]) * 1024


def main() -> None:
    folder, kind, first, count = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    logs = prepare(folder)
    failures: list[str] = []
    refused = kept = written = 0
    traced = 0
    for number in range(first, first + count):
        log, originals = logs[number % len(logs)]
        # Tracing slows Python down severalfold, so that it looks at a share only; the resident size counts all.
        if number % 20 == 0:
            tracemalloc.start()
        found = trial(folder, log, originals, kind, number)
        if tracemalloc.is_tracing():
            traced = max(traced, tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()
        failures += [f"{kind} {number} of {log.name}, byte {found['place']}: {text}" for text in found["wrong"]]
        refused += found["refused"]
        kept += found["kept"]
        written += found["written"]
    peak = peak_resident()
    print(
        json.dumps(
            {
                "trials": count,
                "failures": failures,
                "refused": refused,
                "share_kept": kept / written,
                "peak_resident_bytes": peak,
                "peak_traced_bytes": traced,
            }
        )
    )


if __name__ == "__main__":
    main()
