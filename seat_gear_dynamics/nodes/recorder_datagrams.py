"""Datagrams that the system dropped because this process did not fetch them in time, as Linux counts them."""

import os
from collections.abc import Collection
from pathlib import Path

_TABLES = (Path("/proc/self/net/udp"), Path("/proc/self/net/udp6"))
_SOCKETS = Path("/proc/self/fd")
_INODE, _DROPS = 9, 12  # columns of a table


class Datagrams:
    """Counts over the process's UDP sockets; a reliable topic has its messages sent again, another has lost them."""

    def __init__(self) -> None:
        self._most = 0

    def dropped(self) -> int:
        """Return how many were dropped so far; 0 where the system does not tell. A closed socket is not forgotten."""
        self._most = max(self._most, _now())
        return self._most


def _now() -> int:
    try:
        inodes = own_sockets(_SOCKETS)
        return sum(drops(path.read_text(), inodes) for path in _TABLES if path.exists())
    except OSError:
        return 0


def own_sockets(folder: Path) -> set[str]:
    """Return the inodes of the sockets in a folder of open files."""
    found = set()
    for entry in os.scandir(folder):
        try:
            target = os.readlink(entry.path)
        except OSError:
            continue  # closed since
        if target.startswith("socket:["):
            found.add(target[8:-1])
    return found


def drops(table: str, inodes: Collection[str]) -> int:
    """Return the drops that a table in the form of /proc/net/udp shows for some sockets."""
    rows = (line.split() for line in table.splitlines()[1:])
    return sum(int(row[_DROPS]) for row in rows if len(row) > _DROPS and row[_INODE] in inodes)
