"""Files that a long computation adds to, and beside them a note of how far they are whole, to go on from later."""

import fcntl
import json
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, BinaryIO
from zlib import crc32

from seat_gear_dynamics.commands.errors import CommandError

_FORMAT = 1
_READ = 1 << 20
NOTE_INTERVAL = 1.0
"""Seconds between two notes: what a killed program has to find again, beside what was under way."""

Identity = Mapping[str, Mapping[str, Any]]
"""What a computation is, as {topic: {name: value}} of JSON's values."""


class Journal:
    """Files that grow together, entry by entry, and a note `OUTPUT.part` that says how far.

    The note stands from the first entry until `finish`. It holds what the computation is, what it had reached, and
    length and checksum of each file at that moment. A program that was killed leaves files that are longer than the
    note says; they are cut back to it when the journal is opened again.
    """

    def __init__(
        self,
        output: Path,
        files: Sequence[Path],
        identity: Identity,
        *,
        restart: bool = False,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        """Open the journal of `output` on `files`, to begin or to go on.

        Raises CommandError, a sentence, where another program writes these files, and unless `restart` where the note
        is of another computation, cannot be read, or the files are not what it says.
        """
        self.note = output.with_name(f"{output.name}.part")
        self._paths, self._identity, self._clock = files, identity, clock
        self._files: list[BinaryIO] = []
        self.reached: dict[str, Any] = {}
        """What the last entry said; empty where nothing was found yet."""
        self._standing: list[tuple[int, int]] = [(0, 0)] * len(files)
        try:
            self._open()
            if self.note.exists() and not restart:
                self._go_on()
            self._cut()
            self._write_note()
        except BaseException:
            self._close()
            raise

    def add(self, parts: Sequence[bytes], reached: Mapping[str, Any]) -> None:
        """Append a part to each file; `reached`, of JSON's values, is what the computation can go on from then."""
        for file, part in zip(self._files, parts, strict=True):
            file.write(part)
        # All at one stroke: an interruption before it leaves the entry out.
        self._standing, self.reached = (
            [(size + len(part), crc32(part, crc)) for (size, crc), part in zip(self._standing, parts, strict=True)],
            dict(reached),
        )
        if self._clock() - self._noted >= NOTE_INTERVAL:
            self._write_note()

    def flush(self) -> None:
        """Hand what was added to the operating system, where others can read it; a note takes it to the disk."""
        for file in self._files:
            file.flush()

    def finish(self) -> None:
        """Close the files and take the note away: the computation is complete."""
        self._write_note()
        self._close()
        self.note.unlink()

    def __enter__(self) -> "Journal":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._files:
            with suppress(OSError):  # with a full disk the note before this one stands
                self._write_note()
            self._close()

    def _open(self) -> None:
        for path in self._paths:
            path.touch()
            self._files.append(path.open("r+b"))
        try:
            fcntl.flock(self._files[0], fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise CommandError(
                f"{self._paths[0]} is being written by another program; wait for its end, or give another --output."
            ) from error

    def _go_on(self) -> None:
        """Take over what the note says, once the files have been checked against it."""
        found = self._read_note()
        if (differs := _first_difference(found["identity"], self._identity)) is not None:
            raise CommandError(
                f"{self.note} is of another computation ({differs}); give another --output, or begin anew with "
                f"--restart."
            )
        for path, file, (size, crc) in zip(self._paths, self._files, found["files"], strict=True):
            if _checksum(file, size) != crc:
                raise CommandError(
                    f"{path} is not what {self.note} says that was written (its first {size} bytes differ or are not "
                    f"there); begin anew with --restart."
                )
        self.reached, self._standing = found["reached"], [(size, crc) for size, crc in found["files"]]

    def _read_note(self) -> dict[str, Any]:
        try:
            found: dict[str, Any] = json.loads(self.note.read_text(encoding="utf-8"))
            if found["format"] == _FORMAT and len(found["files"]) == len(self._paths):
                return found
            reason = f"format {found['format']}, expected {_FORMAT}"
        except (ValueError, KeyError, TypeError) as error:
            reason = str(error)
        raise CommandError(f"{self.note} cannot be read ({reason}); begin anew with --restart.")

    def _cut(self) -> None:
        """Cut the files back to what is known of them."""
        for file, (size, _) in zip(self._files, self._standing, strict=True):
            file.truncate(size)
            file.seek(size)

    def _write_note(self) -> None:
        from seat_gear_dynamics.logs.disk import replace_text

        for file in self._files:
            file.flush()
            os.fsync(file.fileno())
        note = {"format": _FORMAT, "identity": self._identity, "files": self._standing, "reached": self.reached}
        replace_text(self.note, json.dumps(note))
        self._noted = self._clock()

    def _close(self) -> None:
        for file in self._files:
            with suppress(OSError):  # what could not be written is behind the note
                file.close()
        self._files = []


def _checksum(file: BinaryIO, size: int) -> int | None:
    """Return the checksum of the first `size` bytes; None where there are fewer."""
    file.seek(0)
    crc, left = 0, size
    while left and (part := file.read(min(_READ, left))):
        crc, left = crc32(part, crc), left - len(part)
    return None if left else crc


def _first_difference(found: Identity, asked: Identity) -> str | None:
    """Return in words the first value in which two identities differ; None where they agree."""
    plain: Identity = json.loads(json.dumps(asked))  # as it comes back from a file: tuples as lists
    for topic in {**plain, **found}:
        then, now = found.get(topic, {}), plain.get(topic, {})
        for name in {**now, **then}:
            if then.get(name) != now.get(name):
                return f"{topic} {name} was {then.get(name)}, now {now.get(name)}"
    return None
