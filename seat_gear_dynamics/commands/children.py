"""Child processes of a command: started apart from the terminal's Ctrl-C, ended in order, their words kept."""

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from seat_gear_dynamics.commands.errors import CommandError

_PATIENCE = 15.0  # s until a child that was told to end is killed; a recorder finishing a log is far quicker


class Child:
    """One node in a process of its own; what it prints goes to a file."""

    def __init__(self, name: str, arguments: Sequence[str], log: Path) -> None:
        self.name = name
        self._log = log
        with log.open("wb") as sink:
            # A session of its own: Ctrl-C reaches the parent only, which then ends its children one by one.
            self._process = subprocess.Popen(
                [sys.executable, "-m", f"seat_gear_dynamics.nodes.{name}", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=sink,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        # A bench keeps its pace beside other work where the system lets it; else it runs like everything does.
        with suppress(PermissionError, ProcessLookupError):
            os.setpriority(os.PRIO_PROCESS, self._process.pid, -5)

    @property
    def words(self) -> str:
        """What the child has printed so far."""
        return self._log.read_text(errors="replace")

    @property
    def running(self) -> bool:
        """Whether the child has not ended."""
        return self._process.poll() is None

    def check(self) -> None:
        """Raise CommandError if the child has ended by itself."""
        code = self._process.poll()
        if code is not None:
            last = self.words.strip().splitlines()[-1:] or ["it said nothing"]
            raise CommandError(
                f"The {self.name} ended by itself with code {code}: {last[0]} (all it said: {self._log})"
            )

    def end(self) -> int:
        """Tell the child to end, wait for it, and return its exit code; one that does not end is killed."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        try:
            return self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()
