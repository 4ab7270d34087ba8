"""A scenario through the monitor's own session, faster than real time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.sensing import AlarmSettings, BandSource, Level, RejectedSampleError, Session, Verdict
from seat_gear_dynamics.studies.warning_quality.scenarios import Scenario

Array = NDArray[np.float64]

SCORES = ("danger", "place", "motion", "map")
"""Columns of `Record.scores`: fused, and its parts."""


@dataclass(frozen=True, eq=False)
class Record:
    """What was true and what was said, sample by sample; n samples."""

    scenario: Scenario
    time: Array
    """s, (n,)"""
    speed: Array
    """True speed, rad/s of s1, (n,)."""
    load: Array
    """True load, N·m, (n,)."""
    level: NDArray[np.int64]
    """Shown level, (n,)."""
    in_band: NDArray[np.bool_]
    """Trip signal, (n,)."""
    by_motion: NDArray[np.bool_]
    """Whether the running model's chaos, and no band, makes an error at this moment, (n,)."""
    scores: Array
    """Probabilities by SCORES, (n, 4); NaN where nothing was judged."""


def play(scenario: Scenario, train: GearTrain, source: BandSource, settings: AlarmSettings | None = None) -> Record:
    """Return the record of a run: measured samples go to a `Session`, true ones to the record."""
    session, bench = Session(train, settings=settings, bands=source), scenario.bench()
    rows: list[tuple[float, ...]] = []
    for _ in range(round(scenario.profile.duration / scenario.sample_time)):
        sample = bench.step()
        try:
            verdict = session.feed(sample.t, sample.speed, sample.load).verdict
        except RejectedSampleError:
            verdict = session.verdict
        rows.append((sample.t, sample.true_speed, sample.true_load, *_said(verdict)))
    table = np.array(rows)
    time, speed, load = table[:, :3].T
    level, flags = table[:, 3].astype(np.int64), table[:, 4:6] > 0
    return Record(scenario, time, speed, load, level, flags[:, 0], flags[:, 1], table[:, 6:])


def _said(verdict: Verdict) -> tuple[float, ...]:
    strongest = dict.fromkeys(("band", "approach", "motion", "probability"), 0.0)
    for each in verdict.evidence:
        strongest[each.kind] = each.probability
    errors = {each.kind for each in verdict.evidence if each.level == Level.ERROR}
    danger = np.nan if verdict.danger is None else verdict.danger
    place = max(strongest["band"], strongest["approach"])
    flags = (float(verdict.level), float(verdict.in_band), float(errors == {"motion"}))
    return (*flags, danger, place, strongest["motion"], strongest["probability"])
