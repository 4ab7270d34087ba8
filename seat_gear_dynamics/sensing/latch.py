"""A statement about a noisy drive that is shown as true or false without flickering."""


class Latch:
    """A statement that is shown as true once it held for `debounce`, and as false once it did not for `hold`, s."""

    def __init__(self, debounce: float, hold: float) -> None:
        self._debounce = debounce
        self._hold = hold
        self._shown: bool | None = None
        self._since: float | None = None

    def update(self, t: float, found: bool) -> bool:
        """Return what to show at time `t` (s) of a statement found true or false; the first is shown at once."""
        if self._shown is None or found == self._shown:
            self._shown, self._since = found, None
            return found
        if self._since is None:
            self._since = t
        if t - self._since >= (self._debounce if found else self._hold):
            self._shown, self._since = found, None
        return self._shown
