"""The moving picture: what was heard, kept for a while, and cut into frames for each page that looks on."""

import json
from collections.abc import Mapping
from math import floor, inf, isfinite
from typing import Any, NamedTuple

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.views.colours import LEVEL_NAMES
from seat_gear_dynamics.views.dashboard import words
from seat_gear_dynamics.views.dashboard.heard import Heard, Status
from seat_gear_dynamics.views.dashboard.scene import Scene
from seat_gear_dynamics.views.dashboard.series import Series, Trend

_ROOM = 600  # samples kept; 12 s at the monitor's default rate
_TREND_STEP, _TREND_ROOM = 0.5, 1200  # s, and rows: ten minutes
_TRAIL_STEP, _TRAIL_ROOM = 0.1, 600  # s, and rows: a minute of the operating point
_LATE = 1.0  # s; a row farther behind means that the clock stepped back
_DIGITS = 5  # significant ones of a number on the page


class Cursor(NamedTuple):
    """How far a page has come; the default has seen nothing."""

    epoch: int = -1
    samples: int = 0
    windows: int = 0
    trend: int = 0
    trail: int = 0
    section: int = 0


class _Times:
    """Stamps to times since an epoch's first one, s: a small step back is a late row, a large one a new epoch."""

    def __init__(self, origin: float) -> None:
        self._origin, self._last = floor(origin), -inf

    def steps_back(self, stamp: float) -> bool:
        """Return whether a stamp is so far behind that the clock must have been set."""
        return stamp - self._origin < self._last - _LATE

    def take(self, stamp: float) -> float | None:
        """Return the time of a stamp, or None for one that is not later than the last."""
        time = stamp - self._origin
        if time <= self._last:
            return None
        self._last = time
        return time


class Board:
    """Keeps seconds of samples, minutes of trend and the latest words; gives JSON frames of what a page lacks.

    Times on the page are s since the first stamp of an epoch; a clock that steps back begins a new one, in which
    nothing of the old is left. What is measured by the ages of words comes with each frame.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._epoch, self._tick = 0, 0
        self._now: dict[str, Any] = {}
        self._calm = words.SteadyCalm()
        self._cached: dict[Cursor, tuple[str, Cursor]] = {}
        self._section_number = 0
        self._section: list[list[float]] = []
        self._begin_epoch()

    def update(self, heard: Heard, elapsed: float) -> None:
        """Take what was heard, `elapsed` s (steady) after some fixed moment."""
        self._tick += 1
        self._cached.clear()
        self._take_rows(heard)
        if heard.section is not None:
            self._section = [[_short(x), _short(y)] for x, y in heard.section[:, :2].tolist()]
            self._section_number += 1
        self._follow(heard, elapsed)
        self._now = self._words(heard)

    def frame(self, cursor: Cursor) -> tuple[str, Cursor]:
        """Return the frame (a JSON text) that brings a page from `cursor` to now, and the cursor it then has."""
        if cursor not in self._cached:
            self._cached[cursor] = self._made(cursor)
        return self._cached[cursor]

    def _made(self, cursor: Cursor) -> tuple[str, Cursor]:
        fresh = cursor.epoch != self._epoch
        seen = Cursor() if fresh else cursor
        frame: dict[str, Any] = {"kind": "frame", "tick": self._tick, "fresh": fresh, "now": self._now}
        rows = {"samples": self._samples, "windows": self._windows, "trend": self._trend.series, "trail": self._trail}
        for name, series in rows.items():
            frame[name] = series.since(getattr(seen, name))
        if fresh or seen.section != self._section_number:
            frame["section"] = self._section
        ends = {name: series.end for name, series in rows.items()}
        text = json.dumps(frame, separators=(",", ":"), allow_nan=False)
        return text, Cursor(epoch=self._epoch, section=self._section_number, **ends)

    def _begin_epoch(self) -> None:
        self._epoch += 1
        self._times: tuple[_Times, _Times] | None = None
        self._samples, self._windows = Series(_ROOM), Series(_ROOM)
        self._trend = Trend(_TREND_STEP, _TREND_ROOM)
        self._trail = Series(_TRAIL_ROOM)
        self._trailed: int | None = None

    def _take_rows(self, heard: Heard) -> None:
        for stamp, *values in heard.windows.tolist():
            if self._times is not None and self._times[0].steps_back(stamp):
                self._begin_epoch()
            if self._times is None:
                self._times = (_Times(stamp), _Times(stamp))
            time = self._times[0].take(stamp)
            if time is not None:
                self._trend.add([time, *values])
                self._windows.extend([_rounded([time, *values])])
        if self._times is None:
            return  # samples are drawn over their windows, which tell the time
        for stamp, *values in heard.samples.tolist():
            time = self._times[1].take(stamp)
            if time is not None:
                self._samples.extend([_rounded([time, *values])])

    def _follow(self, heard: Heard, elapsed: float) -> None:
        """Add the operating point to its trail."""
        old = max(heard.ages.get(name, 1e9) for name in ("speed", "load"))
        step = floor(elapsed / _TRAIL_STEP)
        if heard.speed is None or heard.load is None or old > words.DATA_SILENT or step == self._trailed:
            return
        self._trailed = step
        self._trail.extend([_rounded([elapsed, abs(heard.speed) / RPM, heard.load])])

    def _words(self, heard: Heard) -> dict[str, Any]:
        values = self._calm.steady(dict(heard.warning.values) if heard.warning else {})
        shown = self.scene.shown(heard.load, values)
        said = words.warning_words(heard, shown.covered, shown.loads if shown.outside else "", values)
        fresh = heard.ages.get("warning", 1e9) <= words.WARNING_SILENT
        judged = fresh and LEVEL_NAMES[said.level] != "STALE"
        entry, seconds = words.entry_words(values) if judged else ("unknown", None)
        known = fresh and shown.outside is None
        return {
            "speed": _optional(heard.speed, 1 / RPM),
            "load": _optional(heard.load),
            "bands": shown.bands,
            "bandsFrom": shown.source,
            "covered": shown.covered,
            "outside": shown.outside,
            "level": said.level,
            "levelName": LEVEL_NAMES[said.level],
            "headline": said.headline,
            "reason": said.reason,
            "advice": said.advice,
            "caution": self._caution(said.level, heard.load, values) if fresh else None,
            "trip": bool(heard.in_band) and fresh,
            "entry": entry,
            "entrySeconds": seconds,
            "calm": words.number(values, "nearest calm speed (r/min)") if known else None,
            "calmWords": words.calm_words(values, said.level) if known else "unknown",
            "motion": words.motion_words(values) if fresh else "unknown",
            "values": [list(pair) for pair in heard.warning.values] if heard.warning else [],
            "recorder": words.recorder_picture(heard.recorder, heard.ages.get("recorder")),
            "health": [_health(status) for status in heard.health],
            "old": [name for name in ("speed", "load", "mesh", "section") if _is_old(heard, name)],
        }

    def _caution(self, level: int, load: float | None, values: Mapping[str, str]) -> str | None:
        """Return what the map says against the speed that is advised, or against the present one where it is clear."""
        if LEVEL_NAMES[level] == "STALE":
            return None
        key = "speed (r/min)" if LEVEL_NAMES[level] == "OK" else "nearest calm speed (r/min)"
        return self.scene.caution(words.number(values, key), load, values)


def _is_old(heard: Heard, name: str) -> bool:
    return heard.ages.get(name, 1e9) > words.DATA_SILENT


def _health(status: Status) -> dict[str, Any]:
    level = status.level if 0 <= status.level < len(LEVEL_NAMES) else len(LEVEL_NAMES) - 1
    return {"name": status.name, "level": level, "text": status.message}


def _optional(value: float | None, factor: float = 1.0) -> float | None:
    return None if value is None or not isfinite(value) else _short(value * factor)


def _rounded(row: list[float]) -> list[float]:
    """Return a row with its time to the millisecond and the rest as short as the page can use."""
    return [round(row[0], 3), *(_short(value) for value in row[1:])]


def _short(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
