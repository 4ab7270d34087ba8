"""How the monitor's inputs do: rate, age and gaps of each quantity, and the samples that could not be used."""

from collections import Counter, deque
from collections.abc import Callable

from seat_gear_dynamics.nodes.diagnostics import Status
from seat_gear_dynamics.sensing import Level

REASONS = (
    "not finite",
    "absurd",
    "implausible",
    "duplicate",
    "late",
    "joint not named",
    "no stamp",
    "no clock",
)
"""Why a sample is refused, as it is counted."""
_LATE = 0.1  # s; a sample that waited so long says that the node falls behind, or that clocks differ
_HOLD_UPS = 3


class Wakefulness:
    """Knows when the node was held up, from a tick that should come each period; times are of the node's clock, ns.

    Time in which the node did not run says nothing of its inputs: what came meanwhile may still be unread, as
    executors call timers before subscriptions, and the middleware has yet to read its sockets.

    Limit: the last three hold-ups are remembered, so that a node that is late at every tick finds silence as well.
    """

    def __init__(self, now: int, period: int) -> None:
        """Expect the first tick a period after `now`."""
        self._ticked, self._period = now, period
        self._spans: deque[tuple[int, int]] = deque(maxlen=_HOLD_UPS)

    def tick(self, now: int) -> None:
        """Note a tick; one that comes more than a period late ends a hold-up."""
        self._spans.extend(self._running(now))
        self._ticked = now

    def held_up(self, since: int, now: int) -> int:
        """Return for how long of the time since then the node did not run."""
        return sum(max(0, end - max(begin, since)) for begin, end in (*self._spans, *self._running(now)))

    def _running(self, now: int) -> list[tuple[int, int]]:
        return [(self._ticked + self._period, now)] if now - self._ticked > 2 * self._period else []


class InputHealth:
    """Follows one quantity, speed or load; times are those of the node's clock, in ns."""

    def __init__(
        self,
        name: str,
        topic: str,
        now: Callable[[], int],
        held_up: Callable[[int, int], int],
        limit: Callable[[], float],
        publishers: Callable[[], int],
    ) -> None:
        """`held_up` gives the time between two in which the node did not run, `publishers` how many are matched.

        `limit` gives the silence, s, after which the quantity is missing.
        """
        self.name = name
        self._topic, self._now, self._held_up, self._limit, self._publishers = topic, now, held_up, limit, publishers
        self._received = self._reported = 0
        self._begin = now()
        self.forget()

    def forget(self) -> None:
        """Forget when the quantity came: the clock has jumped. Counts are kept."""
        self._heard: int | None = None
        self._used: int | None = None
        self._fault = ""
        self._gap = 0
        self._begin = self._now()

    def heard(self, now: int) -> None:
        """Note a message."""
        if self._heard is not None:
            self._gap = max(self._gap, now - self._heard)
        self._heard = now
        self._received += 1

    def used(self, now: int) -> None:
        """Note that the message could be used."""
        self._used = now

    def refused(self, text: str) -> None:
        """Note why a message could not be used."""
        self._fault = text

    def silence(self) -> str | None:
        """Return in words that the quantity is missing, or None."""
        if self._heard is None:
            return f"no {self.name} received yet"
        limit, now = self._limit(), self._now()
        if self._missed(self._heard, now) > limit:
            return f"no {self.name} for more than {limit:g} s"
        if self._used is not None and self._missed(self._used, now) <= limit:
            return None
        since = "received yet" if self._used is None else f"for more than {limit:g} s"
        return f"no {self.name} that can be used {since}: {self._fault}" if self._fault else None

    def _missed(self, then: int, now: int) -> float:
        """Return for how long, s, the node ran since then."""
        return (now - then - self._held_up(then, now)) * 1e-9

    def run(self, status: Status) -> None:
        """STALE while silent, ERROR where messages come and none can be used, WARN for gaps and two publishers."""
        now, silence, limit = self._now(), self.silence(), self._limit()
        gap = max(self._gap, 0 if self._heard is None else now - self._heard) * 1e-9
        values, came = self._values(now, gap), self._received > self._reported
        self._gap, self._reported, self._begin = 0, self._received, now
        slow = f"it comes with gaps of up to {gap:.2g} s, {limit:g} s is allowed" if came and gap > limit else ""
        if silence is not None:
            level = Level.ERROR if "that can be used" in silence else Level.STALE
            status.say(level, f"{silence}; {slow}" if slow else silence, values)
            return
        status.say(Level.OK, f"{self.name}: {values[f'{self.name} rate (Hz)']:.4g} Hz", values)
        if slow:
            status.say(Level.WARN, f"{self.name}: {slow}")
        if self._publishers() > 1:
            status.say(Level.WARN, f"{self._publishers()} publishers on {self._topic}: their values are mixed")

    def _values(self, now: int, gap: float) -> dict[str, object]:
        name, span = self.name, max((now - self._begin) * 1e-9, 1e-9)
        return {
            f"{name} rate (Hz)": (self._received - self._reported) / span,
            f"{name} age (s)": None if self._heard is None else _age(self._heard, now),
            f"{name} longest gap (s)": gap,
            f"{name} messages": self._received,
            f"{name} publishers": self._publishers(),
        }


class SampleHealth:
    """Counts the samples that were used and those that were not, and the longest wait of one."""

    name = "samples"

    def __init__(self) -> None:
        self._accepted = self._without_load = self._jumps = 0
        self._refused: Counter[str] = Counter()
        self._reported: Counter[str] = Counter()
        self._last = ""
        self._wait = 0

    def accepted(self) -> None:
        """Note a sample that the model took."""
        self._accepted += 1

    def without_load(self) -> None:
        """Note a speed that came while no load was known."""
        self._without_load += 1

    def jumped(self) -> None:
        """Note that the clock stepped back."""
        self._jumps += 1

    def waited(self, ns: int) -> None:
        """Note how long after its publication a sample was taken; negative where the publisher's clock is ahead."""
        if abs(ns) > abs(self._wait):
            self._wait = ns

    def refuse(self, reason: str, text: str) -> None:
        """Count a sample under one of REASONS."""
        self._refused[reason] += 1
        self._last = text

    def run(self, status: Status) -> None:
        """WARN for samples refused or late since the last report."""
        fresh = self._refused.total() - self._reported.total()
        self._reported = self._refused.copy()
        wait, self._wait = self._wait * 1e-9, 0
        status.say(
            Level.OK,
            f"{self._accepted} samples used",
            {
                "samples accepted": self._accepted,
                **{f"refused, {reason}": self._refused[reason] for reason in REASONS},
                "speeds without a load": self._without_load,
                "clock stepped back": self._jumps,
                "longest wait of a sample (s)": wait,
            },
        )
        if fresh:
            status.say(Level.WARN, f"{fresh} samples refused, the last: {self._last}")
        if wait > _LATE:
            status.say(Level.WARN, f"samples were taken up to {wait:.2g} s late: busy, or the clocks differ")
        if wait < -_LATE:
            status.say(Level.WARN, f"samples come from {-wait:.2g} s ahead: the sender's clock differs")


def _age(then: int, now: int) -> float:
    return (now - then) * 1e-9
