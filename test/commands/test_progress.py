"""Progress on standard error: seen at a terminal, silent elsewhere and with --json."""

import io
import sys

import pytest

from seat_gear_dynamics.commands.progress import progress


class Terminal(io.StringIO):
    """A standard error that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def shown(monkeypatch: pytest.MonkeyPatch, *, terminal: bool, quiet: bool) -> str:
    stream = Terminal() if terminal else io.StringIO()
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", stream)
    with progress("regime map", quiet=quiet) as tell:
        for done in range(1, 4):
            tell(done, 3)
    return stream.getvalue()


def test_a_terminal_sees_what_is_done_and_of_how_much(monkeypatch: pytest.MonkeyPatch) -> None:
    text = shown(monkeypatch, terminal=True, quiet=False)
    assert "regime map" in text
    assert "3/3" in text


@pytest.mark.parametrize(("terminal", "quiet"), [(False, False), (True, True)])
def test_nobody_else_does(monkeypatch: pytest.MonkeyPatch, terminal: bool, quiet: bool) -> None:
    assert shown(monkeypatch, terminal=terminal, quiet=quiet) == ""
