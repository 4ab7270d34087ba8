"""A Taguchi study of any response: control factors in an inner array, noise factors in an outer one, optimum, proof.

Taguchi's parameter design: every run of the inner array is made under every condition of the outer one; the scatter and
the level over the outer array become one signal-to-noise ratio, the ratios are analysed, and the best levels are run.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice
from math import isfinite

import numpy as np

from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.studies.taguchi.orthogonal_arrays import (
    Levels,
    orthogonal_array,
    smallest_array,
)
from seat_gear_dynamics.studies.taguchi.result import Factor, Finding, Outcome, Run, Setting, Study
from seat_gear_dynamics.studies.taguchi.signal_to_noise import Array, smaller_the_better
from seat_gear_dynamics.studies.taguchi.variance import Analysis, analyse, weakest_factors

Evaluate = Callable[[Setting], Mapping[str, float]]
"""The experiment: values of all control and noise factors by name, to a value of each response by name.

It must be safe to call in several threads at once. An experiment that has no result raises DivergedError."""
Ratio = Callable[[Array], Array]


def run_study(
    factors: Sequence[Factor],
    evaluate: Evaluate,
    responses: Sequence[str],
    *,
    noise: Sequence[Factor] = (),
    array: str | None = None,
    ratio: Ratio = smaller_the_better,
    pooled: Sequence[str] | None = None,
    confidence: float = 0.95,
    workers: int = 2,
) -> Study:
    """Run a Taguchi study of `evaluate` and return it, with the present design and the confirmation of every optimum.

    `array` names the inner array (default: the smallest one); the outer one is the smallest that fits `noise`, and one
    condition without noise factors. `ratio` makes the observations of a run, shape (conditions,), one number. `pooled`
    names the factors counted into the error; by default the weakest ones, to half of the degrees of freedom. The
    experiments run in `workers` threads; the result does not depend on their number.

    A run with a failed experiment (DivergedError, or a response that is not finite) is kept with its failure and left
    out of the analysis, which flatters its levels: look at `Study.diverged`. Where the rest does not carry an analysis
    the finding says why. Raises ValueError for factors that fit no array, names used twice or unknown, an experiment
    that lacks a response, and observations that `ratio` refuses.

    Limit: an experiment on a computer repeats exactly. The error is then no chance but what an additive model misses:
    interactions, and whatever the pooled factors do. F and p rank factors; they are no proof.
    """
    names = [factor.name for factor in (*factors, *noise)]
    if len(set(names)) != len(names) or not responses:
        raise ValueError(f"The factors are {names} and the responses {list(responses)}; expected different names.")
    if unknown := set(pooled or ()) - {factor.name for factor in factors}:
        raise ValueError(f"To be pooled is {sorted(unknown)}, expected control factors of {names[: len(factors)]}.")
    inner = orthogonal_array(array) if array is not None else smallest_array(_counts(factors))
    outer = smallest_array(_counts(noise)) if noise else None
    plan = inner.assigned(_counts(factors))
    conditions = [_at(noise, row) for row in outer.assigned(_counts(noise))] if outer is not None else [{}]
    start = [factor.start for factor in factors]

    def runs(levels: Sequence[Sequence[int]]) -> list[Run]:
        return _runs(factors, levels, conditions, evaluate, responses, ratio, workers)

    *made, present = runs([*plan.tolist(), start])
    analyses = {response: _analysed(factors, plan, made, response, pooled) for response in responses}
    optima = {r: a for r, (a, _) in analyses.items() if a is not None}
    confirmations = runs([[a.best_levels[f.name] for f in factors] for a in optima.values()])
    best = dict(zip(optima, confirmations, strict=True))
    findings = {r: _finding(r, *analyses[r], present, best.get(r), confidence) for r in responses}
    return Study(inner, outer, tuple(factors), tuple(noise), tuple(made), findings, confidence)


def _counts(factors: Sequence[Factor]) -> list[int]:
    return [len(factor.levels) for factor in factors]


def _at(factors: Sequence[Factor], levels: Sequence[int] | Levels) -> dict[str, float]:
    return {factor.name: factor.levels[int(level)] for factor, level in zip(factors, levels, strict=True)}


def _runs(
    factors: Sequence[Factor],
    levels: Sequence[Sequence[int]],
    conditions: Sequence[Setting],
    evaluate: Evaluate,
    responses: Sequence[str],
    ratio: Ratio,
    workers: int,
) -> list[Run]:
    """Return the runs at `levels`, in their order, each under all conditions."""
    settings = [_at(factors, row) for row in levels]
    experiments = [(setting, condition) for setting in settings for condition in conditions]
    with ThreadPoolExecutor(max_workers=workers) as pool:
        outcomes = pool.map(lambda experiment: _outcome(evaluate, responses, *experiment), experiments)
        groups = [tuple(islice(outcomes, len(conditions))) for _ in settings]
    runs = []
    for row, setting, group in zip(levels, settings, groups, strict=True):
        run = Run({f.name: int(level) for f, level in zip(factors, row, strict=True)}, setting, group, {})
        if not run.failures:
            ratios = {r: float(ratio(np.array([outcome.values[r] for outcome in group]))) for r in responses}
            run = replace(run, ratios=ratios)
        runs.append(run)
    return runs


def _outcome(evaluate: Evaluate, responses: Sequence[str], setting: Setting, condition: Setting) -> Outcome:
    try:
        values = evaluate({**setting, **condition})
    except DivergedError as error:
        return Outcome(condition, {}, str(error))
    if missing := set(responses) - set(values):
        raise ValueError(f"The experiment gives {sorted(values)}, and not {sorted(missing)}; name responses it gives.")
    lost = [response for response in responses if not isfinite(values[response])]
    if lost:
        return Outcome(condition, {}, f"The response {lost[0]} is {values[lost[0]]}, expected a finite number.")
    return Outcome(condition, {name: float(value) for name, value in values.items()})


def _analysed(
    factors: Sequence[Factor], plan: Levels, runs: Sequence[Run], response: str, pooled: Sequence[str] | None
) -> tuple[Analysis | None, str | None]:
    """Return the analysis of the runs that have a ratio, or why there is none."""
    whole = [index for index, run in enumerate(runs) if not run.failures]
    design, ratios = plan[whole], [runs[index].ratios[response] for index in whole]
    names, counts = [factor.name for factor in factors], _counts(factors)
    try:
        analysis = analyse(design, ratios, names, level_counts=counts, pooled=pooled or ())
    except ValueError as error:
        return None, f"{len(runs) - len(whole)} of {len(runs)} runs failed. {error}"
    if pooled is None:
        analysis = analyse(design, ratios, names, level_counts=counts, pooled=weakest_factors(analysis))
    return analysis, None


def _finding(
    response: str, analysis: Analysis | None, reason: str | None, start: Run, best: Run | None, confidence: float
) -> Finding:
    if analysis is None or best is None:
        return Finding(response, analysis, reason, start, None, best, None)
    predicted_start, predicted = (analysis.predict(run.levels, confidence=confidence) for run in (start, best))
    return Finding(response, analysis, reason, start, predicted_start, best, predicted)
