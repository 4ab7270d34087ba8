"""How the solver does: its load on the processor, its restarts and the publish deadlines it missed."""

from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.diagnostics import Status
from seat_gear_dynamics.sensing import Level, Reading, Session

_RESTARTS = ("gap", "clock stepped back", "diverged")
_MISSED = 0.05  # share of publish ticks; below it the machine is only busy now and then


class SolverHealth:
    """Counts computing time against model time, and publish ticks that came more than a period late."""

    name = "solver"

    def __init__(self, session: Session, publish_rate: float) -> None:
        self._session = session
        self.pace(publish_rate)
        self._computing = self._covered = self._longest = 0.0
        self._ticks = self._missed = 0
        self._reported = (0, 0, 0)

    def pace(self, publish_rate: float) -> None:
        """Expect ticks at this rate, Hz, from now on."""
        self._period_ns = int(1e9 / publish_rate)
        self._last_tick: int | None = None

    def fed(self, computing: float, reading: Reading) -> None:
        """Note one sample: the time it took, s, and the reading it gave."""
        self._computing += computing
        self._longest = max(self._longest, computing)
        self._covered += reading.windows[0].duration

    def published(self, now_ns: int) -> None:
        """Note one publish tick at `now_ns`."""
        self._ticks += 1
        if self._last_tick is not None and now_ns - self._last_tick > 2 * self._period_ns:
            self._missed += 1
        self._last_tick = now_ns

    def run(self, status: Status) -> None:
        """ERROR when slower than real time; WARN for missed deadlines and divergence since the last report."""
        counts = self._session.sensor.counts
        share = self._computing / self._covered if self._covered else 0.0
        longest = self._longest
        self._computing = self._covered = self._longest = 0.0
        present = (self._ticks, self._missed, counts["diverged"])
        ticks, missed, diverged = (now - then for now, then in zip(present, self._reported, strict=True))
        self._reported = present
        status.say(
            Level.OK,
            f"{1 / share:.0f} times real time" if share else "idle",
            {
                "computing time per model time": share,
                "longest computing time of a sample (s)": longest,
                "publish deadlines missed": self._missed,
                **{f"restarts, {key}": counts[key] for key in _RESTARTS},
                "load scale": self._session.sensor.train.model.load_scale,
            },
        )
        if share > 1.0:
            status.say(Level.ERROR, "the model is slower than real time")
        if diverged:
            status.say(Level.WARN, f"the solution diverged {diverged} times and was restarted")
        if missed > _MISSED * ticks:
            status.say(Level.WARN, f"{missed} of {ticks} publish deadlines missed")


class WarningHealth:
    """The warning as a part of the node's health."""

    name = "warning"

    def __init__(self, session: Session) -> None:
        self._session = session

    def run(self, status: Status) -> None:
        """Say the verdict."""
        verdict = self._session.verdict
        status.say(verdict.level, verdict.reason, messages.warning_values(verdict, self._session.sample))
