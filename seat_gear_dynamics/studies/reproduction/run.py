"""The whole reproduction: every survey the claims need, then the claims."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from seat_gear_dynamics.motion import History, System, history
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.regimes.points import Point
from seat_gear_dynamics.studies.contact_verification import (
    CONDITIONS,
    ConditionRun,
    ForceHistory,
    findings,
    run_condition,
    start_up,
)
from seat_gear_dynamics.studies.reproduction import frequency, parameters
from seat_gear_dynamics.studies.reproduction.announced import Announced, announced, announced_claim
from seat_gear_dynamics.studies.reproduction.claim import Claim
from seat_gear_dynamics.studies.reproduction.errata import Erratum, errata
from seat_gear_dynamics.studies.reproduction.geometry import mesh_stiffness_claim
from seat_gear_dynamics.studies.reproduction.survey import TRANSIENT, Seen, survey
from seat_gear_dynamics.studies.reproduction.verification import as_claim

Progress = Callable[[str, int, int], None]
"""Called with (what is under way, done, in all)."""
LITTLE_DAMPING = 0.03
"""Of C8."""


@dataclass(frozen=True, eq=False)
class Reproduction:
    """Everything that was computed, and what it says of the paper's claims."""

    system: System
    claims: tuple[Claim, ...]
    errata: tuple[Erratum, ...]
    over_frequency: Mapping[float, Sequence[Seen]]
    """Surveys of Fig. 8 and 11 by damping ratio."""
    over_load: Sequence[Seen]
    over_backlash: Sequence[Seen]
    motions: Mapping[str, tuple[System, History]]
    """The motions of Figs 9, 10, 12, 13, 14 by figure."""
    conditions: Mapping[int, ConditionRun]
    start_ups: Mapping[int, ForceHistory]
    announced: Announced


def reproduce(system: System, progress: Progress | None = None) -> Reproduction:
    """Return the reproduction of the paper on `system`; takes minutes.

    Every motion starts from rest at static deflection, runs in for 1000 mesh periods and is judged on 800. Raises
    DivergedError where a motion of a figure blows up; in a survey that is an outcome.
    """

    def told(what: str) -> Callable[[int, int], None]:
        return lambda done, total: None if progress is None else progress(what, done, total)

    train = system.train
    sweeps = {
        xi: survey(train, frequency.frequency_points(damping_ratio=xi), told(f"Ω at ξ {xi}"))
        for xi in (LITTLE_DAMPING, *parameters.DAMPING_RATIOS)
    }
    close = survey(train, frequency.close_points(), told("Ω about 1.29"))
    loads = survey(train, parameters.load_points(), told("T4"))
    backlashes = survey(train, parameters.backlash_points(), told("backlash"))
    conditions = _conditions(system, told("Table 3"))
    start_ups = {n: start_up(train, CONDITIONS[n]) for n in (4, 5, 6, 7, 8, 9)}
    extra = announced(system, told("harmonic balance and Taguchi"))
    main = sweeps[parameters.DAMPING_RATIOS[0]]
    damped = {xi: sweeps[xi] for xi in parameters.DAMPING_RATIOS}
    backlash_claim = parameters.backlash_study(backlashes, train.model.displacement_scale)
    claims = (
        frequency.period_one(main),
        frequency.narrow_window(close),
        frequency.wide_band(main),
        frequency.three_curves(main),
        frequency.calm_elsewhere(main),
        frequency.band_speeds(train),
        parameters.stable_region(damped),
        parameters.period_four(sweeps[LITTLE_DAMPING]),
        parameters.load_study(loads),
        backlash_claim,
        *map(as_claim, findings(conditions, start_ups)),
        mesh_stiffness_claim(train),
        announced_claim(extra),
    )
    motions = _motions(system, sweeps[LITTLE_DAMPING], float(backlash_claim.figures["length_unit"]))
    return Reproduction(
        system, claims, tuple(errata(train)), sweeps, loads, backlashes, motions, conditions, start_ups, extra
    )


def _conditions(system: System, progress: Callable[[int, int], None]) -> dict[int, ConditionRun]:
    runs: dict[int, ConditionRun] = {}
    for number, condition in CONDITIONS.items():
        runs[number] = run_condition(system.train, condition)
        progress(len(runs), len(CONDITIONS))
    return runs


def _motions(system: System, little_damping: Sequence[Seen], length_unit: float) -> dict[str, tuple[System, History]]:
    """Return the motions that the paper draws, each at its own point."""
    four = next((s.point.frequency for s in little_damping if s.period == 4), 1.0)
    wanted = {
        "Fig. 9": Point(0.7, frequency.LOAD),
        "Fig. 10": Point(1.98, frequency.LOAD),
        "Fig. 12": Point(four, frequency.LOAD, damping_ratio=LITTLE_DAMPING),
        "Fig. 13": Point(1.0, parameters.LIGHT_LOAD, backlash=5.5 * length_unit),
        "Fig. 14": Point(1.0, parameters.LIGHT_LOAD, backlash=6.0 * length_unit),
    }
    found = {}
    for name, point in wanted.items():
        train = system.train
        for index in (0, 1):
            train = train.with_mesh(index, damping_ratio=point.damping_ratio, backlash=point.backlash)
        own = System(train).at(frequency=point.frequency, load=point.load)
        try:
            found[name] = (own, history(own, transient=TRANSIENT))
        except DivergedError as error:
            raise DivergedError(f"{name}: {error}") from error
    return found
