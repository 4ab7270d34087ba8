"""`seat-gear quality`: labelled runs of a simulated bench through the monitor's session, and the warning's scores."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.output import PICTURE_ENDINGS, path_ending_in
from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from seat_gear_dynamics.regimes.regime_map import RegimeMap
    from seat_gear_dynamics.sensing import BandSource
    from seat_gear_dynamics.studies.warning_quality.assess import Assessment, Outcome
    from seat_gear_dynamics.studies.warning_quality.score import Roc, Tally

TEXTS = {
    "quality": Texts(
        "score the warning on labelled runs: missed, false, delay, notice, chatter, ROC",
        "seat-gear quality --runs 20 --seed 1",
    )
}
_ACCELERATIONS = (50.0, 100.0, 200.0, 400.0)
_PUBLISHED_LOADS = (500.0, 650.0)  # N·m around the 600 at which bands were published
_WITHIN = 0.1  # share of the map's loads kept clear of at its ends: beyond them the level is STALE


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("--runs", type=int, default=240, metavar="N", help="runs, ten kinds in turn (default 240)")
    parser.add_argument(
        "--seed",
        type=int,
        nargs="+",
        default=[1],
        metavar="S",
        help="of the runs; so many runs for each (default 1)",
    )
    parser.add_argument("--bands", choices=("map", "published"), default="map", help="source of bands (default map)")
    parser.add_argument("--map", type=Path, metavar="F.npz", help="of `seat-gear map` (default: the packaged one)")
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: as many as processors)")
    parser.add_argument("--output", type=path_ending_in(".json"), metavar="F.json", help="write all scores")
    parser.add_argument(
        "--plot", type=path_ending_in(*PICTURE_ENDINGS), metavar="F.png", help="draw ROC, notice, delay (PNG, SVG, PDF)"
    )
    parser.set_defaults(wrong_use=parser.error)


def run(arguments: argparse.Namespace) -> int:
    """Play, score, write, draw and print."""
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.regimes.regime_map import MapError
    from seat_gear_dynamics.studies.warning_quality.assess import gathered

    if arguments.runs < 1 or min(arguments.seed) < 0 or (arguments.workers is not None and arguments.workers < 1):
        arguments.wrong_use("--runs and --workers are at least 1, --seed at least 0")
    try:
        found = gathered(_outcomes(arguments))
    except (MapError, ValueError) as error:
        raise CommandError(str(error)) from error
    values = _summary(arguments, found)
    if arguments.output:
        arguments.output.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")
    if arguments.plot:
        from seat_gear_dynamics.views.figures.style import save
        from seat_gear_dynamics.views.figures.warning_quality import warning_quality_figure

        save(warning_quality_figure(found), arguments.plot)
    print(json.dumps(values) if arguments.json else "\n".join(_lines(values)))
    return 0


def _outcomes(arguments: argparse.Namespace) -> "list[Outcome]":
    """Return what each run gave, in order; runs are shared out over processes, which changes nothing."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context
    from os import cpu_count

    from seat_gear_dynamics.commands.progress import progress, stages
    from seat_gear_dynamics.gears import load_train
    from seat_gear_dynamics.studies.warning_quality.assess import known_motions
    from seat_gear_dynamics.studies.warning_quality.job import Job, play_job
    from seat_gear_dynamics.studies.warning_quality.scenarios import suite

    train = load_train(arguments.system)
    nominal = _map(arguments, train)
    source, loads = _source(arguments, train, nominal)
    scenarios = [each for seed in arguments.seed for each in suite(source, loads, seed=seed, count=arguments.runs)]
    with stages(quiet=arguments.json) as tell_stage:
        known = known_motions(scenarios, train, tell=tell_stage)
    jobs = [Job(scenario, train, nominal, arguments.bands, known) for scenario in scenarios]
    found: list[Outcome] = []
    workers = arguments.workers or cpu_count() or 1
    with (
        progress(f"{len(jobs)} runs", quiet=arguments.json) as tell,
        ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool,
    ):
        for outcome in pool.map(play_job, jobs):
            found.append(outcome)
            tell(len(found), len(jobs))
    return found


def _map(arguments: argparse.Namespace, train: Any) -> "RegimeMap":
    from seat_gear_dynamics.regimes.regime_map import RegimeMap
    from seat_gear_dynamics.sensing import packaged_map

    path = arguments.map or packaged_map()
    with path.open("rb") as file:
        return RegimeMap.load(file, train)


def _source(
    arguments: argparse.Namespace, train: Any, nominal: "RegimeMap"
) -> "tuple[BandSource, tuple[float, float]]":
    from seat_gear_dynamics.studies.warning_quality.job import band_source

    source = band_source(arguments.bands, train, nominal)
    if arguments.bands == "published":
        return source, _PUBLISHED_LOADS
    first, last = float(nominal.loads[0]), float(nominal.loads[-1])
    clear = _WITHIN * (last - first)
    return source, (first + clear, last - clear)


def _summary(arguments: argparse.Namespace, found: "Assessment") -> dict[str, Any]:
    return {
        "bands": arguments.bands,
        "seed": arguments.seed,
        "whole": _tally(found.whole),
        "families": {name: _tally(each) for name, each in found.families.items()},
        "median_notice": _notices(found, 0.0),
        "median_notice_begun_1_s_before": _notices(found, 1.0),
        "roc": {name: _roc(each) for name, each in found.rocs.items()},
        "machine_roc": {name: _roc(each) for name, each in found.machine_rocs.items()},
    }


def _notices(found: "Assessment", lead: float) -> dict[str, float | None]:
    medians = {f"{a:g}": found.median_notice(a, lead=lead) for a in _ACCELERATIONS}
    return {name: None if notice != notice else notice for name, notice in medians.items()}


def _tally(found: "Tally") -> dict[str, Any]:
    from seat_gear_dynamics.studies.warning_quality.score import poisson_upper

    rates = {
        "false_errors_per_hour": found.per_hour(found.false_errors),
        "false_errors_per_hour_upper_95": found.per_hour(1) * poisson_upper(found.false_errors),
        "false_warnings_per_hour": found.per_hour(found.false_warnings),
        "missed_per_hour": found.per_hour(found.missed),
    }
    return {**vars(found), **rates}


def _roc(found: "Roc") -> dict[str, Any]:
    points = {name: getattr(found, name).tolist() for name in ("thresholds", "true_rate", "false_rate")}
    return {"area": found.area, "positives": found.positives, "negatives": found.negatives, **points}


def _lines(values: dict[str, Any]) -> list[str]:
    from statistics import median

    whole = values["whole"]
    delays = whole["delays"]
    notices, early = (
        ", ".join(f"{a} r/min/s {n:.2f} s" for a, n in values[name].items() if n is not None)
        for name in ("median_notice", "median_notice_begun_1_s_before")
    )
    areas = ", ".join(f"{name} {each['area']:.4f}" for name, each in values["roc"].items())
    machine = ", ".join(f"{name} {each['area']:.3f}" for name, each in values["machine_roc"].items())
    lines = [
        f"{whole['runs']} runs, {whole['seconds']:.0f} s of bench time, bands: {values['bands']}, "
        f"seed {' '.join(map(str, values['seed']))}",
        f"stays over 0.5 s inside a band: {whole['stays']}, missed {whole['missed']}, never seen {whole['unseen']}",
        f"false ERROR: {whole['false_errors']} ({whole['false_errors_per_hour']:.2f} an hour, at 95 % below "
        f"{whole['false_errors_per_hour_upper_95']:.2f}); doubtful, by motion that may be either: "
        f"{whole['doubtful_errors']}",
        f"WARN without cause: {whole['false_warnings']} ({whole['false_warnings_per_hour']:.1f} an hour)",
        f"on the edge: {whole['edge_changes']} level changes in {whole['edge_seconds']:.0f} s",
        f"chaos outside bands, over 1 s: {whole['chaos_stays']}, with ERROR {whole['chaos_seen']}",
    ]
    lines += [f"delay to ERROR: median {median(delays):.2f} s, longest {max(delays):.2f} s"] if delays else []
    lines += [f"median notice before ramps: {notices}"] if notices else []
    lines += [f"of those that began 1 s or more before the band: {early}"] if early else []
    lines += [f"area under the ROC: {areas}"] if areas else []
    return lines + ([f"area for the chaos of machines within tolerances: {machine}"] if machine else [])
