"""Progress on standard error: seen at a terminal, silent elsewhere and with --json."""

import io
import sys

import pytest

from seat_gear_dynamics.commands.progress import progress, stages


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


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def lines(monkeypatch: pytest.MonkeyPatch, told: list[tuple[float, int, int]], begun: int = 0) -> list[str]:
    """Return what a pipe gets where (time, done, in all) is told."""
    stream, clock = io.StringIO(), Clock()
    monkeypatch.setattr(sys, "stderr", stream)
    with progress("map", begun=begun, clock=clock) as tell:
        for clock.now, done, total in told:
            tell(done, total)
    return stream.getvalue().splitlines()


def test_a_pipe_gets_a_line_each_ten_seconds_at_most_with_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    # One of 100 in each second: after 10 s 90 are left, after 20 s 80.
    found = lines(monkeypatch, [(float(second), second, 100) for second in range(1, 25)])
    assert found == ["map: 10 of 100, 1 min 30 s left", "map: 20 of 100, 1 min 20 s left"]


def test_the_time_left_is_that_of_this_run_not_of_the_one_before(monkeypatch: pytest.MonkeyPatch) -> None:
    # 900 were done before; 10 in 10 s leave 90 s for 90.
    assert lines(monkeypatch, [(10.0, 910, 1000)], begun=900) == ["map: 910 of 1000, 1 min 30 s left"]


def test_hours_are_told_as_such_and_the_end_has_no_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    found = lines(monkeypatch, [(10.0, 1, 1000), (20.0, 1000, 1000)])
    assert found == ["map: 1 of 1000, 2 h 46 min left", "map: 1000 of 1000"]


def test_where_nothing_is_known_of_the_whole_the_time_taken_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    assert lines(monkeypatch, [(12.0, 3, 0)]) == ["map: 12 s so far"]


def test_a_dumb_terminal_is_no_place_for_bars(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "dumb")
    with progress("map") as tell:
        tell(1, 2)
    assert stream.getvalue() == ""


def test_each_stage_has_a_bar_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    with stages() as tell:
        tell("reading", 5, 5)
        tell("drawing [b]", 1, 7)
    assert "5/5" in stream.getvalue()
    assert "drawing [b]" in stream.getvalue(), "a name is no markup"
    assert "1/7" in stream.getvalue()
    assert stream.getvalue().rindex("\x1b[?25h") > stream.getvalue().rindex("\x1b[?25l")
