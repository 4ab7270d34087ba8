"""What the recorder says of itself in `/diagnostics`."""

from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticStatus

from seat_gear_dynamics.logs.recording import Recording
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.recorder_topics import Subscriptions
from seat_gear_dynamics.sensing import Level

_LATE = 1.0  # s; a message that waited so long says that the recorder falls behind


class RecorderReport:
    """Gathers state, files, disk and counts of a recorder; `heard` notes how long each message waited."""

    def __init__(self, recording: Recording, subscriptions: Subscriptions, names: Mapping[str, str]) -> None:
        self._recording, self._subscriptions = recording, subscriptions
        self._names = names
        self._lag_ns = self._lost = 0

    def heard(self, lag_ns: int) -> None:
        """Note that a message came this long after it had been published."""
        self._lag_ns = max(self._lag_ns, lag_ns)

    def status(self, name: str) -> DiagnosticStatus:
        """Return the status since the last one: ERROR for a log that ended, WARN for what may end or thin it."""
        lag, self._lag_ns = self._lag_ns * 1e-9, 0
        lost = self._recording.lost.total()
        fresh, self._lost = lost - self._lost, lost
        level, text = self._judge(lag, fresh)
        return messages.status(level, name, text, {**self._values(lag), **self._counts()})

    def _judge(self, lag: float, lost: int) -> tuple[Level, str]:
        recording = self._recording
        if recording.state == "failed" or (recording.failure and recording.state == "stopped"):
            return Level.ERROR, recording.failure or "the log could not be begun"
        space, problems = recording.space, self._subscriptions.problems
        if space is not None and space.room != "enough":
            return Level.WARN, f"{recording.state}; the disk is nearly full: {space.text}"
        if lost:
            return Level.WARN, f"{recording.state}; {lost} messages were overwritten before they were read"
        if lag > _LATE:
            return Level.WARN, f"{recording.state}; {lag:.1f} s behind"
        if problems:
            return Level.WARN, f"{recording.state}; {next(iter(problems.values()))}"
        return Level.OK, recording.state

    def _values(self, lag: float) -> dict[str, object]:
        recording, space = self._recording, self._recording.space
        totals = recording.totals.values()
        return {
            "state": recording.state,
            "file": recording.files[-1] if recording.files else "none",
            "received": recording.received.total(),
            "written": sum(count.written for count in totals),
            "dropped": sum(count.dropped for count in totals),
            "lost unread": recording.lost.total(),
            "datagrams dropped by the system": recording.datagrams,
            "came while not recording": recording.not_recorded.total(),
            "longest wait of a message (s)": lag,
            "snapshots": len(recording.snapshots),
            "last snapshot": recording.snapshots[-1] if recording.snapshots else "none",
            "disk free (MB)": space.free / 1e6 if space else None,
            "time to full (s)": space.time_to_full if space else None,
            "not there yet": ", ".join(self._subscriptions.missing) or "none",
            **{f"problem {i + 1}": text for i, text in enumerate(self._subscriptions.problems.values())},
        }

    def _counts(self) -> dict[str, object]:
        counts: dict[str, object] = {}
        for name, count in self._recording.totals.items():
            short = self._names.get(name, name)
            counts[f"{short} received"] = count.received
            counts[f"{short} written"] = count.written
            counts[f"{short} dropped"] = count.dropped
            counts[f"{short} lost unread"] = self._recording.lost[name]
        return counts
