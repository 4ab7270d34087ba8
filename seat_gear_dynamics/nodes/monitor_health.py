"""How the solver does: its load on the processor, its restarts and the publish deadlines it missed."""

from seat_gear_dynamics.sensing import Level, Reading, Session


class SolverHealth:
    """Counts computing time against model time, and publish ticks that came more than a period late."""

    def __init__(self, publish_rate: float) -> None:
        self._period_ns = int(1e9 / publish_rate)
        self._last_tick: int | None = None
        self._computing = 0.0
        self._covered = 0.0
        self.missed = 0

    def fed(self, computing: float, reading: Reading) -> None:
        """Note one sample: the time it took, s, and the reading it gave."""
        self._computing += computing
        self._covered += reading.windows[0].duration

    def published(self, now_ns: int) -> None:
        """Note one publish tick at `now_ns`."""
        if self._last_tick is not None and now_ns - self._last_tick > 2 * self._period_ns:
            self.missed += 1
        self._last_tick = now_ns

    def report(self, name: str, session: Session) -> tuple[Level, str, str, dict[str, object]]:
        """Return level, name, text and values since the last report."""
        share = self._computing / self._covered if self._covered else 0.0
        self._computing = self._covered = 0.0
        counts = session.sensor.counts
        restarts = {key: counts[key] for key in ("gap", "clock stepped back", "diverged")}
        values: dict[str, object] = {
            "computing time per model time": share,
            "publish deadlines missed": self.missed,
            **{f"restarts, {key}": count for key, count in restarts.items()},
            "load scale": session.sensor.train.model.load_scale,
        }
        if share > 1.0:
            return Level.ERROR, name, "the model is slower than real time", values
        if counts["diverged"]:
            return Level.WARN, name, f"the solution diverged {counts['diverged']} times and was restarted", values
        return Level.OK, name, f"{1 / share:.0f} times real time" if share else "idle", values
