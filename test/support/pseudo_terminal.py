"""A program in a pseudo terminal: what it draws, keys typed at it, and the state in which it leaves the terminal."""

import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
from codecs import getincrementaldecoder
from collections.abc import Callable, Sequence
from fcntl import ioctl
from pathlib import Path
from time import monotonic

PATIENCE = 120.0  # s; a first start compiles the model
_MODES = re.compile(r"\x1b\[\?([0-9;]+)([hl])")
_COLOURS = re.compile(r"\x1b\[([0-9;]*)m")
_STAYING = {"25": "the cursor is hidden", "1049": "the alternate screen is on", "2004": "bracketed paste is on"}


class PseudoTerminal:
    """A terminal with a program in it, whose controlling terminal it is: Ctrl-C typed here is a signal there."""

    def __init__(
        self, command: Sequence[str], *, size: tuple[int, int] = (80, 24), cwd: Path | None = None, **environment: str
    ) -> None:
        """Start Python with `command` at `size` columns and lines; a variable of `environment` that is "" is unset."""
        self._master, self._slave = pty.openpty()
        ioctl(self._slave, termios.TIOCSWINSZ, struct.pack("HHHH", size[1], size[0], 0, 0))
        self._before = termios.tcgetattr(self._slave)
        unset = dict.fromkeys(("NO_COLOR", "FORCE_COLOR", "COLUMNS", "LINES", "COLORTERM", "TTY_COMPATIBLE"), "")
        settings = {**os.environ, "TERM": "xterm-256color", **unset, **environment}
        run = [sys.executable, *command]
        take = f"import fcntl, os, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); os.execv({run[0]!r}, {run!r})"
        self.process = subprocess.Popen(
            [sys.executable, "-c", take],
            stdin=self._slave,
            stdout=self._slave,
            stderr=self._slave,
            env={name: value for name, value in settings.items() if value},
            cwd=cwd,
            start_new_session=True,
        )
        self.shown = ""
        self._decoder = getincrementaldecoder("utf-8")("replace")  # a read may end amid a character

    def read_until(self, reached: str | Callable[[str], bool]) -> None:
        """Read what is drawn until a text was seen, or `text` satisfies `reached`; fails if it never is."""
        begin = monotonic()

        def seen() -> bool:
            return reached(self.text) if callable(reached) else reached in self.shown

        while not seen():
            assert self._read() or seen(), f"ended without {reached!r}: {self.shown[-2000:]}"
            assert monotonic() - begin < PATIENCE, f"waited {PATIENCE} s for {reached!r}: {self.shown[-2000:]}"

    def read_to_end(self) -> int:
        """Read until the program has ended; return its exit code."""
        begin = monotonic()
        while self._read():
            assert monotonic() - begin < PATIENCE, f"waited {PATIENCE} s for the end: {self.shown[-2000:]}"
        return self.process.wait(PATIENCE)

    def _read(self) -> bool:
        ended = self.process.poll() is not None  # before the look: what was drawn until then is there now
        if select.select([self._master], [], [], 0.0 if ended else 0.1)[0]:
            self.shown += self._decoder.decode(os.read(self._master, 65536))
            return True
        return not ended

    def type(self, keys: bytes) -> None:
        """Type on the keyboard."""
        os.write(self._master, keys)

    @property
    def text(self) -> str:
        """What was shown, without colours and moves of the cursor."""
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", self.shown)

    def colours(self) -> set[str]:
        """Return the codes of colours that were used; bold, dim and reset are none."""
        parts = (part for found in _COLOURS.finditer(self.shown) for part in found[1].split(";")[:1])
        return {part for part in parts if part.isdigit() and int(part) >= 30}

    def left_behind(self) -> list[str]:
        """Return, in words, what differs from the terminal as it was: nothing, where it was left clean."""
        modes: dict[str, str] = {}
        for switch in _MODES.finditer(self.shown):
            modes |= dict.fromkeys(switch[1].split(";"), switch[2])
        wrong = {"25": "l", "1049": "h", "2004": "h"}
        found = [words for mode, words in _STAYING.items() if modes.get(mode) == wrong[mode]]
        colours = _COLOURS.findall(self.shown)
        if colours and colours[-1] not in ("", "0"):
            found.append(f"the colour {colours[-1]} stays on")
        if termios.tcgetattr(self._slave) != self._before:
            found.append("echo, line or signal modes differ")
        return found

    def close(self) -> None:
        """Kill the program if it still runs, and take the terminal away."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        os.close(self._master)
        os.close(self._slave)
