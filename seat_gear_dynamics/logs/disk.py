"""Files that survive a crash: an append-only file that can be rewound, and atomic replacement of a text."""

from __future__ import annotations

import os
from contextlib import suppress
from io import FileIO
from pathlib import Path


class DurableFile:
    """An append-only binary file that can be sealed with a provisional ending and rewound to a mark.

    The ending lies behind the data: the next write cuts it off again. A process killed between two writes
    thus leaves a file that is complete as far as it goes. All methods raise `OSError` as the system does.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        # Unbuffered: chunks are large, and after a failed write nothing may linger to be written later.
        self._raw = FileIO(path, "x")
        self.end = 0  # bytes of data, the ending not counted
        self._sealed = False

    @property
    def sealed(self) -> bool:
        """Whether the ending on disk stands right behind the last byte of data."""
        return self._sealed

    @property
    def removed(self) -> bool:
        """Whether the file has lost its name: writes to it still succeed, but nobody will ever find them."""
        return os.fstat(self._raw.fileno()).st_nlink == 0

    def write(self, data: bytes) -> int:
        """Append `data` whole and return its length in bytes."""
        if data:
            if self._sealed:
                self._cut(self.end)
            self._put(data)
            self.end += len(data)
        return len(data)

    def seal(self, ending: bytes) -> None:
        """Put `ending` behind the data without counting it as data."""
        if not self._sealed:
            self._put(ending)
            self._sealed = True

    def rewind(self, end: int) -> None:
        """Cut the file back to its first `end` bytes."""
        self._cut(end)
        self.end = end

    def sync(self) -> None:
        """Return when the data has reached the disk."""
        os.fsync(self._raw.fileno())

    def tell(self) -> int:
        """Bytes of data so far (the name that the mcap library asks for)."""
        return self.end

    def flush(self) -> None:
        """Do nothing: the file is unbuffered (the name that the mcap library asks for)."""

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        self._raw.close()

    def _put(self, data: bytes) -> None:
        # A raw write may take only a part, for instance just before the disk is full; the rest then says why.
        rest = memoryview(data)
        while rest:
            rest = rest[self._raw.write(rest) or 0 :]

    def _cut(self, end: int) -> None:
        os.ftruncate(self._raw.fileno(), end)
        self._raw.seek(end)
        self._sealed = False


def replace_text(path: Path, text: str) -> None:
    """Replace the file at `path` by `text`; a crash leaves the old content or the new, never a mixture.

    Raises `OSError`; the old file is then untouched and the temporary one removed.
    """
    temporary = path.with_name(path.name + ".tmp")
    try:
        with open(temporary, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError:
        with suppress(OSError):
            temporary.unlink()
        raise
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """Return when the names in `folder` have reached the disk; raises `OSError`."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
