"""Scores of labelled runs: missed and false warnings, delays, notice, chatter and ROC."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid
from scipy.special import chdtri

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.sensing import AlarmSettings, Level
from seat_gear_dynamics.studies.warning_quality.run import SCORES, Record
from seat_gear_dynamics.studies.warning_quality.truth import Truth

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

LONGEST_UNSEEN = 0.5
"""s inside a band after which a stay without ERROR counts as missed."""
CALM_BEFORE = 1.2
"""s that a run must have been outside every band before an entry whose notice is measured."""
LONGEST_NOTICE = 2.0
"""s; notice is not counted beyond: a warning that stands for ever announces nothing."""
SETTLED = 1.0
"""s after which level changes count as chatter, and samples for the ROC."""
MEMORY = 1.0
"""s for which a cause explains a level: hold 0.3, and the record of the motion, which may be half a second long."""
AHEAD = 0.5
"""s that the second ROC looks ahead."""
_MOVED = 1 * RPM  # rad/s from where a run began
THINNED = 5  # samples from one to the next of the ROC: neighbours say the same
_MAP_WARNS = 0.25  # probability by the map from which a warning is owed
_THRESHOLDS = np.concatenate([[0.0], np.geomspace(1e-3, 0.5, 60), 1 - np.geomspace(0.5, 1e-3, 60)[1:], [1.0 + 1e-9]])


@dataclass(frozen=True, eq=False)
class Roc(Plottable, figure="warning_quality:plot_roc", table="studies:roc_table"):
    """True and false positive rates over the thresholds of a score, from the highest to the lowest."""

    thresholds: Array
    true_rate: Array
    false_rate: Array
    positives: int
    negatives: int

    @property
    def area(self) -> float:
        """Area under the curve; 0.5 is chance."""
        return float(trapezoid(self.true_rate, self.false_rate))


@dataclass
class Tally:
    """Counts over runs; add them with `+`."""

    runs: int = 0
    seconds: float = 0.0
    stays: int = 0
    """Stretches surely inside a band of more than LONGEST_UNSEEN."""
    missed: int = 0
    """Of these, without ERROR within LONGEST_UNSEEN."""
    unseen: int = 0
    """Of these, without any ERROR."""
    false_errors: int = 0
    false_by_motion: int = 0
    """Of the false errors, those that state chaotic motion."""
    doubtful_errors: int = 0
    """ERROR where the motion was neither surely calm nor surely chaotic, or not steady, and no band near."""
    false_warnings: int = 0
    """WARN or ERROR with no cause for either."""
    calm_seconds: float = 0.0
    """Surely outside every band, and not surely chaotic: when an ERROR can be false."""
    edge_changes: int = 0
    edge_seconds: float = 0.0
    edge_runs: int = 0
    chattering: int = 0
    """Of the runs on an edge, those with more than one level change after SETTLED."""
    chaos_stays: int = 0
    """Stretches of surely chaotic motion outside bands, longer than 1 s."""
    chaos_seen: int = 0
    """Of these, with ERROR."""
    delays: list[float] = field(default_factory=list)
    """From the first sample beyond a band's edge to ERROR, s, of stays with ERROR."""
    notices: list[tuple[float, float]] = field(default_factory=list)
    """(acceleration in r/min per s, how long WARN or worse stood before a ramp's entry, s)."""
    leads: list[float] = field(default_factory=list)
    """For each of `notices` how long before its entry the drive had begun to move, s: before that nothing announces it
    but a band nearby."""

    def __add__(self, other: "Tally") -> "Tally":
        values = {name: getattr(self, name) + getattr(other, name) for name in vars(self)}
        return Tally(**values)

    def per_hour(self, count: int) -> float:
        """Return events per hour of all runs; NaN without time."""
        return 3600 * count / self.seconds if self.seconds else float("nan")


def tally(record: Record, true: Truth, settings: AlarmSettings) -> Tally:
    """Return the counts of one run."""
    found = Tally(runs=1, seconds=float(record.time[-1]))
    error = record.level == Level.ERROR
    step = record.scenario.sample_time
    _stays(found, record, true, error, step)
    _false(found, record, true, error, settings)
    _notices(found, record, true)
    found.calm_seconds = float((true.outside & ~true.chaotic).sum()) * step
    if record.scenario.family == "edge":
        late = record.level[record.time >= SETTLED]
        changes = int((np.diff(late) != 0).sum())
        found.edge_changes, found.edge_runs, found.edge_seconds = changes, 1, len(late) * step
        found.chattering = int(changes > 1)
    return found


def poisson_upper(count: int, confidence: float = 0.95) -> float:
    """Return the upper bound of an expected count of which `count` were seen, one-sided, exact (Garwood 1936)."""
    return float(chdtri(2 * (count + 1), 1 - confidence)) / 2


def rates(score: Array, label: Flags) -> Roc:
    """Return the ROC of `score` (n,) for `label` (n,), NaN left out; raises ValueError where one class is missing."""
    kept = np.isfinite(score)
    yes, no = score[kept & label], score[kept & ~label]
    if not len(yes) or not len(no):
        raise ValueError(
            f"A ROC was asked of {len(yes)} positive and {len(no)} negative samples; expected some of both."
        )
    thresholds = np.unique(np.concatenate([_THRESHOLDS, np.quantile(score[kept], np.linspace(0, 1, 201))]))[::-1]
    shares = [[(values >= each).mean() for each in thresholds] for values in (yes, no)]
    return Roc(thresholds, np.array(shares[0]), np.array(shares[1]), len(yes), len(no))


def samples(record: Record, true: Truth) -> tuple[Array, Flags, Flags]:
    """Return (scores (m, 4), danger now, danger within AHEAD) of the samples whose label is sure.

    Danger now is being surely inside a band or in surely chaotic motion; none is being surely outside in surely calm
    motion. Danger ahead is entering a band within AHEAD as it came about.
    """
    sure = true.inside | true.chaotic | (true.outside & true.calm)
    kept = np.flatnonzero(sure & (record.time >= SETTLED) & np.isfinite(record.scores[:, 0]))[::THINNED]
    now = (true.inside | true.chaotic)[kept]
    return record.scores[kept], now, now | (true.ahead[kept] <= AHEAD)


def rocs(drawn: Sequence[tuple[Array, Flags, Flags]]) -> dict[str, Roc]:
    """Return the ROC of each score for danger now, and of the fused one for danger within AHEAD as `ahead`."""
    scores = np.concatenate([each[0] for each in drawn])
    now, ahead = (np.concatenate([each[k] for each in drawn]) for k in (1, 2))
    found = {name: rates(scores[:, column], now) for column, name in enumerate(SCORES)}
    found["ahead"] = rates(scores[:, 0], ahead)
    return found


def spans(flags: Flags) -> list[tuple[int, int]]:
    """Return (first, after last) of each run of true flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _stays(found: Tally, record: Record, true: Truth, error: Flags, step: float) -> None:
    for first, after in spans(true.inside):
        if (after - first) * step <= LONGEST_UNSEEN:
            continue
        found.stays += 1
        seen = np.flatnonzero(error[first:after])
        outside = np.flatnonzero(true.distance[:first] > 0)
        begin = int(outside[-1]) + 1 if len(outside) else 0
        if not len(seen):
            found.unseen += 1
        if not len(seen) or seen[0] * step > LONGEST_UNSEEN:
            found.missed += 1
        if len(seen):
            at = begin + int(np.argmax(error[begin:after])) if error[begin:after].any() else after
            found.delays.append((at - begin) * step)
    for first, after in spans(true.chaotic & true.outside):
        if (after - first) * step > 1.0:
            found.chaos_stays += 1
            found.chaos_seen += int(error[first:after].any())


def _false(found: Tally, record: Record, true: Truth, error: Flags, settings: AlarmSettings) -> None:
    cause, doubt = ~true.outside | true.chaotic, ~true.calm
    unexplained = error & ~_lately(cause, record)
    for first, after in spans(unexplained):
        if _lately(doubt, record)[first:after].any():
            found.doubtful_errors += 1
        else:
            found.false_errors += 1
            found.false_by_motion += int(record.by_motion[first:after].any())
    reach = settings.margin + 2 * settings.hysteresis
    near = cause | doubt | (true.distance <= reach) | (true.ahead <= AHEAD + settings.horizon)
    near |= record.scores[:, SCORES.index("map")] >= _MAP_WARNS
    warned = (record.level == Level.WARN) | error
    found.false_warnings += len(spans(warned & ~_lately(near, record)))


def _lately(flags: Flags, record: Record) -> Flags:
    """Return where `flags` held at some time in the last MEMORY."""
    count = np.concatenate([[0], np.cumsum(flags)])
    back = round(MEMORY / record.scenario.sample_time)
    index = np.arange(1, len(flags) + 1)
    return np.asarray(count[index] - count[np.maximum(index - back - 1, 0)] > 0)


def _notices(found: Tally, record: Record, true: Truth) -> None:
    if not record.scenario.acceleration:
        return
    step, least = record.scenario.sample_time, round(CALM_BEFORE / record.scenario.sample_time)
    for first, _ in spans(true.distance <= 0):
        if first < least or (true.distance[first - least : first] <= 0).any():
            continue
        warned = record.level[:first][::-1]
        standing = np.isin(warned, (Level.WARN, Level.ERROR))
        length = len(standing) if standing.all() else int(np.argmin(standing))
        found.notices.append((record.scenario.acceleration, min(length * step, LONGEST_NOTICE)))
        found.leads.append((first - int(np.argmax(np.abs(record.speed - record.speed[0]) > _MOVED))) * step)
