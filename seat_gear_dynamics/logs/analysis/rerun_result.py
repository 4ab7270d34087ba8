"""What a replay found: how each topic compared, and what to say where it differs."""

from __future__ import annotations

from dataclasses import dataclass

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.what_if import other_bands


@dataclass
class Compared:
    """How the messages of one topic compared."""

    topic: str
    messages: int = 0
    equal: int = 0
    first_difference: str | None = None
    """Stamp (or log time), what, and both values; None where all are equal."""

    def take(self, at: str, difference: str | None) -> None:
        """Count one message."""
        self.messages += 1
        if difference is None:
            self.equal += 1
        elif self.first_difference is None:
            self.first_difference = f"{at}: {difference}"


@dataclass(frozen=True)
class Rerun:
    """A finished replay."""

    samples: int
    """Inputs fed."""
    begins: str
    """`first input`, or `model state` where the log begins amid a run; then sections and warnings are not compared."""
    topics: tuple[Compared, ...]
    windows_before_log: int
    """1 where the window of the first force message began at a message before it that the log does not hold, else 0.

    It is equal bit for bit from a later sample on; it is counted here and not among those that were compared.
    """
    silences: int
    """Warnings of silence or a reset, which are taken over from the log and not compared."""
    forces: dict[str, tuple[dict[str, float], dict[str, float]]]
    """Mesh → (logged, replayed) mean, min, max and rms over all compared messages, N."""
    level_seconds: tuple[dict[int, float], dict[int, float]]
    """s by warning level, as logged and as replayed."""
    bands: tuple[str | None, str]
    """Label of the bands that warnings were judged by: as the log says (None: it does not), and in the replay."""
    damage: str | None
    """What of the log could not be read: where inputs are missing, all that follows differs."""
    setting_changes: int | None
    """Changes of the monitor's thresholds, and their declarations, that were followed; None where the log has no
    `/parameter_events` to tell of them."""

    @property
    def messages(self) -> int:
        """Logged force messages that were compared."""
        return self.topics[0].messages

    @property
    def equal(self) -> int:
        """Of these, equal bit for bit in all eight statistics."""
        return self.topics[0].equal

    @property
    def first_difference(self) -> str | None:
        """The first difference by topic, forces before all; None where all are equal."""
        found = (f"{t.topic}, {t.first_difference}" for t in self.topics if t.first_difference)
        return next(found, None)

    @property
    def threshold_words(self) -> str | None:
        """Sentences where nothing but warnings differs, by the same bands: the thresholds may have been others."""
        warnings = self.topics[-1]
        if warnings.topic != topics.CHAOS_WARNING.name or warnings.first_difference is None or other_bands(*self.bands):
            return None
        if any(each.first_difference for each in self.topics[:-1]):
            return None
        followed = "the log has no /parameter_events, by which a replay follows changes"
        if self.setting_changes is not None:
            followed = f"what the log tells of was followed, changes: {self.setting_changes}"
        return (
            f"Nothing but warnings differs, first the one at {warnings.first_difference.partition(': ')[0]}. The "
            f"monitor's thresholds may have been changed at run time ({followed}), or may have been others from its "
            f"start: name those with --set, as in --set margin_rpm=60."
        )

    @property
    def identical(self) -> bool:
        """Whether every message that was compared is equal."""
        return all(t.equal == t.messages for t in self.topics)
