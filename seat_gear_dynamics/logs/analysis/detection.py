"""Warnings held against what they warn of: detection delay, lead of the pre-warning, missed and false warnings."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.logs.analysis.batches import Warned

Array = NDArray[np.float64]

WARN, ERROR = 1, 2
"""Levels of diagnostic_msgs/DiagnosticStatus; STALE, 3, is no warning."""
JOIN = 0.3
"""s; stretches of danger closer than this are one: noise crosses an edge often, and the alarm holds as long."""
MOST_EPISODES = 20_000
"""Episodes listed; later ones are counted alone."""
Dangerous = Callable[[Array], NDArray[np.bool_]]


class Span(NamedTuple):
    """A stretch of time, s since the log's start."""

    begin: float
    end: float


@dataclass(frozen=True)
class Episode:
    """A stretch of danger and how it was warned of."""

    begin: float
    """s since the log's start"""
    end: float
    delay: float | None
    """From its begin to the first ERROR in it, s; 0 where ERROR stood already, None where none came (missed)."""
    lead: float | None
    """How long before its begin a level of at least WARN stood without a break, s; None where none did."""


@dataclass(frozen=True)
class Detection:
    """Warnings against danger over a whole log."""

    episodes: tuple[Episode, ...]
    false: tuple[Span, ...]
    """Stretches of ERROR that touch no danger."""
    false_chaotic: int
    """How many of `false` state chaotic motion: outside every band, but not without a reason."""
    errors: int
    """Stretches of ERROR in all."""
    unlisted: int
    """Episodes and stretches beyond MOST_EPISODES, which are not in the figures above."""

    @property
    def missed(self) -> int:
        """Episodes without any ERROR."""
        return sum(episode.delay is None for episode in self.episodes)

    def delays(self) -> Array:
        """Return the delays of the episodes that were not missed, s."""
        return np.array([episode.delay for episode in self.episodes if episode.delay is not None])


class DangerSpans:
    """Follows where a drive is in danger, as stretches of time; what is dangerous is told by a function of the drive.

    The function takes rows (time, speed, load, direction) and returns a flag for each.
    """

    def __init__(self, dangerous: Dangerous) -> None:
        self._dangerous = dangerous
        self.spans: list[Span] = []
        self.unlisted = 0

    def add(self, drive: Array) -> None:
        """Take rows as `Batch.drive`."""
        if not len(drive):
            return
        flags = self._dangerous(drive)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
        for first, after in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            self._join(float(drive[first, 0]), float(drive[after - 1, 0]))

    def _join(self, begin: float, end: float) -> None:
        if self.spans and begin - self.spans[-1].end <= JOIN:
            self.spans[-1] = Span(self.spans[-1].begin, end)
        elif len(self.spans) < MOST_EPISODES:
            self.spans.append(Span(begin, end))
        else:
            self.unlisted += 1


class LevelSpans:
    """Follows the warning level: stretches of constant level, and seconds by level and stated regime."""

    def __init__(self) -> None:
        self.spans: list[tuple[Span, int, str]] = []
        """(stretch, level, its first text)"""
        self.seconds: defaultdict[tuple[int, str], float] = defaultdict(float)
        """s by (level, regime)"""
        self.chaotic: list[bool] = []
        """Whether a stretch stated chaotic motion at any time."""
        self.unlisted = 0
        self._before: Warned | None = None

    def add(self, warnings: Sequence[Warned]) -> None:
        """Take warnings in order of time."""
        for warned in warnings:
            self._take(warned)
            self._before = warned

    def at_least(self, level: int) -> list[Span]:
        """Return the stretches whose level is `level` or worse, STALE not counted; neighbours joined."""
        joined: list[Span] = []
        for span, found, _ in self.spans:
            if not level <= found <= ERROR:
                continue
            if joined and joined[-1].end == span.begin:
                joined[-1] = Span(joined[-1].begin, span.end)
            else:
                joined.append(span)
        return joined

    def chaos_stated(self, within: Span) -> bool:
        """Return whether a stretch of ERROR inside `within` stated chaotic motion."""
        pairs = zip(self.spans, self.chaotic, strict=True)
        return any(
            c and s.begin >= within.begin and s.end <= within.end for (s, level, _), c in pairs if level == ERROR
        )

    def _take(self, warned: Warned) -> None:
        before = self._before
        if before is not None:
            self.seconds[before.level, before.regime] += max(warned.time - before.time, 0.0)
        same = self.spans and self.spans[-1][1] == warned.level and not self.unlisted
        if self.spans and not self.unlisted:
            span, level, text = self.spans[-1]
            self.spans[-1] = (Span(span.begin, max(warned.time, span.end)), level, text)
        if same:
            self.chaotic[-1] |= warned.regime == "chaotic"
        elif len(self.spans) < MOST_EPISODES:
            self.spans.append((Span(warned.time, warned.time), warned.level, warned.text))
            self.chaotic.append(warned.regime == "chaotic")
        else:
            self.unlisted += 1


def detect(dangers: DangerSpans, levels: LevelSpans) -> Detection:
    """Hold warnings against dangers.

    The delay runs from the first sample in danger to the first ERROR that stands before the danger has ended (or within
    JOIN after it, so that a short crossing is not called missed for the alarm's debounce). Limits: log times of samples
    and warnings are compared, so the delay holds transport and computing as well; a danger that ends with the log may
    still have been warned of.
    """
    errors, worse = levels.at_least(ERROR), levels.at_least(WARN)
    starts = np.array([span.begin for span in errors])
    pre_starts = np.array([span.begin for span in worse])
    episodes = tuple(
        Episode(danger.begin, danger.end, _delay(danger, errors, starts), _lead(danger, worse, pre_starts))
        for danger in dangers.spans
    )
    begins = np.array([danger.begin for danger in dangers.spans])
    false = tuple(span for span in errors if not _touches(span, dangers.spans, begins))
    chaotic = sum(levels.chaos_stated(span) for span in false)
    return Detection(episodes, false, chaotic, len(errors), dangers.unlisted + levels.unlisted)


def _delay(danger: Span, errors: Sequence[Span], starts: Array) -> float | None:
    """Return when the first of `errors` that overlaps `danger` began, from the danger's begin on; not below 0."""
    i = int(np.searchsorted(starts, danger.begin, side="right")) - 1
    if i >= 0 and errors[i].end >= danger.begin:
        return 0.0
    if i + 1 < len(errors) and errors[i + 1].begin <= danger.end + JOIN:
        return errors[i + 1].begin - danger.begin
    return None


def _lead(danger: Span, worse: Sequence[Span], starts: Array) -> float | None:
    i = int(np.searchsorted(starts, danger.begin, side="right")) - 1
    return danger.begin - worse[i].begin if i >= 0 and worse[i].end >= danger.begin else None


def _touches(span: Span, dangers: Sequence[Span], begins: Array) -> bool:
    i = int(np.searchsorted(begins, span.end + JOIN, side="right")) - 1
    return i >= 0 and dangers[i].end >= span.begin - JOIN
