"""Where the live view is drawn: redrawn in place on a terminal, line by line elsewhere."""

from types import TracebackType
from typing import Protocol

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from seat_gear_dynamics.views.live import HEIGHT, WIDTH, plain_line, render
from seat_gear_dynamics.views.live_state import LiveState

FRAME = 0.1
"""Seconds between two frames on a terminal."""
PLAIN = 1.0
"""Seconds between two lines elsewhere."""


class Screen(Protocol):
    """What shows a LiveState while its `with` block lasts."""

    period: float
    """Seconds between two calls of `show`."""

    def __enter__(self) -> "Screen": ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def show(self, state: LiveState) -> None:
        """Show the state as it is now."""

    def say(self, line: str) -> None:
        """Show a line that stays, such as a node's log."""


def is_terminal(console: Console) -> bool:
    """Return whether somebody looks on at a terminal that can be drawn on.

    FORCE_COLOR asks for colour, not for a cursor that moves about in a file: the stream itself is asked.
    """
    return not console.quiet and console.file.isatty() and not console.is_dumb_terminal


def screen_on(console: Console, *, plain_period: float = PLAIN) -> Screen:
    """Return the live view where `console` is a terminal, else plain lines at least every `plain_period` s apart.

    Colour follows the console: none with NO_COLOR, and with TERM=dumb the view is plain lines.
    """
    return LiveScreen(console) if is_terminal(console) else PlainScreen(console, plain_period)


class LiveScreen:
    """The view redrawn in place; lines that stay scroll by above it. The terminal's modes are left alone."""

    period = FRAME

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live = Live(console=console, auto_refresh=False, vertical_overflow="crop")

    def __enter__(self) -> "LiveScreen":
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.stop()

    def show(self, state: LiveState) -> None:
        """Draw the state: the whole view, or one line where the terminal is too small for it now."""
        self._live.update(self._fitting(state), refresh=True)

    def say(self, line: str) -> None:
        """Print a line above the view."""
        self._console.print(Text(line), soft_wrap=True)

    def _fitting(self, state: LiveState) -> RenderableType:
        width, height = self._console.size
        if width >= WIDTH and height > HEIGHT:
            return Group(render(state), Text())  # a line for the echo of keys: in the last column it would wrap
        return Text(plain_line(state), no_wrap=True, overflow="ellipsis")


class PlainScreen:
    """A line when the monitor is first heard, whenever the level of its warning changes, and else every `every` s."""

    period = PLAIN

    def __init__(self, console: Console, every: float) -> None:
        self._console, self._every = console, every
        self._due, self._said = 0.0, (-1, False)

    def __enter__(self) -> "PlainScreen":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Nothing was taken from the stream."""

    def show(self, state: LiveState) -> None:
        """Print the state, where it is due or its level is another one."""
        now = state.level, bool(state.details)
        if state.elapsed >= self._due or now != self._said:
            self._due, self._said = state.elapsed + self._every, now
            self.say(plain_line(state))

    def say(self, line: str) -> None:
        """Print a line."""
        self._console.print(Text(line), soft_wrap=True)
        if not self._console.quiet:
            self._console.file.flush()  # who reads a pipe reads along
