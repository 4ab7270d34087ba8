"""Telling a person that something is being compiled, and only then: code that is taken from the cache is no news.

Compiled code is kept on disk for the processor it was made for: numba's cache asks for its name and its features, so a
home folder that several machines share holds code for each of them.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.event import Listener, install_listener

Announce = Callable[[str], object]
"""Gets a sentence for people before something that takes some seconds."""

COMPILING = "Compiling the gear model for this machine's processor: some seconds, once; then it is kept."


@contextmanager
def announced(announce: Announce | None, text: str = COMPILING) -> Iterator[None]:
    """Call `announce` with `text` once, before the first function that is really compiled in this context.

    Whatever thread compiles it, and whoever asked for it: numba itself tells. None says nothing. Limit: a function that
    numba compiles for somebody else in this process meanwhile counts as well.
    """
    if announce is None:
        yield
        return
    with _installed("numba:compile", _Once(announce, text)):
        yield


class _Once(Listener):
    """Says its text at the first event and is silent from then on."""

    def __init__(self, announce: Announce, text: str) -> None:
        self._announce: Announce | None = announce
        self._text = text

    def on_start(self, event: Any) -> None:
        """Take the begin of a compilation, under numba's lock for compilers: two threads cannot both be the first."""
        announce, self._announce = self._announce, None
        if announce is not None:
            announce(self._text)

    def on_end(self, event: Any) -> None:
        """Take the end of a compilation, which is no news."""


_installed: Any = install_listener
