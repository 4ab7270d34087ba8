"""Writes a rosbag2 bag of MCAP files with bounded loss, and claims nothing that is not on disk."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import NoReturn, Self

from seat_gear_dynamics.logs import metadata
from seat_gear_dynamics.logs.batch import Batch, Integers
from seat_gear_dynamics.logs.counters import Counters
from seat_gear_dynamics.logs.disk import replace_text, sync_folder
from seat_gear_dynamics.logs.errors import LogError, reason
from seat_gear_dynamics.logs.ledger import LATEST, Ledger, impossible, split_times
from seat_gear_dynamics.logs.limits import Limits
from seat_gear_dynamics.logs.metadata import FileRecord
from seat_gear_dynamics.logs.presets import DEFAULT_LEVEL, codec
from seat_gear_dynamics.logs.segment import Segment, size_of
from seat_gear_dynamics.logs.topics import Qos


class BagWriter:
    """Writes `directory/metadata.yaml` and `directory/NAME_0.mcap`, `NAME_1.mcap` …

    Bounded loss: at least every `sync_interval_s` of log time (the times passed in; no clock is read) the
    chunk in progress is closed and fsynced, and `metadata.yaml` is replaced. A process killed at any moment
    leaves a bag that opens and holds every message synced before. A sync takes as long as the disk takes for
    three fsyncs, in the calling thread. The writer is not thread-safe.

    When the disk refuses, the call raises one `LogError`; the bag is cut back to its last sync and closed,
    `failure` keeps the sentence, and later messages are counted as dropped without another error.

    `chunk_size` and `max_size_bytes` are bytes; the size of a file is known only as chunks close, so a file
    outgrows `max_size_bytes` by up to one chunk and the summary. Circular retention: with `keep_files` or
    `keep_bytes` the oldest files are deleted at a split, after `metadata.yaml` has ceased to list them.
    `system_text` is the YAML text of the system parameters, `system_hash` its sha256 and `software_version` the
    package's; all three go into every file. `custom_data` becomes rosbag2's custom_data and may be filled until
    `close`; each topic's counts stand there as `messages of TOPIC`.
    """

    def __init__(
        self,
        directory: Path | str,
        *,
        system_text: str,
        system_hash: str,
        software_version: str,
        chunk_size: int = 1_000_000,
        compression: str = "zstd",
        level: int = DEFAULT_LEVEL,
        sync_interval_s: float = 1.0,
        max_size_bytes: int | None = None,
        max_duration_s: float | None = None,
        keep_files: int | None = None,
        keep_bytes: int | None = None,
    ) -> None:
        """Create the directory and its first file; raises `LogError` if it exists or cannot be created."""
        self.directory = Path(directory)
        self.custom_data: dict[str, str] = {}
        self.failure: str | None = None
        self._limits = Limits(chunk_size, sync_interval_s, max_size_bytes, max_duration_s, keep_files, keep_bytes)
        codec(compression, level)
        self._compression, self._level = compression, level
        self._library = f"seat_gear_dynamics {software_version}"
        self._provenance = {"system": system_text, "system_hash": system_hash, "software_version": software_version}
        self._topics = Ledger()
        self._files: list[FileRecord] = []  # the finished ones, except those let go
        self._begun = self._let_go = 0
        self._segment: Segment | None = None
        self._news = False  # whether the present file holds anything but repetitions
        self._unsynced = False
        self._last_sync: int | None = None
        self._create()

    @property
    def files(self) -> tuple[Path, ...]:
        """The files of the bag so far, the one being written last."""
        names = [file.name for file in self._records()]
        return tuple(self.directory / name for name in names)

    @property
    def size(self) -> int:
        """Bytes of the file being written, its chunk in progress not counted; 0 when there is none."""
        return self._segment.size if self._segment is not None else 0

    @property
    def counters(self) -> dict[str, Counters]:
        """Per topic: received, written, dropped."""
        return self._topics.counters

    def add_topic(self, name: str, type: str, qos: Qos | None = None) -> None:
        """Declare the absolute topic `name` of the full type `type`; the same declaration twice is one.

        Raises `LogError` for a relative name, an unknown type, or a second type for the same name.
        """
        record = self._topics.add(name, type, qos or Qos())
        if record is not None and self._segment is not None:
            try:
                self._segment.add_channel(record)
            except OSError as cause:
                self._fail(cause)

    def write(self, topic: str, cdr_bytes: bytes, log_time_ns: int, publish_time_ns: int) -> bool:
        """Append one message; return False if it was dropped because the log has failed before.

        Times are nanoseconds since the epoch of the caller's clock, 0 or greater; log times should not
        decrease, but may. Raises `LogError` for an undeclared topic or an impossible time (nothing is
        counted then), and once when the disk refuses.
        """
        known = self._topics[topic]
        if not (0 <= log_time_ns < LATEST and 0 <= publish_time_ns < LATEST):
            raise impossible(topic, log_time_ns, publish_time_ns)
        sequence = known.received & 0xFFFFFFFF
        known.received += 1
        if self._segment is None:
            known.drop_pending()
            return False
        try:
            segment = self._split_if_full(self._segment, log_time_ns)
            segment.write(topic, cdr_bytes, log_time_ns, publish_time_ns, sequence)
            known.accept(1)
            known.latch(cdr_bytes, publish_time_ns, sequence)
            self._written(log_time_ns, log_time_ns)
        except OSError as cause:
            self._fail(cause)
        return True

    def write_batch(self, batch: Batch) -> bool:
        """Append messages as `write` would one after the other, in a fraction of the time; return and errors as there.

        One with an impossible time is left out, and named by the `LogError` after the others are written.
        """
        sound, wrong = split_times(batch)
        if wrong is not None:
            self.write_batch(sound)
            raise impossible(*wrong)
        before = self._topics.numbers(batch)
        if self._segment is None:
            self._topics.receive(batch)
            self._topics.drop_pending()
            return False
        place, numbers = 0, before.copy()
        try:
            while place < len(batch):
                place = self._write_run(batch, place, numbers)
        except OSError as cause:
            self._topics.receive_rest(batch, before)
            self._fail(cause)
        return True

    def _write_run(self, batch: Batch, begin: int, numbers: Integers) -> int:
        """Append messages from `begin` on while no limit is met; return the next place."""
        assert self._segment is not None
        first, before = int(batch.log_ns[begin]), numbers.copy()
        self._topics.receive(batch.part(slice(begin, begin + 1)))
        segment = self._split_if_full(self._segment, first)
        end = begin + self._limits.run(batch.log_ns[begin:], self._last_sync, segment.size, segment.start_ns)
        place = segment.write_batch(batch, begin, end, numbers)
        self._topics.receive(batch.part(slice(begin + 1, place)))
        self._topics.accept(batch.part(slice(begin, place)), before)
        self._written(first, int(batch.log_ns[place - 1]))
        return place

    def _split_if_full(self, segment: Segment, log_ns: int) -> Segment:
        if self._news and self._limits.file_full(segment.size, segment.start_ns, log_ns):
            self._segment = segment = self._split(log_ns)
        return segment

    def _written(self, first_ns: int, last_ns: int) -> None:
        """Note messages handed to the file, and sync if that is due."""
        self._news = self._unsynced = True
        if self._last_sync is None:
            self._last_sync = first_ns
        if self._limits.sync_due(self._last_sync, last_ns):
            self._sync(last_ns)

    def sync(self, now_ns: int) -> None:
        """Bring everything written so far to the disk; a timer calls this while topics are silent.

        Costs next to nothing when nothing is waiting. Raises `LogError` when the disk refuses or the log has
        been removed.
        """
        if self._segment is None:
            return
        try:
            self._sync(now_ns)
        except OSError as cause:
            self._fail(cause)

    def split(self, now_ns: int) -> Path | None:
        """Finish the present file, start the next one and return its path.

        The last messages of transient-local topics are repeated at its start with log time `now_ns`, so that
        each file can be understood alone. Returns None, and does nothing, when the present file holds no new
        message or the log has failed. Raises `LogError` when the disk refuses.
        """
        if self._segment is None or not self._news:
            return None
        try:
            return self._split(now_ns).path
        except OSError as cause:
            self._fail(cause)

    def close(self) -> None:
        """Finish the bag; a second call, or one after a failure, does nothing. Raises `LogError`."""
        if self._segment is None:
            return
        try:
            self._finish()
            self._write_metadata()
        except OSError as cause:
            self._fail(cause)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _create(self) -> None:
        try:
            self.directory.mkdir(parents=True)
            self._open()
            self._write_metadata()
            sync_folder(self.directory.parent)
        except FileExistsError as cause:
            raise LogError(
                f"The log directory {self.directory} exists already; choose another name or move it."
            ) from cause
        except OSError as cause:
            if self._segment is not None:
                self._segment.abandon()
            raise LogError(
                f"The log {self.directory} cannot be created: {reason(cause)}. Choose a folder that can be written to."
            ) from cause

    def _open(self) -> Segment:
        self._segment = Segment(
            self.directory / f"{self.directory.name}_{self._begun}.mcap",
            chunk_size=self._limits.chunk_size,
            compression=self._compression,
            level=self._level,
            library=self._library,
        )
        self._begun += 1
        for topic in self._topics.records:
            self._segment.add_channel(topic)
        self._segment.add_metadata(metadata.RECORD_NAME, self._provenance)
        self._add_rosbag2_record(self._segment)
        self._segment.sync()
        self._news = False
        return self._segment

    def _split(self, now_ns: int) -> Segment:
        self._finish()
        segment = self._open()
        for name, data, publish_ns, sequence in self._topics.latched():
            # The sequence number stays, so that a reader can tell a repetition from a new message.
            segment.write(name, data, now_ns, publish_ns, sequence)
            self._unsynced = True
        surplus = self._surplus()
        self._write_metadata()
        for path in surplus:  # only now: metadata.yaml must never list what is gone
            path.unlink(missing_ok=True)
        self._last_sync = now_ns
        return segment

    def _surplus(self) -> list[Path]:
        """Strike the files that retention lets go from the bag and return their paths."""
        count = self._limits.surplus([size_of(self.directory / file.name) for file in self._files])
        gone, self._files = self._files[:count], self._files[count:]
        if gone:
            self._let_go += count
            self.custom_data["files let go"] = str(self._let_go)
        return [self.directory / file.name for file in gone]

    def _finish(self) -> None:
        """Complete the present file; afterwards there is none."""
        assert self._segment is not None
        # First the data alone: if only the summary finds no room, the data is kept.
        self._segment.check_present()
        self._segment.sync()
        self._settle()
        self._add_rosbag2_record(self._segment)
        self._segment.finish()
        self._files.append(self._segment.durable)
        self._segment = None

    def _sync(self, now_ns: int) -> None:
        assert self._segment is not None
        self._last_sync = now_ns
        self._segment.check_present()
        if self._unsynced:
            self._segment.sync()
            self._settle()
            self._write_metadata()

    def _settle(self) -> None:
        """Count everything handed over as written: call only when it is durable."""
        self._unsynced = False
        self._topics.settle()

    def _records(self) -> list[FileRecord]:
        """All files of the bag with what is durable in them."""
        if self._segment is None or not self._segment.usable:
            return self._files
        return [*self._files, self._segment.durable]

    def _add_rosbag2_record(self, segment: Segment) -> None:
        text = metadata.serialized(self._topics.records, [*self._files, segment.durable], self._custom())
        segment.add_metadata("rosbag2", {"serialized_metadata": text})

    def _write_metadata(self) -> None:
        text = metadata.document(self._topics.records, self._records(), self._custom())
        replace_text(self.directory / metadata.FILE_NAME, text)

    def _custom(self) -> dict[str, str]:
        counts = {f"messages of {name}": str(counters) for name, counters in self.counters.items()}
        return {**self.custom_data, **counts}

    def _fail(self, cause: OSError) -> NoReturn:
        """Cut the bag back to what is durable, close it for good and raise the sentence."""
        lost = self._topics.drop_pending()
        self.failure = (
            f"The log {self.directory} has stopped: {reason(cause)}. {lost} messages since the last sync "
            f"are lost, and later ones are dropped. Make room or restore the folder, and start a new log."
        )
        self.custom_data["failure"] = self.failure
        if self._segment is not None:
            self._segment.abandon()
        self._files = self._records()
        self._segment = None
        with suppress(OSError):  # the older metadata.yaml claims less, never more
            self._write_metadata()
        raise LogError(self.failure) from cause
