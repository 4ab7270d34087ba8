"""Many labelled runs scored together: what the command and the tests call."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.regimes.regime_map import RegimeMap
from seat_gear_dynamics.sensing import AlarmSettings, BandSource
from seat_gear_dynamics.studies.warning_quality.machine import drawn_machine, machine_motions, machine_samples
from seat_gear_dynamics.studies.warning_quality.run import SCORES, play
from seat_gear_dynamics.studies.warning_quality.scenarios import Scenario
from seat_gear_dynamics.studies.warning_quality.score import Roc, Tally, rates, rocs, samples, tally
from seat_gear_dynamics.studies.warning_quality.truth import Answer, Drive, motions, steady_points, truth

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one run gave."""

    family: str
    counts: Tally
    samples: tuple[Array, Flags, Flags]
    """Scores and labels for the ROC."""
    machine: tuple[Array, Flags]
    """Scores and labels for the ROC against a machine that is not the model."""


@dataclass(frozen=True, eq=False)
class Assessment(Plottable, figure="warning_quality:plot_assessment", table="studies:assessment_table"):
    """Scores of a suite."""

    whole: Tally
    families: dict[str, Tally]
    rocs: dict[str, Roc]
    """By score, and `ahead`; empty where the runs hold only one class."""
    machine_rocs: dict[str, Roc]
    """By score, for the chaos of machines drawn within tolerances."""

    def median_notice(self, acceleration: float, *, lead: float = 0.0) -> float:
        """Return the median notice before ramps of `acceleration` (r/min per s), s; NaN where there was none.

        Only ramps count that had begun `lead` (s) or more before they entered; where that is not known, it is 0.
        """
        ramps = zip(self.whole.notices, self.whole.leads or repeat(0.0))  # noqa: B905 (repeat has no end)
        found = [notice for (of, notice), begun in ramps if of == acceleration and begun >= lead]
        return float(np.median(found)) if found else float("nan")


def known_motions(
    scenarios: Sequence[Scenario],
    train: GearTrain,
    workers: int | None = None,
    tell: Callable[[str, int, int], None] | None = None,
) -> dict[Drive, Answer]:
    """Return the motion at every steady point of the runs; `tell` gets (stage, done, in all)."""
    told = tell or (lambda stage, done, total: None)
    points: set[Drive] = set()
    for k, scenario in enumerate(scenarios):
        points.update(steady_points(scenario))
        told("drives of the runs", k + 1, len(scenarios))
    return motions(
        train, points, workers=workers, progress=lambda done, total: told("motions where they dwell", done, total)
    )


def outcome(
    scenario: Scenario,
    train: GearTrain,
    source: BandSource,
    settings: AlarmSettings,
    known: dict[Drive, Answer],
    nominal: RegimeMap,
) -> Outcome:
    """Play one run and hold it against the truth; arguments as `truth` has them."""
    record = play(scenario, train, source, settings)
    true = truth(record, source, known, nominal)
    machine = drawn_machine(train, scenario.seed)
    own = machine_samples(record, machine_motions(machine, steady_points(scenario)))
    return Outcome(scenario.family, tally(record, true, settings), samples(record, true), own)


def gathered(outcomes: Sequence[Outcome]) -> Assessment:
    """Return the scores of all outcomes together and by family; the order of outcomes changes no count."""
    families: dict[str, Tally] = {}
    for each in outcomes:
        families[each.family] = families.get(each.family, Tally()) + each.counts
    drawn = [each.samples for each in outcomes]
    now = np.concatenate([each[1] for each in drawn]) if drawn else np.zeros(0, dtype=bool)
    curves = rocs(drawn) if now.any() and not now.all() else {}
    scores = np.concatenate([each.machine[0] for each in outcomes]) if outcomes else np.empty((0, len(SCORES)))
    label = np.concatenate([each.machine[1] for each in outcomes]) if outcomes else np.zeros(0, dtype=bool)
    both = (
        {name: rates(scores[:, k], label) for k, name in enumerate(SCORES)} if label.any() and not label.all() else {}
    )
    return Assessment(sum(families.values(), Tally()), dict(sorted(families.items())), curves, both)


def assess(
    scenarios: Sequence[Scenario],
    train: GearTrain,
    source: BandSource,
    nominal: RegimeMap,
    settings: AlarmSettings | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Assessment:
    """Play all runs one after the other and score them; `nominal` as `truth`; `progress` is told (done, in all)."""
    known, chosen = known_motions(scenarios, train), settings or AlarmSettings()
    found = []
    for k, scenario in enumerate(scenarios):
        found.append(outcome(scenario, train, source, chosen, known, nominal))
        if progress is not None:
            progress(k + 1, len(scenarios))
    return gathered(found)
