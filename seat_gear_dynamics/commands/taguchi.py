"""`seat-gear taguchi`: which factors drive vibration and impact, their best levels, and the proof."""

import argparse
import json
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from collections.abc import Mapping

    from seat_gear_dynamics.commands.progress import Tell
    from seat_gear_dynamics.motion import System
    from seat_gear_dynamics.studies.taguchi import Finding, Source, Study
    from seat_gear_dynamics.studies.taguchi.result import Setting
    from seat_gear_dynamics.studies.taguchi.study import Evaluate

TEXTS = {
    "taguchi": Texts(
        "Taguchi study of vibration and impact: factors that matter, best levels, confirmation",
        "seat-gear taguchi --response vibration --output taguchi",
    )
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("--response", choices=("vibration", "impact", "both"), default="both", help="default: both")
    parser.add_argument("--array", metavar="NAME", help="orthogonal array, as in L18 (default: the smallest that fits)")
    parser.add_argument("--speed-rpm", type=float, metavar="N", help="speed of s1 to study around (default: Ω = 0.5)")
    parser.add_argument("--load", type=float, metavar="T4", help="load torque to study around, N·m (default 600)")
    parser.add_argument("--output", metavar="DIR", type=Path, help="also write tables (CSV) and pictures (PNG) there")


def run(arguments: argparse.Namespace) -> int:
    """Run the study and print it."""
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.progress import progress
    from seat_gear_dynamics.studies.taguchi import RESPONSES, vibration_and_impact

    responses = RESPONSES if arguments.response == "both" else (arguments.response,)
    try:
        system = _system(arguments)
        with progress("experiments", quiet=arguments.json) as tell:
            evaluate = _counted(system, _experiments(system, arguments.array, len(responses)), tell)
            study = vibration_and_impact(system, responses=responses, array=arguments.array, evaluate=evaluate)
    except ValueError as error:
        raise CommandError(str(error)) from error
    files = [] if arguments.output is None else _write(study, arguments.output)
    if arguments.json:
        print(json.dumps({**study.as_dict(), "files": [str(file) for file in files]}))
        return 0
    print("\n".join(_lines(study)))
    print(*(f"written: {file}" for file in files), sep="\n")
    return 0


def _system(arguments: argparse.Namespace) -> "System":
    from seat_gear_dynamics.gears.units import RPM
    from seat_gear_dynamics.motion import load_system

    rpm = arguments.speed_rpm
    return load_system(arguments.system).at(speed=None if rpm is None else rpm * RPM, load=arguments.load)


def _experiments(system: "System", array: str | None, responses: int) -> int:
    """Return how many experiments the study has at most: array, present design and an optimum for each response."""
    from seat_gear_dynamics.studies.taguchi import CONTROLS, NOISE, orthogonal_array, smallest_array

    controls, noise = (
        [len(factor.levels) for each in variations if (factor := each.factor(system)) is not None]
        for variations in (CONTROLS, NOISE)
    )
    inner = orthogonal_array(array) if array is not None else smallest_array(controls)
    return (inner.runs + 1 + responses) * (smallest_array(noise).runs if noise else 1)


def _counted(system: "System", most: int, tell: "Tell") -> "Evaluate":
    """Return the study's own experiment, which tells when each one is done."""
    from seat_gear_dynamics.studies.taguchi import CONTROLS, NOISE, experiment

    evaluate, done = experiment(system, [*CONTROLS, *NOISE]), count(1)

    def counted(setting: "Setting") -> "Mapping[str, float]":
        try:
            return evaluate(setting)
        finally:
            tell(next(done), most)

    return counted


def _lines(study: "Study") -> list[str]:
    conditions = 1 if study.noise_array is None else study.noise_array.runs
    lines = [
        f"array {study.array.name}: {study.array.runs} runs of {len(study.factors)} factors, each under {conditions} "
        f"noise conditions ({', '.join(factor.name for factor in study.noise)})"
    ]
    if study.diverged:
        lines.append(f"left out, because an experiment failed: runs {', '.join(map(str, study.diverged))}")
    for finding in study.findings.values():
        lines += ["", *_finding_lines(study, finding)]
    return [
        *lines,
        "",
        "A model repeats exactly: the error is what main effects miss; F and p rank factors, no more. Interactions",
        "also hide in the factors: trust a small share only if it stays in another array (--array L27).",
    ]


def _finding_lines(study: "Study", finding: "Finding") -> list[str]:
    analysis = finding.analysis
    if analysis is None:
        return [f"{finding.response}: no analysis. {finding.reason}"]
    pooled = ", ".join(analysis.pooled) or "none"
    lines = [
        f"{finding.response}: mean S/N ratio {analysis.mean:.2f} dB; pooled into the error: {pooled}",
        f"  {'source':20s}{'df':>4s}{'sum of sq.':>12s}{'mean sq.':>11s}{'F':>9s}{'p':>9s}{'share':>8s}",
        *(_source_line(source) for source in (*analysis.factors, analysis.error, analysis.total)),
        f"  {'level':20s}{'present':>12s}{'best':>12s}",
    ]
    for factor in study.factors:
        present, best = factor.levels[factor.start], factor.levels[analysis.best_levels[factor.name]]
        mark = ", pooled" if factor.name in analysis.pooled else ""
        lines.append(f"  {factor.name:20s}{present:12.4g}{best:12.4g} {factor.unit}{mark}")
    return [*lines, *_proof_lines(finding)]


def _source_line(source: "Source") -> str:
    mean = "" if source.mean_square is None or source.name == "total" else f"{source.mean_square:.3f}"
    f = "pooled" if source.pooled else "" if source.f is None else f"{source.f:.2f}"
    p = "" if source.p is None else f"{source.p:.4f}"
    return (
        f"  {source.name:20s}{source.degrees_of_freedom:4d}{source.sum_of_squares:12.3f}{mean:>11s}{f:>9s}{p:>9s}"
        f"{source.contribution:8.1%}"
    )


def _proof_lines(finding: "Finding") -> list[str]:
    predicted, confirmed = finding.predicted, finding.confirmed
    lines = []
    if predicted is not None:
        low, high = predicted.interval or (None, None)
        bounds = "no interval" if low is None else f"{predicted.confidence:.0%} of runs {low:.2f} to {high:.2f}"
        lines.append(f"  predicted at the best levels: {predicted.value:.2f} dB ({bounds})")
    if confirmed is None:
        return [*lines, "  confirmation run: failed"]
    verdict = {True: "within the interval", False: "OUTSIDE the interval: factors interact", None: "no interval"}
    lines.append(f"  confirmation run:             {confirmed:.2f} dB, {verdict[finding.within]}")
    if finding.gain is not None:
        lines.append(f"  gain over the present design: {finding.gain:.2f} dB; {_means(finding)}")
    return lines


def _means(finding: "Finding") -> str:
    assert finding.best is not None
    before, after = finding.start.mean(finding.response), finding.best.mean(finding.response)
    return f"mean {finding.response} {before:.3f} before, {after:.3f} after"


def _write(study: "Study", folder: Path) -> list[Path]:
    """Write tables and pictures; return their paths."""
    from seat_gear_dynamics.studies.taguchi import tables

    folder.mkdir(parents=True, exist_ok=True)
    contents = {
        "runs.csv": tables.run_rows(study),
        "ratios.csv": tables.ratio_rows(study),
        "variance.csv": tables.variance_rows(study),
        "effects.csv": tables.effect_rows(study),
    }
    for name, rows in contents.items():
        _write_rows(folder / name, rows)
    pictures = [picture for finding in study.findings.values() for picture in _draw(study, finding, folder)]
    return [*(folder / name for name in contents), *pictures]


def _write_rows(path: Path, rows: list[dict[str, Any]]) -> None:
    import csv

    columns = list(dict.fromkeys(column for row in rows for column in row))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)


def _draw(study: "Study", finding: "Finding", folder: Path) -> list[Path]:
    from seat_gear_dynamics.views.figures.main_effects import MainEffect, main_effects
    from seat_gear_dynamics.views.figures.style import save

    analysis = finding.analysis
    if analysis is None:
        return []
    effects = [
        MainEffect(f.name, f.unit, f.levels, analysis.effects[f.name], source.contribution, source.pooled)
        for f, source in zip(study.factors, analysis.factors, strict=True)
    ]
    path = folder / f"main_effects_{finding.response}.png"
    save(main_effects(effects, mean=analysis.mean, title=f"Main effects on {finding.response}"), path)
    return [path]
