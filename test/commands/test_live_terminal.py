"""The live view in a real terminal (a pseudo one): drawn, ended by Ctrl-C from its keyboard, left clean."""

import os
import pty
import random
import select
import struct
import subprocess
import sys
from fcntl import ioctl
from pathlib import Path
from termios import TIOCSWINSZ
from time import monotonic

import pytest

from seat_gear_dynamics.logs.reader import Bag

PATIENCE = 120.0  # s; a first start compiles the model


class Terminal:
    """A pseudo terminal of 80x24 with a program in it."""

    def __init__(self, command: list[str], environment: dict[str, str]) -> None:
        self._master, slave = pty.openpty()
        ioctl(slave, TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        self.process = subprocess.Popen(
            command, stdin=slave, stdout=slave, stderr=slave, env=environment, start_new_session=True, close_fds=True
        )
        os.close(slave)
        self.shown = ""

    def read_until(self, reached: str) -> None:
        """Read what is drawn until a text has been seen or the program has ended."""
        begin = monotonic()
        while reached not in self.shown:
            assert monotonic() - begin < PATIENCE, f"waited {PATIENCE} s for {reached!r}"
            if not self._read():
                return

    def _read(self) -> bool:
        if not select.select([self._master], [], [], 0.2)[0]:
            return self.process.poll() is None
        try:
            self.shown += os.read(self._master, 65536).decode(errors="replace")
        except OSError:  # the other end is closed
            return False
        return True

    def type(self, keys: bytes) -> None:
        """Type on the keyboard."""
        os.write(self._master, keys)


@pytest.mark.parametrize("colour", [True, False], ids=["colour", "NO_COLOR"])
def test_ctrl_c_ends_the_live_view_and_leaves_the_terminal_clean(tmp_path: Path, colour: bool) -> None:
    log = tmp_path / "run"
    environment = {
        **os.environ,
        "TERM": "xterm-256color",
        "ROS_DOMAIN_ID": str(random.SystemRandom().randrange(1, 200)),
    }
    environment.pop("NO_COLOR", None)
    if not colour:
        environment["NO_COLOR"] = "1"
    bench = [sys.executable, "-m", "seat_gear_dynamics", "bench", "--output", str(log)]
    # Ctrl-C is a signal only for those whose controlling terminal it is typed in.
    take = f"import fcntl, os, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); os.execv({bench[0]!r}, {bench!r})"
    terminal = Terminal([sys.executable, "-c", take], environment)
    terminal.read_until("s1_s2")
    terminal.read_until("recording")
    terminal.type(b"\x03")
    terminal.read_until("report: ")
    assert terminal.process.wait(30) == 0, terminal.shown[-2000:]
    assert "seat-gear bench: up-down" in terminal.shown
    assert terminal.shown.rindex("\x1b[?25h") > terminal.shown.rindex("\x1b[?25l"), "the cursor is shown again"
    assert ("\x1b[38;" in terminal.shown) is colour
    assert "Traceback" not in terminal.shown
    assert Bag(log).closed
