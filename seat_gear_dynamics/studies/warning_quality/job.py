"""One labelled run as a piece of work that a process can be handed."""

from dataclasses import dataclass

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.regimes.regime_map import RegimeMap
from seat_gear_dynamics.sensing import AlarmSettings, BandSource, MapBands, PublishedBands
from seat_gear_dynamics.studies.warning_quality.assess import Outcome, outcome
from seat_gear_dynamics.studies.warning_quality.scenarios import Scenario
from seat_gear_dynamics.studies.warning_quality.truth import Answer, Drive


@dataclass(frozen=True, eq=False)
class Job:
    """All that a run needs; can be pickled."""

    scenario: Scenario
    train: GearTrain
    nominal: RegimeMap
    bands: str
    """`map` or `published`."""
    known: dict[Drive, Answer]


def band_source(name: str, train: GearTrain, nominal: RegimeMap) -> BandSource:
    """Return the source of bands called `map` or `published`; raises ValueError for another name."""
    if name == "map":
        return MapBands(nominal, train)
    if name == "published":
        return PublishedBands.of(train)
    raise ValueError(f"The source of bands is {name!r}, expected map or published.")


def play_job(job: Job) -> Outcome:
    """Play the run with the alarm's default settings and score it."""
    source = band_source(job.bands, job.train, job.nominal)
    return outcome(job.scenario, job.train, source, AlarmSettings(), job.known, job.nominal)
