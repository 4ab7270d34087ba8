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


def test_what_an_earlier_run_did_is_shown_but_is_not_this_ones_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    from rich import progress as bars

    now = iter(range(1000))
    told: list[bars.Task] = []

    class Timed(bars.Progress):
        """A bar whose clock goes on by a second whenever it is read, and whose task is kept."""

        def __init__(self, *columns: bars.ProgressColumn, **options: object) -> None:
            super().__init__(*columns, get_time=lambda: float(next(now)), auto_refresh=False, **options)  # type: ignore[arg-type]

        def update(self, *arguments: object, **options: object) -> None:
            super().update(*arguments, **options)  # type: ignore[arg-type]
            told[:] = self.tasks

    monkeypatch.setattr(bars, "Progress", Timed)
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setenv("TERM", "xterm")
    with progress("regime map", begun=900) as tell:
        for done in range(901, 911):
            tell(done, 1000)
    (task,) = told
    assert (task.completed, task.total) == (910, 1000)
    # Ten in at least as many seconds; 910 in these would be a hundred times that.
    assert task.speed is not None
    assert task.speed <= 1.0
