"""Where the live view is drawn: in place on a terminal, one line where it is small, plain lines elsewhere."""

import io
import re

import pytest
from rich.console import Console

from seat_gear_dynamics.views.live import HEIGHT, WIDTH
from seat_gear_dynamics.views.live_screen import LiveScreen, PlainScreen, is_terminal, screen_on
from seat_gear_dynamics.views.live_state import LiveState


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def console(stream: io.StringIO, *, size: tuple[int, int] = (80, 24), quiet: bool = False, **settings: str) -> Console:
    environment = {"TERM": "xterm-256color", **settings}
    return Console(file=stream, width=size[0], height=size[1], quiet=quiet, _environ=environment)


def state(elapsed: float = 0.0, level: int = 3, **details: str) -> LiveState:
    return LiveState("bench", ((1349.0, 1359.0),), 2200.0, 0.0258, elapsed=elapsed, level=level, details=details)


@pytest.mark.parametrize(
    ("stream", "settings", "terminal"),
    [
        (Terminal(), {}, True),
        (Terminal(), {"NO_COLOR": "1"}, True),
        (Terminal(), {"TERM": "dumb"}, False),
        (io.StringIO(), {}, False),
        (io.StringIO(), {"FORCE_COLOR": "1"}, False),
    ],
    ids=["terminal", "NO_COLOR", "dumb", "pipe", "pipe with FORCE_COLOR"],
)
def test_only_a_terminal_that_can_be_drawn_on_is_drawn_on(
    stream: io.StringIO, settings: dict[str, str], terminal: bool
) -> None:
    on = Console(file=stream, _environ={"TERM": "xterm-256color", **settings})
    assert is_terminal(on) is terminal
    assert isinstance(screen_on(on), LiveScreen if terminal else PlainScreen)


def test_with_json_nothing_is_shown() -> None:
    stream = Terminal()
    with screen_on(console(stream, quiet=True)) as screen:
        screen.show(state())
        screen.say("a line")
    assert stream.getvalue() == ""


def test_a_frame_has_the_view_and_a_line_for_the_echo_of_keys() -> None:
    stream = Terminal()
    with screen_on(console(stream, NO_COLOR="1")) as screen:
        screen.show(state())
        drawn = stream.getvalue()
    frame = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", drawn).split("\n")
    assert len(frame) == HEIGHT + 1
    assert frame[-1] == "", "the cursor waits where two letters do not wrap"
    assert {len(line) for line in frame[:-1]} == {WIDTH}


def test_the_cursor_is_shown_again_also_after_an_error() -> None:
    stream = Terminal()

    def fail() -> None:
        with screen_on(console(stream)) as screen:
            screen.show(state())
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    shown = stream.getvalue()
    assert shown.rindex("\x1b[?25h") > shown.rindex("\x1b[?25l")


@pytest.mark.parametrize("size", [(79, 24), (80, HEIGHT)], ids=["narrow", "low"])
def test_a_terminal_that_is_too_small_gets_one_line(size: tuple[int, int]) -> None:
    stream = Terminal()
    with screen_on(console(stream, size=size, NO_COLOR="1")) as screen:
        screen.show(state())
        drawn = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", stream.getvalue())
    assert "STALE" in drawn
    assert "\n" not in drawn
    assert len(drawn) <= size[0]


def test_a_line_that_stays_is_printed_above_the_view_as_it_is() -> None:
    stream = Terminal()
    with screen_on(console(stream)) as screen:
        screen.show(state())
        screen.say("[INFO] [12.5] [gear_monitor]: ready")
    assert "[INFO] [12.5] [gear_monitor]: ready" in stream.getvalue(), "neither markup nor colours"


def test_plain_lines_come_when_due_and_whenever_the_level_changes() -> None:
    stream = io.StringIO()
    with screen_on(console(stream), plain_period=10.0) as screen:
        for second in range(25):
            screen.show(state(float(second), level=2 if second == 13 else 3, motion="periodic"))
    seconds = [float(line.split()[0]) for line in stream.getvalue().splitlines()]
    # At once; after 10 s; at the change to ERROR and back from it; 10 s later.
    assert seconds == [0.0, 10.0, 13.0, 14.0, 24.0]
