"""A `seat-gear` that gets a signal amid its rows: what a killed sweep or map leaves behind."""

import signal
import subprocess
import sys
from collections.abc import Sequence

# Signals itself when so many rows were added to a journal.
_PROGRAM = """
import os, signal, sys
from itertools import count
signal.signal(signal.SIGINT, signal.default_int_handler)  # which a job that a shell runs in the background ignores
from seat_gear_dynamics.commands import journal, main
number, rows, journal.NOTE_INTERVAL = int(sys.argv.pop(1)), int(sys.argv.pop(1)), float(sys.argv.pop(1))
add, added = journal.Journal.add, count()
def counted(self, *arguments):
    add(self, *arguments)
    if next(added) == rows:
        os.kill(os.getpid(), number)
journal.Journal.add = counted
sys.exit(main())
"""


def ended_amid(
    words: Sequence[str], number: int, rows: int, *, note_interval: float = 1.0
) -> subprocess.CompletedProcess[str]:
    """Run a command in a process that gets signal `number` with its row `rows`; fails where it ended otherwise.

    `note_interval`, s, is how often it notes how far it has come, before its last word.
    """
    command = [sys.executable, "-c", _PROGRAM, str(int(number)), str(rows), str(note_interval), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == (130 if number == signal.SIGINT else -number), done.stderr
    return done
